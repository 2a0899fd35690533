//! Stand-ins for a machine: three linear axes without a model.
//!
//! Invariant: functions of a model answer zero, nothing or an empty list, with one message per run. Facts: reference
//! functions.md 10 to 12.

use super::Test;
use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::host::HostFn;
use crate::state::State;
use crate::value::{Kind, Value};

/// What a function answers that has nothing to work on.
fn nothing(function: HostFn) -> Value {
    function.result().map_or(Value::Null, Kind::initial)
}

impl Test {
    pub(super) fn without_model(&mut self, state: &mut State, function: HostFn) -> Value {
        if !std::mem::replace(&mut self.said_no_model, true) {
            let message = format!("{} needs a machine model, and there is none here", function.name());
            state.warn(Fault::new(Number::NO_MODEL, message));
        }
        nothing(function)
    }

    pub(super) fn out_of_scope(state: &mut State, function: HostFn) -> Value {
        state.warn(Fault::new(Number::NO_MODEL, format!("{} does nothing here", function.name())));
        nothing(function)
    }

    /// `$FDK`, `$FIK`: without rotary axes both give the position; the tool points along Z.
    pub(super) fn kinematics(&self, arguments: &[Value], machine: bool) -> Outcome<Value> {
        let mut numbers: Vec<f64> = ["$XM", "$YM", "$ZM"].iter().map(|name| self.system_number(name)).collect();
        if let Some(Value::Sequence(given)) = arguments.first() {
            for (place, value) in numbers.iter_mut().zip(given.iter()) {
                *place = value.as_real().ok_or_else(|| Fault::kind("a number", value))?;
            }
        }
        numbers.extend(if machine { [0.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
        Ok(Value::numbers(&numbers))
    }
}
