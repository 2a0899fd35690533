//! The variables of one kernel.
//!
//! Decisions: every run of a subprogram has local variables of its own, which begin with the arguments of its call,
//! also those of a further pass; common variables that the machine gives to each channel stay here, the others lie with
//! the kernel's host. A common variable without a value counts as 0. Facts: reference control-emulator.md 5.4.

use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use rustc_hash::FxHashMap;

use super::names::{Common, LocalVariableName};
use counterpoint_control_api::call_stack::CallStack;
use counterpoint_control_api::host::InterpreterHost;

/// Local variables that a call sets.
pub(super) type Arguments = Box<[(LocalVariableName, f64)]>;

/// Local variables of a running program.
#[derive(Debug, Default)]
struct Locals {
    values: FxHashMap<LocalVariableName, f64>,
    /// Those that a pass begins with.
    arguments: Arguments,
}

/// Variables.
#[derive(Debug, Default)]
pub(super) struct OkumaVariableStore {
    /// Of the main program and the subprograms that run.
    locals: CallStack<Locals>,
    /// Common variables of this channel alone.
    own: FxHashMap<Common, f64>,
}

impl OkumaVariableStore {
    /// The program begins; `reset` as if it were the first one.
    pub(super) fn begin(&mut self, reset: bool) {
        self.locals = CallStack::default();
        if reset {
            self.own.clear();
        }
    }

    /// A subprogram begins.
    pub(super) fn enter(&mut self, arguments: Arguments) {
        self.locals.enter(Locals { values: arguments.iter().copied().collect(), arguments });
    }

    /// Its next pass begins.
    pub(super) fn again(&mut self) {
        if let Some(locals) = self.locals.called_mut() {
            locals.values = locals.arguments.iter().copied().collect();
        }
    }

    /// A subprogram has returned.
    pub(super) fn leave(&mut self) {
        self.locals.leave();
    }

    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        let locals = self.locals.iter().map(|locals| locals.values.len() + locals.arguments.len());
        (locals.sum::<usize>() + self.own.len()) * 100
    }

    fn locals(&mut self) -> &mut Locals {
        self.locals.here_mut()
    }

    /// A local variable, if it has a value.
    pub(super) fn local(&mut self, name: LocalVariableName) -> Option<f64> {
        self.locals().values.get(&name).copied()
    }

    /// Sets a local variable, or takes its value away; whether that changed anything.
    pub(super) fn set_local(&mut self, name: LocalVariableName, value: Option<f64>) -> bool {
        let values = &mut self.locals().values;
        let before = match value {
            Some(value) => values.insert(name, value),
            None => values.remove(&name),
        };
        before.map(f64::to_bits) != value.map(f64::to_bits)
    }

    /// A common variable, if it has a value.
    pub(super) fn common(&mut self, host: &mut dyn InterpreterHost, common: Common) -> Result<Option<f64>, Halt> {
        if host.has_own_common() {
            return Ok(self.own.get(&common).copied());
        }
        host.shared_number(common.name())
    }

    /// Sets a common variable, or takes its value away.
    pub(super) fn set_common(&mut self, host: &mut dyn InterpreterHost, common: Common, value: Option<f64>) -> Acted {
        if !host.has_own_common() {
            return host.set_shared(common.name(), value.map(MacroValue::Real));
        }
        let before = match value {
            Some(value) => self.own.insert(common, value),
            None => self.own.remove(&common),
        };
        if before.map(f64::to_bits) != value.map(f64::to_bits) {
            host.effect();
        }
        Ok(())
    }
}
