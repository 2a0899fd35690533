//! `[coolant]`: the pressures of the pump.
//!
//! Invariant: pressures are zero or more, and none of the list is above the largest. Facts: reference
//! system-variables.md 6.

use crate::model::Pump;
use crate::toml::section::TableReader;

/// Reads the section.
pub(super) fn read(top: &mut TableReader<'_>) -> Pump {
    let mut pump = Pump { max_pressure: 0.0, pressures: Vec::new() };
    let Some(mut section) = top.table("coolant", "[coolant]") else { return pump };
    pump.max_pressure = section.above_zero("max_pressure").unwrap_or(0.0);
    pump.pressures = section.numbers("pressures", 1..=10).unwrap_or_default();
    for pressure in &pump.pressures {
        if *pressure < 0.0 || pump.max_pressure > 0.0 && *pressure > pump.max_pressure {
            section.error("pressures", format!("the pressure {pressure} is not between 0 and `max_pressure`"));
        }
    }
    section.finish();
    pump
}
