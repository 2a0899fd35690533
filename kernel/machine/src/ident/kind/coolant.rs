//! What codes of coolant switch.

use super::super::{CodeId, code_facts};
use counterpoint_event::event::Outlet;

/// What a coolant code switches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Switch {
    /// Coolant of the main or the side head.
    Fluid(Flow, Outlet),
    /// An auxiliary device.
    Device(u8, bool),
    /// The pressure that a word gives.
    Pressure,
    /// A pressure of the machine's list.
    Level(u8),
}

/// What flows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// No coolant.
    Off,
    /// What flowed last.
    Again,
    /// By the numbers of `$COOLTYP`.
    Fluid(u8),
}

/// What a code of the groups of fluids means.
pub fn fluid_code(id: CodeId) -> Option<(Flow, Outlet)> {
    let name = code_facts(id)?.name.strip_prefix("CODE_COOLANT_")?;
    let (name, outlet) = match name.strip_suffix("_SIDE") {
        Some(name) => (name, Outlet::Side),
        None => (name, Outlet::Main),
    };
    let flow = match name {
        "OFF" => Flow::Off,
        "ON" => Flow::Again,
        "FLOOD" => Flow::Fluid(1),
        "MIST" => Flow::Fluid(2),
        "TAPKUL" => Flow::Fluid(3),
        "THRU" => Flow::Fluid(4),
        other => Flow::Fluid(other.strip_prefix("TYPE")?.parse().ok()?),
    };
    Some((flow, outlet))
}

/// What a code switches, if it is one of coolant.
pub fn of(id: CodeId) -> Option<Switch> {
    if let Some((flow, outlet)) = fluid_code(id) {
        return Some(Switch::Fluid(flow, outlet));
    }
    let name = code_facts(id)?.name.strip_prefix("CODE_COOLANT_")?;
    if let Some((number, state)) = name.strip_prefix("DEV").and_then(|device| device.split_once('_')) {
        return Some(Switch::Device(number.parse().ok()?, state == "ON"));
    }
    match name.strip_prefix("PRESSURE")? {
        "" => Some(Switch::Pressure),
        level => Some(Switch::Level(level.strip_prefix('_')?.parse().ok()?)),
    }
}
