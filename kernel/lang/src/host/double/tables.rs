//! Tables of the double: diagnostics, macros of the control, registers.
//!
//! Facts: reference functions.md 8. A diagnostic that is switched off is not reported; a changed severity counts from
//! the next report on.

use super::Test;
use crate::diag::{Diagnostic, Number};
use crate::fault::{Fault, Outcome};
use crate::host::folder::text;
use crate::state::State;
use crate::value::Value;

/// Letters of the double's registers; the position is the index.
const REGISTERS: &str = "ABCDEFHNSTXYZ";

/// A diagnostic of the tables.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) severity: u8,
    pub(super) text: String,
    changed: bool,
    on: bool,
}

/// A macro of the control as `$FMACID` knows it.
#[derive(Clone, Debug)]
pub(super) struct Named {
    id: f64,
    name: String,
    on: bool,
}

fn number(arguments: &[Value], position: usize) -> u32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    arguments.get(position).and_then(Value::as_real).map_or(0, |number| number.max(0.0) as u32)
}

impl Test {
    /// Adds a diagnostic to the tables; the text is a string format.
    pub fn add_diagnostic(&mut self, number: u32, severity: u8, text: &str) {
        self.table_of_diagnostics.insert(number, Entry { severity, text: text.to_owned(), changed: false, on: true });
    }

    /// Adds a macro that `$FMACID` finds.
    pub fn add_macro(&mut self, id: f64, name: &str) {
        self.named_macros.push(Named { id, name: name.to_owned(), on: true });
    }

    /// The diagnostic as it is reported now, none if it is switched off.
    pub(super) fn changed(&self, mut diagnostic: Diagnostic) -> Option<Diagnostic> {
        let own = matches!(diagnostic.number, Number::AUTHOR | Number::TERMAC_GENERATED);
        match self.table_of_diagnostics.get(&diagnostic.number.0).filter(|_| !own) {
            Some(entry) if !entry.on => None,
            Some(entry) if entry.changed => {
                diagnostic.severity = entry.severity;
                Some(diagnostic)
            }
            _ => Some(diagnostic),
        }
    }

    pub(super) fn severity(&mut self, arguments: &[Value]) -> Outcome<Value> {
        let Some(entry) = self.table_of_diagnostics.get_mut(&number(arguments, 0)) else {
            return Ok(Value::Real(-1.0));
        };
        let before = entry.severity;
        if arguments.len() > 1 {
            let wanted = number(arguments, 1);
            let fault = || Fault::new(Number::OUT_OF_RANGE, "a severity is 0 to 99");
            entry.severity = u8::try_from(wanted).ok().filter(|severity| *severity < 100).ok_or_else(fault)?;
            entry.changed = true;
        }
        Ok(Value::Real(f64::from(before)))
    }

    pub(super) fn switched(&mut self, arguments: &[Value]) -> Value {
        let Some(entry) = self.table_of_diagnostics.get_mut(&number(arguments, 0)) else {
            return Value::Logical(false);
        };
        let before = entry.on;
        if let Some(on) = arguments.get(1).and_then(Value::as_logical) {
            entry.on = on;
        }
        Value::Logical(before)
    }

    pub(super) fn text_of(&self, arguments: &[Value]) -> Value {
        let entry = self.table_of_diagnostics.get(&number(arguments, 0));
        Value::text(entry.map_or("", |entry| entry.text.as_str()))
    }

    /// `$FMACID`: of the running macro, which has the identity 0 here, without an expression.
    pub(super) fn macros(&self, state: &mut State, arguments: &[Value]) -> Outcome<Value> {
        let expression = text(arguments, 0);
        if expression.trim().is_empty() {
            return Ok(Value::sequence(vec![Value::Real(0.0), Value::text("")]));
        }
        let pattern = state.pattern(expression)?;
        let (mut found, mut budget) = (Vec::new(), crate::pattern::STEPS);
        for named in &self.named_macros {
            if pattern.find(&named.name, 0, &mut budget)?.is_some() {
                found.extend([Value::Real(named.id), Value::text(named.name.as_str())]);
            }
        }
        Ok(Value::sequence(found))
    }

    pub(super) fn macro_states(&mut self, arguments: &[Value]) -> Value {
        crate::host::macro_states(arguments, |id, on| {
            let named = self.named_macros.iter_mut().find(|named| named.id == id)?;
            let before = named.on;
            named.on = on.unwrap_or(before);
            Some(before)
        })
    }

    /// Letter of a register by index or letter.
    pub(super) fn register_letter(value: Option<&Value>) -> Option<char> {
        match value? {
            Value::Text(text) => {
                text.trim().chars().next().map(|c| c.to_ascii_uppercase()).filter(|c| REGISTERS.contains(*c))
            }
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            Value::Real(index) => REGISTERS.chars().nth((index.max(0.0) as usize).wrapping_sub(1)),
            _ => None,
        }
    }

    pub(super) fn register_format(arguments: &[Value]) -> Value {
        Value::text(Self::register_letter(arguments.first()).map_or("", |_| "!(s9f9s)"))
    }

    pub(super) fn register_position(arguments: &[Value]) -> Value {
        let at = Self::register_letter(arguments.first()).and_then(|letter| REGISTERS.find(letter));
        #[allow(clippy::cast_precision_loss)]
        at.map_or(Value::Real(-1.0), |at| Value::Real((at + 1) as f64))
    }
}
