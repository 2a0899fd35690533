//! FXS, FXST and FXSW: travel to a fixed stop.
//!
//! Facts: programming manual, fundamentals, chapter "travel to fixed stop": FXS[axis]=1 makes the move of its block end
//! at the stop and remains active until FXS[axis]=0; FXST is the torque in percent, FXSW the width of the monitoring
//! window. Decisions: torque and window have no effect; the kernel knows the place of the stop. *Invariant:* without
//! such an axis in the channel nothing changes.

use super::compiled::IndexedName;
use super::item::AssignmentValue;
use super::{Outcome, Siemens, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;

/// Executes FXS, FXST or FXSW of an axis; false for another name.
pub(super) fn assign(
    siemens: &mut Siemens,
    host: &mut dyn InterpreterHost,
    name: &IndexedName,
    value: &AssignmentValue,
) -> Outcome<bool> {
    if !matches!(name.name.as_str(), "FXS" | "FXST" | "FXSW") {
        return Ok(false);
    }
    let axis = siemens.axis_of(host, name)?.text();
    let Some(letter) = host.axis_letter(&axis).map(str::to_owned) else {
        return wrong_type(format!("the channel has no axis {axis}"));
    };
    let AssignmentValue::One(value, _) = value else { return syntax(format!("{} takes a number", name.name)) };
    let value = super::conversions::number(&siemens.evaluate(host, value)?)?;
    match (name.name.as_str(), value) {
        ("FXS", 0.0) => host.meet_fixed_stop(&letter, false),
        ("FXS", 1.0) => host.meet_fixed_stop(&letter, true),
        ("FXS", _) => return wrong_type(format!("FXS of axis {axis} is 0 or 1, not {value}")),
        _ if value < 0.0 => return wrong_type(format!("{} {value} of axis {axis} is below 0", name.name)),
        _ => true,
    };
    Ok(true)
}
