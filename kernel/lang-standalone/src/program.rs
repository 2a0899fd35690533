//! The NC program and the current block.
//!
//! *Invariant:* searching never moves the reading position. Facts: reference functions.md 9, macro-language.md 3.3.

use std::collections::{BTreeMap, HashMap};

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::{Fault, Outcome};
use counterpoint_lang::ident;
use counterpoint_lang::state::State;
use counterpoint_lang::value::Value;

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
    pub variables: BTreeMap<String, Value>,
    /// Position of the block read next.
    next: usize,
    pub(crate) block: Block,
}

/// Data of the current block, modal values, active codes.
#[derive(Debug, Default)]
pub(crate) struct Block {
    /// Identifiers with their values; none for a code without one.
    items: Vec<(Value, Value)>,
    modal: Vec<(Value, Value)>,
    active: Vec<(u16, u32)>,
    /// Modal groups of codes.
    groups: HashMap<u32, u16>,
}

fn same(a: &Value, b: &Value) -> bool {
    a.equals(b) == Some(true)
}

impl Block {
    pub(crate) fn put(&mut self, item: Value, value: f64) {
        if matches!(item, Value::Register(_)) {
            self.modal.push((item.clone(), Value::Real(value)));
        }
        self.items.push((item, Value::Real(value)));
    }

    pub(crate) fn group(&mut self, code: u32, group: u16) {
        self.groups.insert(code, group);
    }

    pub(crate) fn add(&mut self, state: &mut State, arguments: &[Value]) -> Outcome<Value> {
        // Looking for an item goes through all of them, so a block pays for its length.
        state.spend(self.items.len())?;
        let Some(item) = arguments.first() else { return Ok(Value::Logical(false)) };
        let known = !matches!(item, Value::Code(0) | Value::Register(0));
        if known {
            let value = arguments.get(1).cloned().unwrap_or(Value::Real(0.0));
            self.items.push((item.clone(), value));
        }
        Ok(Value::Logical(known))
    }

    pub(crate) fn seek(&mut self, arguments: &[Value], take: bool) -> Outcome<Value> {
        let Some(item) = arguments.first() else { return Ok(Value::Null) };
        if !matches!(item, Value::Code(_) | Value::Register(_)) {
            return Err(Fault::kind("a code or data identifier", item));
        }
        let mode = match arguments.get(1) {
            Some(Value::Keyword(code)) => ident::minor_name(*code).unwrap_or(""),
            _ => "",
        };
        let found = self.items.iter().position(|(other, _)| same(other, item)).filter(|_| mode != "LAST");
        if let Some(at) = found {
            let value = self.items.get(at).map_or(Value::Null, |(_, value)| value.clone());
            if take {
                self.items.remove(at);
            }
            return Ok(value);
        }
        let modal = self.modal.iter().rev().find(|(other, _)| same(other, item) && !mode.is_empty());
        Ok(modal.map_or(Value::Null, |(_, value)| value.clone()))
    }

    /// The active code of the group of a code; made so if `set`.
    pub(crate) fn active(&mut self, arguments: &[Value], set: bool) -> Value {
        let Some(Value::Code(code)) = arguments.first() else { return Value::Code(0) };
        let Some(group) = self.groups.get(code).copied().filter(|group| *group != 0) else { return Value::Code(0) };
        let active = &mut self.active;
        let before = active.iter().find(|(other, _)| *other == group).map_or(0, |(_, code)| *code);
        if set {
            active.retain(|(other, _)| *other != group);
            active.push((group, *code));
        }
        Value::Code(before)
    }
}

impl NcProgram {
    pub(crate) fn is_at_end(&self) -> bool {
        self.next >= self.blocks.len()
    }

    /// A variable of the NC program, its indices in brackets.
    fn variable_name(arguments: &[Value], from: usize) -> String {
        let indices: Vec<String> = arguments
            .iter()
            .skip(from)
            .filter_map(|value| value.as_real())
            .map(counterpoint_lang::format::wildcard_text)
            .collect();
        let name = text(arguments, 0).trim().to_uppercase();
        if indices.is_empty() { name } else { format!("{name}[{}]", indices.join(",")) }
    }

    pub(crate) fn variable(&self, arguments: &[Value]) -> Value {
        self.variables.get(&Self::variable_name(arguments, 1)).cloned().unwrap_or(Value::Null)
    }

    pub(crate) fn set_variable(&mut self, arguments: &[Value]) -> Value {
        let place = self.variables.get_mut(&Self::variable_name(arguments, 2));
        let value = arguments.get(1).filter(|value| !matches!(value, Value::Sequence(_)));
        Value::Logical(match (place, value) {
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
        state: &mut State,
        arguments: &[Value],
        forward: bool,
    ) -> Outcome<Value> {
        let expressions: Vec<&Value> = match arguments.first() {
            Some(Value::Sequence(all)) => all.iter().collect(),
            Some(one) => vec![one],
            None => Vec::new(),
        };
        let mut patterns = Vec::new();
        for expression in expressions {
            let expression = expression.as_text().ok_or_else(|| Fault::kind("a regular expression", expression))?;
            patterns.push(state.pattern(expression)?);
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let record =
            |at: usize| arguments.get(at).and_then(Value::as_real).map_or(0, |number| number.max(0.0) as usize);
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
                    system.set("$MCDRD", Value::text(block));
                    #[allow(clippy::cast_precision_loss)]
                    return Ok(Value::Real(number as f64));
                }
            }
        }
        Ok(Value::Real(0.0))
    }

    /// TAPERD
    pub(crate) fn read_block(&mut self, system: &mut SystemTable, state: &mut State) {
        let Some(block) = self.blocks.get(self.next).cloned() else {
            state.warn(Fault::new(Number::PROGRAM_END, "the NC program has no further block"));
            system.set("$MCDRD", Value::text(""));
            return;
        };
        self.next += 1;
        system.set("$MCDRD", Value::text(block));
        #[allow(clippy::cast_precision_loss)]
        system.set("$MCDNO", Value::Real(self.next as f64));
    }

    /// SEARCH
    pub(crate) fn go_to(&mut self, number: i64) {
        self.next = usize::try_from(number - 1).unwrap_or(0).min(self.blocks.len());
    }
}

/// `$FCEPP`: whether the pre-processor has the setting.
pub(crate) fn setting(state: &mut State, arguments: &[Value]) -> Value {
    let texts: Vec<String> = arguments.iter().map_while(Value::as_text).map(str::to_uppercase).collect();
    let two = texts.join(",");
    let known = SETTINGS.iter().any(|setting| {
        two == *setting
            || texts.first().is_some_and(|first| first == setting)
            || two.starts_with(&format!("{setting},"))
    });
    if !known {
        let message = format!("the pre-processor has no setting '{}'", texts.join(" "));
        state.warn(Fault::new(Number::NO_SETTING, message));
    }
    Value::Logical(known)
}
