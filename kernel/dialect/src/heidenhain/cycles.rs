//! Cycles: CYCL DEF of both kinds, and what calls them.
//!
//! Facts: Heidenhain pre-processor pages and release notes (cycles as subprograms of the machine by
//! `$FCEPP('CYCLEDEF',…)`, KEEPCYCLDEFQVARS, cycle 12), programming manuals. Decisions: what a cycle does is said by
//! the tables of the machine, which get `CYCL DEF` with its number and, of cycles of several lines, the words of all
//! lines. Invariant: titles are texts for people and never reach the tables.

use counterpoint_fault::Halt;
use std::sync::Arc;

use super::eval::Evaluator;
use super::formula::{Wrong, expected};
use super::lex::Cursor;
use super::statement::{Call, Statement};
use super::variables::Value;
use super::words::{Operand, Seen, Word, joined, words};
use super::{Heidenhain, Line};
use crate::host::{Host, Place};
use counterpoint_fault as diag;

/// Behind `CYCL DEF`.
pub(super) fn read(cursor: &mut Cursor<'_>) -> Result<Statement, Wrong> {
    let Some((number, _)) = cursor.number() else { return Err(expected(cursor, "the number of the cycle")) };
    let (cycle, part) = match number.split_once('.') {
        Some((cycle, part)) => (cycle, Some(part)),
        None => (&*number, None),
    };
    let whole = |digits: &str, cursor: &Cursor<'_>| -> Result<u32, Wrong> {
        digits.parse().map_err(|_| expected(cursor, "the number of the cycle"))
    };
    let cycle = whole(cycle, cursor)?;
    match part {
        None => {
            // Behind the title, the parameters.
            let all = words(cursor);
            let first = all.iter().position(is_parameter).unwrap_or(all.len());
            Ok(Statement::CycleDefinition(std::iter::once(head(cycle)).chain(all.into_iter().skip(first)).collect()))
        }
        Some(part) => {
            let part = whole(part, cursor)?;
            let text = cursor.rest().trim().to_owned();
            Ok(Statement::CyclePart { cycle, part, words: words(cursor), text })
        }
    }
}

/// `CYCL DEF` with the number.
pub(super) fn head(cycle: u32) -> Word {
    Word { name: "CYCL DEF ".into(), operand: Operand::Number(cycle.to_string().into(), f64::from(cycle)) }
}

fn is_parameter(word: &Word) -> bool {
    word.name.starts_with('Q') && word.name.ends_with('=')
}

/// The parameter that a word of a cycle sets.
pub(super) fn parameter_of(name: &str) -> Option<super::formula::Name> {
    super::formula::parameter(&mut Cursor::new(name.strip_suffix('=')?))
}

/// Cycles that act where they are defined.
const ACT_AT_ONCE: [u32; 14] = [7, 8, 9, 10, 11, 13, 14, 19, 20, 26, 30, 32, 239, 247];

/// The cycle that calls carry out, where that is a program.
#[derive(Debug, Clone, Default)]
pub(super) struct State {
    program: Option<Arc<str>>,
    /// Every position calls it, on the level where M89 was said.
    modal: Option<usize>,
}

/// Calls that the words of a block ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    No,
    Once,
    Modally,
}

fn asks(seen: &[Seen]) -> Asked {
    let mut asked = Asked::No;
    for word in seen {
        match (&*word.name, word.value) {
            ("M", Some(99.0)) | ("G", Some(79.0)) => return Asked::Once,
            ("M", Some(89.0)) => asked = Asked::Modally,
            _ => {}
        }
    }
    asked
}

impl Heidenhain {
    /// A cycle with its parameters.
    pub(super) fn define_cycle(&mut self, host: &mut dyn Host, words: &[Word]) -> Result<Option<String>, Halt> {
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let seen = evaluator.seen(words)?;
        for word in &seen {
            if let (Some(name), Some(value)) = (parameter_of(&word.name), word.value) {
                evaluator.assign(name, Value::Number(value))?;
            }
        }
        let number = seen.first().and_then(|word| word.value).unwrap_or(0.0) as u32;
        self.shifts.define(number, &mut []);
        if self.settings.cycles.contains(&number) {
            self.cycle = State { program: Some(number.to_string().into()), modal: None };
            return Ok(None);
        }
        if !ACT_AT_ONCE.contains(&number) {
            self.cycle = State::default();
        }
        let keeps = self.settings.keeps;
        let stays =
            |word: &Seen| parameter_of(&word.name).is_none() || keeps.unwrap_or_else(|| host.is_register(&word.name));
        let left: Vec<Seen> = seen.into_iter().filter(stays).collect();
        Ok(Some(joined("", &left)))
    }

    /// A cycle of several lines: those that follow belong to it.
    pub(super) fn define_by_parts(
        &mut self,
        host: &mut dyn Host,
        line: &Line,
        place: Place,
    ) -> Result<Option<String>, Halt> {
        let Statement::CyclePart { cycle, part, words, text } = &line.statement else { return Ok(None) };
        let mut all = vec![head(*cycle)];
        let mut program = None;
        let mut add = |part: u32, words: &[Word], text: &str| {
            if part > 0 {
                all.extend_from_slice(words);
                program = text.strip_prefix("PGM").map(|name| name.trim().to_owned()).or(program.take());
            }
        };
        add(*part, words, text);
        let mut next = line.next;
        while place.as_read && next <= place.range.last {
            let Ok(more) = self.line(host, next) else { break };
            match &more.statement {
                Statement::CyclePart { cycle: same, part, words, text } if same == cycle && *part > 0 => {
                    add(*part, words, text);
                }
                Statement::Nothing => {}
                _ => break,
            }
            next = more.next;
        }
        if next > line.next {
            host.go_to(next)?;
        }
        if *cycle == 12 {
            let Some(program) = program.filter(|name| !name.is_empty()) else {
                let text = format!("cycle 12 names no program in '{}'", host.block_text());
                host.diagnose(&diag::STATEMENT_UNKNOWN, text);
                return Ok(None);
            };
            let name = match super::formula::parameter(&mut Cursor::new(&program)) {
                Some(name) => match Evaluator::new(&mut self.variables, host).value_or_kept(name)? {
                    Some(Value::Text(text)) => text,
                    _ => program.as_str().into(),
                },
                None => program.trim_matches('"').into(),
            };
            self.cycle = State { program: Some(name), modal: None };
            return Ok(None);
        }
        if !ACT_AT_ONCE.contains(cycle) {
            self.cycle = State::default();
        }
        let mut seen = Evaluator::new(&mut self.variables, host).seen(&all)?;
        self.shifts.define(*cycle, &mut seen);
        if *cycle == 19
            && let Some(plane) = self.plane_cycle(host, &seen)
        {
            return Ok(Some(plane));
        }
        Ok(Some(joined("", &seen)))
    }

    /// CYCL CALL.
    pub(super) fn call_cycle(
        &mut self,
        host: &mut dyn Host,
        kind: Call,
        words: &[Word],
    ) -> Result<Option<String>, Halt> {
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        self.functions_of(&seen);
        self.feed_units(host, &mut seen)?;
        let text = match kind {
            Call::Here => "CYCL CALL",
            Call::Position => "CYCL CALL POS",
            Call::Pattern => "CYCL CALL PAT",
        };
        if kind == Call::Pattern && !host.is_code_text(text) {
            return Ok(self.not_understood(host));
        }
        let Some(program) = self.cycle.program.clone().filter(|_| kind != Call::Pattern) else {
            return Ok(Some(joined(text, &seen)));
        };
        self.call_program(host, &program)?;
        if kind == Call::Here {
            return Ok(Some(joined("", &seen)));
        }
        if host.is_code_text("FMAX") {
            seen.push(Seen::text("FMAX"));
        }
        Ok(Some(joined(if host.is_code_text("L") { "L" } else { "G0" }, &seen)))
    }

    /// M99, M89, G79 of a block, and what M89 has said before. A cycle that is a program is called; of any other the
    /// call stays on the block, M89 as M99 on its own block and on all that follow.
    pub(super) fn cycle_calls(&mut self, host: &mut dyn Host, seen: &mut Vec<Seen>, moves: bool) -> Result<(), Halt> {
        let asked = asks(seen);
        let modal = self.cycle.modal == Some(self.variables.calls.depth()) && moves;
        if asked == Asked::No && !modal {
            return Ok(());
        }
        match asked {
            Asked::Once => self.cycle.modal = None,
            Asked::Modally => self.cycle.modal = Some(self.variables.calls.depth()),
            Asked::No => {}
        }
        let program = self.cycle.program.clone();
        seen.retain(|word| match (&*word.name, word.value) {
            ("M", Some(89.0)) => false,
            ("M", Some(99.0)) | ("G", Some(79.0)) => program.is_none(),
            _ => true,
        });
        match program {
            Some(program) => self.call_program(host, &program),
            None => {
                if asked != Asked::Once {
                    seen.push(Seen::made("M", 99.0));
                }
                Ok(())
            }
        }
    }
}
