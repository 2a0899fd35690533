//! `[stops]`: where axes meet parts or stops.
//!
//! Invariant: a stop is not at the home position of its axis, since moves to a stop lead away from there.

use super::values;
use crate::index::{AxisId, IdTable};
use crate::model::{Axis, FixedStop};
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Numbers of variables that may hold the place of a stop.
const VARIABLES: std::ops::RangeInclusive<f64> = 100.0..=999_999.0;

/// Reads the section into the axes.
pub(super) fn read(top: &mut TableReader<'_>, axes: &mut IdTable<AxisId, Axis>, check: &FindingCollector) {
    let Some(mut section) = top.table("stops", "[stops]") else { return };
    let places = values::some_by_axis(&mut section, "at", axes, check);
    let numbers = values::some_by_axis(&mut section, "variable", axes, check);
    for id in axes.ids() {
        let axis = &mut axes[id];
        if places[id] == Some(axis.home) {
            let text =
                format!("the stop of axis {} is at its `home` {}: moves lead away from home", axis.name, axis.home);
            section.error("at", text);
        }
        if axis.role.is_rotary() && (places[id].is_some() || numbers[id].is_some()) {
            let key = if places[id].is_some() { "at" } else { "variable" };
            section.error(key, format!("axis {} is rotary: only linear axes meet stops", axis.name));
        }
        let number = numbers[id].filter(|number| {
            let fits = VARIABLES.contains(number) && number.fract() == 0.0;
            if !fits {
                let text = format!("`variable` of axis {} must be a whole number from 100 to 999999", axis.name);
                section.error("variable", text);
            }
            fits
        });
        axis.positioning.stop = FixedStop { at: places[id], variable: number.map(|number| number as u32) };
    }
    section.finish();
}
