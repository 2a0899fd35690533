//! The parameters of a channel: numbered, named, and local to subprograms.
//!
//! Facts: LinuxCNC documentation, "Parameters" and "Call": #1 to #30 and names without a leading underscore belong to
//! the running subprogram; a called subprogram begins with the arguments. A number without a value is 0, a name without
//! a value is a mistake. Decision: missing arguments are 0, as on the page of parameters and in rs274; the page of O
//! codes gives them the caller's values. *Invariant:* no value is infinite or NaN.

use std::collections::BTreeMap;

use counterpoint_fault as diag;
use rustc_hash::FxHashMap;

use super::text::Rs274Mistake;
use counterpoint_control_api::call_stack::CallStack;

/// Largest number of parameters that may have a value.
const MOST: usize = 100_000;

/// Number of parameters that belong to a subprogram.
const LOCAL: usize = 30;

/// Highest number of a parameter.
pub(super) const HIGHEST: u32 = 5602;

type Names = FxHashMap<Box<str>, f64>;

/// Parameters of one subprogram, or of the main program.
#[derive(Debug, Clone, Default)]
pub(super) struct LocalParameters {
    numbers: [f64; LOCAL],
    names: Names,
    /// Remaining passes of the active REPEAT loops, by line.
    pub(super) repeats: BTreeMap<u32, u32>,
}

/// Parameters.
#[derive(Debug, Default)]
pub(super) struct Rs274Parameters {
    numbers: FxHashMap<u32, f64>,
    names: Names,
    calls: CallStack<LocalParameters>,
    /// Arguments of the next call; `None` if it shares the parameters of its caller.
    arguments: Option<Vec<f64>>,
}

impl Rs274Parameters {
    /// Creates the parameters with the machine's initial values.
    pub(super) fn new(initial: impl Iterator<Item = (u32, f64)>) -> Self {
        Self { numbers: initial.collect(), ..Self::default() }
    }

    /// Resets the local parameters when the program begins again.
    pub(super) fn restart(&mut self) {
        self.calls = CallStack::default();
        self.arguments = None;
    }

    /// Passes these arguments to the next subprogram.
    pub(super) fn pass(&mut self, arguments: Vec<f64>) {
        self.arguments = Some(arguments);
    }

    /// Enters a subprogram.
    pub(super) fn enter(&mut self) {
        match self.arguments.take() {
            Some(arguments) => {
                let mut local = LocalParameters::default();
                for (slot, value) in local.numbers.iter_mut().zip(arguments) {
                    *slot = value;
                }
                self.calls.enter(local);
            }
            None => self.calls.enter_part(LocalParameters::default()),
        }
    }

    /// Leaves a subprogram.
    pub(super) fn leave(&mut self) {
        self.calls.leave();
    }

    /// Number of running subprograms.
    pub(super) fn depth(&self) -> usize {
        self.calls.depth()
    }

    fn here(&self) -> &LocalParameters {
        self.calls.program()
    }

    /// Remaining passes of REPEAT loops.
    pub(super) fn repeats(&mut self) -> &mut BTreeMap<u32, u32> {
        &mut self.calls.here_mut().repeats
    }

    /// A numbered parameter that is not a system parameter.
    pub(super) fn number(&self, number: u32) -> f64 {
        match (number as usize).checked_sub(1).and_then(|at| self.here().numbers.get(at)) {
            Some(value) => *value,
            None => self.numbers.get(&number).copied().unwrap_or(0.0),
        }
    }

    /// Sets a numbered parameter. Returns whether its value changed.
    pub(super) fn set_number(&mut self, number: u32, value: f64) -> Result<bool, Rs274Mistake> {
        let local = &mut self.calls.program_mut().numbers;
        if let Some(slot) = (number as usize).checked_sub(1).and_then(|at| local.get_mut(at)) {
            return Ok(std::mem::replace(slot, value).to_bits() != value.to_bits());
        }
        if number == 0 || number > HIGHEST {
            let text = format!("#{number} does not exist: parameters have the numbers 1 to {HIGHEST}");
            return Err(Rs274Mistake::new(&diag::MACRO_VARIABLE, 1, text));
        }
        Ok(self.numbers.insert(number, value).map(f64::to_bits) != Some(value.to_bits()))
    }

    /// A named parameter, if it has a value.
    pub(super) fn named(&self, name: &str) -> Option<f64> {
        if name.starts_with('_') { self.names.get(name) } else { self.here().names.get(name) }.copied()
    }

    /// Sets a named parameter. Returns whether its value changed.
    pub(super) fn set_named(&mut self, name: &str, value: f64) -> Result<bool, Rs274Mistake> {
        let names = if name.starts_with('_') { &mut self.names } else { &mut self.calls.program_mut().names };
        if let Some(slot) = names.get_mut(name) {
            return Ok(std::mem::replace(slot, value).to_bits() != value.to_bits());
        }
        if names.len() >= MOST {
            return Err(Rs274Mistake::new(&diag::MACRO_VARIABLE, 1, format!("more than {MOST} parameters have names")));
        }
        names.insert(name.into(), value);
        Ok(true)
    }

    /// Approximate size in bytes.
    pub(super) fn bytes(&self) -> usize {
        let local: usize = self.calls.iter().map(|local| local.names.len() * 80 + 300).sum();
        (self.numbers.len() + self.names.len()) * 80 + local
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_subprogram_has_its_arguments() {
        let mut parameters = Rs274Parameters::default();
        for (number, value) in [(1, 10.0), (3, 30.0), (31, 5.0)] {
            parameters.set_number(number, value).unwrap();
        }
        parameters.set_named("a", 1.0).unwrap();
        parameters.pass(vec![7.0, 8.0]);
        parameters.enter();
        assert_eq!([1, 2, 3, 4, 31].map(|number| parameters.number(number)), [7.0, 8.0, 0.0, 0.0, 5.0]);
        assert_eq!(parameters.named("a"), None);
        parameters.set_number(1, 9.0).unwrap();
        parameters.set_number(31, 6.0).unwrap();
        parameters.set_named("_b", 2.0).unwrap();
        parameters.leave();
        assert_eq!([1, 31].map(|number| parameters.number(number)), [10.0, 6.0]);
        assert_eq!((parameters.named("a"), parameters.named("_b")), (Some(1.0), Some(2.0)));
        assert!(parameters.set_number(HIGHEST + 1, 1.0).is_err());
    }

    #[test]
    fn a_program_that_m98_calls_shares_the_parameters() {
        let mut parameters = Rs274Parameters::default();
        parameters.enter();
        parameters.set_number(1, 4.0).unwrap();
        parameters.leave();
        assert_eq!(parameters.number(1), 4.0);
    }
}
