//! Arguments of a drilling cycle: numbers by their position in the head of the cycle.
//!
//! Facts: reference siemens-cycles.md 1: an omitted argument is 0. *Invariant:* every argument has the type of its
//! parameter. Texts, which name thread tables for dialogs, have the number 0.

use super::super::declaration::ProcHeader;
use super::super::variable_store::PassedArgument;

/// Arguments of a call.
#[derive(Debug, Default)]
pub(super) struct DrillingArguments {
    values: Vec<f64>,
    /// Whether the call gives each argument.
    given: Vec<bool>,
}

impl DrillingArguments {
    /// Converts the arguments of a call to the types of the parameters.
    ///
    /// # Errors
    /// The call has too many arguments, or an argument has the wrong type.
    pub(super) fn new(header: &ProcHeader, given: &[PassedArgument]) -> Result<Self, String> {
        let count = header.parameters.len();
        if given.len() > count {
            return Err(format!("{} takes {count} arguments, not {}", header.name, given.len()));
        }
        let mut arguments = Self { values: Vec::with_capacity(count), given: Vec::with_capacity(count) };
        for (at, parameter) in header.parameters.iter().enumerate() {
            let passed = given.get(at);
            arguments.given.push(passed.is_some_and(PassedArgument::is_there));
            let number = match passed {
                None => 0.0,
                Some(passed) => passed.number_as(&parameter.name, parameter.kind)?,
            };
            arguments.values.push(number);
        }
        Ok(arguments)
    }

    /// The number of an argument.
    pub(super) fn number(&self, at: usize) -> f64 {
        self.values.get(at).copied().unwrap_or(0.0)
    }

    /// Changes an argument according to the modes of the cycle.
    pub(super) fn set(&mut self, at: usize, value: f64) {
        if let Some(slot) = self.values.get_mut(at) {
            *slot = value;
        }
    }

    /// Whether the call gives the argument.
    pub(super) fn is_given(&self, at: usize) -> bool {
        self.given.get(at).copied().unwrap_or(false)
    }

    /// A decimal digit of an integer argument, counted from the right.
    pub(super) fn digit(&self, at: usize, place: u32) -> i64 {
        self.number(at) as i64 / 10_i64.pow(place) % 10
    }
}
