//! The NC program and the current block.
//!
//! *Invariant:* searching never moves the reading position. Facts: reference functions.md 9, macro-language.md 3.3.

use std::collections::{BTreeMap, HashMap};

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::ident;
use counterpoint_lang::state::MacroState;
use counterpoint_lang::value::MacroValue;

use crate::text;
use crate::variables::SystemTable;

/// Settings of the pre-processors: the first texts of `$FCEPP`.
const SETTINGS: [&str; 15] = [
    "PROCESS,COMMENTS",
    "PROCESS,MESSAGES",
    "PROCESS,SUBPROGRAMS",
    "PROCESS,SEQNAME",
    "PROCESS,SYSVARASSIGNMENT",
    "USENULL",
    "APPLYFRAMES",
    "GLOBALDEF",
    "PROCESSGUDFILES",
    "SETFILEROOT",
    "COLLAPSEASSIGNSPACES",
    "COLLAPSEASSIGNS",
    "SETALSEVERITY",
    "CYCLEDEF",
    "SPINDLECYCLES",
];

/// An NC program.
#[derive(Debug, Default)]
pub struct NcProgram {
    /// Its blocks.
    pub blocks: Vec<String>,
    /// Its variables by name, upper case, indices in brackets.
    pub variables: BTreeMap<String, MacroValue>,
    /// Position of the block read next.
    next: usize,
    pub(crate) block: CurrentBlock,
}

/// Data of the current block, modal values, active codes.
#[derive(Debug, Default)]
pub(crate) struct CurrentBlock {
    /// Identifiers with their values; none for a code without one.
    items: Vec<(MacroValue, MacroValue)>,
    modal: Vec<(MacroValue, MacroValue)>,
    active: Vec<(u16, u32)>,
    /// Modal groups of codes.
    groups: HashMap<u32, u16>,
}

fn same(a: &MacroValue, b: &MacroValue) -> bool {
    a.equals(b) == Some(true)
}

impl CurrentBlock {
    pub(crate) fn put(&mut self, item: MacroValue, value: f64) {
        if matches!(item, MacroValue::Register(_)) {
            self.modal.push((item.clone(), MacroValue::Real(value)));
        }
        self.items.push((item, MacroValue::Real(value)));
    }

    pub(crate) fn group(&mut self, code: u32, group: u16) {
        self.groups.insert(code, group);
    }

    pub(crate) fn add(&mut self, state: &mut MacroState, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        // Looking for an item goes through all of them, so a block pays for its length.
        state.spend(self.items.len())?;
        let Some(item) = arguments.first() else { return Ok(MacroValue::Logical(false)) };
        let known = !matches!(item, MacroValue::Code(0) | MacroValue::Register(0));
        if known {
            let value = arguments.get(1).cloned().unwrap_or(MacroValue::Real(0.0));
            self.items.push((item.clone(), value));
        }
        Ok(MacroValue::Logical(known))
    }

    pub(crate) fn seek(&mut self, arguments: &[MacroValue], take: bool) -> Outcome<MacroValue> {
        let Some(item) = arguments.first() else { return Ok(MacroValue::Null) };
        if !matches!(item, MacroValue::Code(_) | MacroValue::Register(_)) {
            return Err(MacroFault::kind("a code or data identifier", item));
        }
        let mode = match arguments.get(1) {
            Some(MacroValue::Keyword(code)) => ident::minor_name(*code).unwrap_or(""),
            _ => "",
        };
        let found = self.items.iter().position(|(other, _)| same(other, item)).filter(|_| mode != "LAST");
        if let Some(at) = found {
            let value = self.items.get(at).map_or(MacroValue::Null, |(_, value)| value.clone());
            if take {
                self.items.remove(at);
            }
            return Ok(value);
        }
        let modal = self.modal.iter().rev().find(|(other, _)| same(other, item) && !mode.is_empty());
        Ok(modal.map_or(MacroValue::Null, |(_, value)| value.clone()))
    }

    /// The active code of the group of a code; made so if `set`.
    pub(crate) fn active(&mut self, arguments: &[MacroValue], set: bool) -> MacroValue {
        let Some(MacroValue::Code(code)) = arguments.first() else { return MacroValue::Code(0) };
        let Some(group) = self.groups.get(code).copied().filter(|group| *group != 0) else {
            return MacroValue::Code(0);
        };
        let active = &mut self.active;
        let before = active.iter().find(|(other, _)| *other == group).map_or(0, |(_, code)| *code);
        if set {
            active.retain(|(other, _)| *other != group);
            active.push((group, *code));
        }
        MacroValue::Code(before)
    }
}

impl NcProgram {
    pub(crate) fn is_at_end(&self) -> bool {
        self.next >= self.blocks.len()
    }

    /// A variable of the NC program, its indices in brackets.
    fn variable_name(arguments: &[MacroValue], from: usize) -> String {
        let indices: Vec<String> = arguments
            .iter()
            .skip(from)
            .filter_map(|value| value.as_real())
            .map(counterpoint_lang::format::wildcard_text)
            .collect();
        let name = text(arguments, 0).trim().to_uppercase();
        if indices.is_empty() { name } else { format!("{name}[{}]", indices.join(",")) }
    }

    pub(crate) fn variable(&self, arguments: &[MacroValue]) -> MacroValue {
        self.variables.get(&Self::variable_name(arguments, 1)).cloned().unwrap_or(MacroValue::Null)
    }

    pub(crate) fn set_variable(&mut self, arguments: &[MacroValue]) -> MacroValue {
        let place = self.variables.get_mut(&Self::variable_name(arguments, 2));
        let value = arguments.get(1).filter(|value| !matches!(value, MacroValue::Sequence(_)));
        MacroValue::Logical(match (place, value) {
            (Some(place), Some(value)) => {
                *place = value.clone();
                true
            }
            _ => false,
        })
    }

    /// `$FGET`, `$FGETR`; the block read last is not looked at unless it is requested.
    pub(crate) fn search(
        &self,
        system: &mut SystemTable,
        state: &mut MacroState,
        arguments: &[MacroValue],
        forward: bool,
    ) -> Outcome<MacroValue> {
        let expressions: Vec<&MacroValue> = match arguments.first() {
            Some(MacroValue::Sequence(all)) => all.iter().collect(),
            Some(one) => vec![one],
            None => Vec::new(),
        };
        let mut patterns = Vec::new();
        for expression in expressions {
            let expression =
                expression.as_text().ok_or_else(|| MacroFault::kind("a regular expression", expression))?;
            patterns.push(state.pattern(expression)?);
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let record =
            |at: usize| arguments.get(at).and_then(MacroValue::as_real).map_or(0, |number| number.max(0.0) as usize);
        let count = self.blocks.len();
        let (start, end) = (record(1), record(2));
        let blocks: Vec<usize> = if forward {
            let first = if start == 0 { self.next + 1 } else { start };
            (first..=if end == 0 { count } else { end.min(count) }).collect()
        } else {
            let last = if start == 0 { self.next.saturating_sub(1) } else { start.min(count) };
            (end.max(1)..=last).rev().collect()
        };
        let mut budget = counterpoint_lang::pattern::STEPS;
        for number in blocks {
            let Some(block) = number.checked_sub(1).and_then(|at| self.blocks.get(at)).cloned() else { continue };
            state.spend(1 + block.len() / 16)?;
            for pattern in &patterns {
                state.spend(1 + block.len() / 16)?;
                if pattern.find(&block, 0, &mut budget)?.is_some() {
                    system.set("$MCDRD", MacroValue::text(block));
                    #[allow(clippy::cast_precision_loss)]
                    return Ok(MacroValue::Real(number as f64));
                }
            }
        }
        Ok(MacroValue::Real(0.0))
    }

    /// TAPERD
    pub(crate) fn read_block(&mut self, system: &mut SystemTable, state: &mut MacroState) {
        let Some(block) = self.blocks.get(self.next).cloned() else {
            state.warn(MacroFault::new(DiagnosticNumber::PROGRAM_END, "the NC program has no further block"));
            system.set("$MCDRD", MacroValue::text(""));
            return;
        };
        self.next += 1;
        system.set("$MCDRD", MacroValue::text(block));
        #[allow(clippy::cast_precision_loss)]
        system.set("$MCDNO", MacroValue::Real(self.next as f64));
    }

    /// SEARCH
    pub(crate) fn go_to(&mut self, number: i64) {
        self.next = usize::try_from(number - 1).unwrap_or(0).min(self.blocks.len());
    }
}

/// `$FCEPP`: whether the pre-processor has the setting.
pub(crate) fn setting(state: &mut MacroState, arguments: &[MacroValue]) -> MacroValue {
    let texts: Vec<String> = arguments.iter().map_while(MacroValue::as_text).map(str::to_uppercase).collect();
    let two = texts.join(",");
    let known = SETTINGS.iter().any(|setting| {
        two == *setting
            || texts.first().is_some_and(|first| first == setting)
            || two.starts_with(&format!("{setting},"))
    });
    if !known {
        let message = format!("the pre-processor has no setting '{}'", texts.join(" "));
        state.warn(MacroFault::new(DiagnosticNumber::NO_SETTING, message));
    }
    MacroValue::Logical(known)
}
