//! Stand-ins for a machine: three linear axes without a model.
//!
//! *Invariant:* functions of a model answer zero, nothing or an empty list, with one message per run. Facts: reference
//! functions.md 10 to 12.

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::host::HostFn;
use counterpoint_lang::state::MacroState;
use counterpoint_lang::value::{MacroValue, ValueType};

use crate::variables::SystemTable;

/// Result of a function that has nothing to work on.
pub(crate) fn nothing(function: HostFn) -> MacroValue {
    function.result().map_or(MacroValue::Null, ValueType::initial)
}

pub(crate) fn out_of_scope(state: &mut MacroState, function: HostFn) -> MacroValue {
    state.warn(MacroFault::new(DiagnosticNumber::NO_MODEL, format!("{} does nothing here", function.name())));
    nothing(function)
}

/// `$FDK`, `$FIK`: without rotary axes both give the position; the tool points along Z.
pub(crate) fn kinematics(system: &SystemTable, arguments: &[MacroValue], machine: bool) -> Outcome<MacroValue> {
    let mut numbers: Vec<f64> = ["$XM", "$YM", "$ZM"].iter().map(|name| system.number(name)).collect();
    if let Some(MacroValue::Sequence(given)) = arguments.first() {
        for (place, value) in numbers.iter_mut().zip(given.iter()) {
            *place = value.as_real().ok_or_else(|| MacroFault::kind("a number", value))?;
        }
    }
    numbers.extend(if machine { [0.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] });
    Ok(MacroValue::numbers(&numbers))
}
