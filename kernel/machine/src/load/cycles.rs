//! `[cycles]`: behaviour of canned cycles on this machine.
//!
//! Invariant: distances are zero or more. Facts: reference control-emulator.md 1.5, 6.4.

use crate::model::{CycleApproach, CycleRules, DistanceMode};
use crate::toml::section::TableReader;
use counterpoint_event::MachineUnit;

/// Reads the section.
pub(super) fn read(top: &mut TableReader<'_>, unit: MachineUnit) -> CycleRules {
    let mut cycles = CycleRules {
        approach: CycleApproach::Direct,
        clearance: DistanceMode::Mode,
        clearance_required: true,
        depth: DistanceMode::Mode,
        step_required: true,
        step_back: if unit == MachineUnit::Inch { 0.04 } else { 1.0 },
        min_step: 0.0,
        cancel_required: false,
        motion_cancels: false,
        tap_pitch: false,
        last_of_block: false,
    };
    let Some(mut section) = top.table("cycles", "[cycles]") else { return cycles };
    let approaches = [("direct", CycleApproach::Direct), ("position-first", CycleApproach::PositionFirst)];
    cycles.approach = section.choice("approach", &approaches).unwrap_or(cycles.approach);
    let heights = [
        ("mode", DistanceMode::Mode),
        ("absolute", DistanceMode::Absolute),
        ("incremental", DistanceMode::Incremental),
    ];
    cycles.clearance = section.choice("clearance", &heights).unwrap_or(cycles.clearance);
    cycles.depth = section.choice("depth", &heights).unwrap_or(cycles.depth);
    let needed = [("required", true), ("optional", false)];
    cycles.clearance_required = section.choice("clearance_word", &needed).unwrap_or(cycles.clearance_required);
    cycles.step_required = section.choice("step", &needed).unwrap_or(cycles.step_required);
    cycles.step_back = section.at_least_zero("step_back").unwrap_or(cycles.step_back);
    cycles.min_step = section.at_least_zero("min_step").unwrap_or(cycles.min_step);
    cycles.cancel_required = section.choice("cancel", &needed).unwrap_or(cycles.cancel_required);
    cycles.motion_cancels = section.flag("motion_cancels").unwrap_or(cycles.motion_cancels);
    let feeds = [("mode", false), ("pitch", true)];
    cycles.tap_pitch = section.choice("typed_tap_feed", &feeds).unwrap_or(cycles.tap_pitch);
    let beside = [("cycle", false), ("last", true)];
    cycles.last_of_block = section.choice("beside_motion", &beside).unwrap_or(cycles.last_of_block);
    section.finish();
    cycles
}
