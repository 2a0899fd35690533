//! `[arcs]`, `[turning]` and `[threads]`: circles, turning and threading cycles.
//!
//! Invariant: keys that the section omits have a default that fits the unit. Facts: reference control-emulator.md 1.5.

use crate::model::DistanceMode;
use crate::model::paths::{ArcRules, Helix, MultiTurnCircles, ThreadingRules, TurningRules};
use crate::toml::section::TableReader;
use counterpoint_event::MachineUnit;

/// Nose angles go up to here, degrees.
const WIDEST: f64 = 170.0;

/// Reads `[arcs]`.
pub(super) fn arcs(top: &mut TableReader<'_>, unit: MachineUnit) -> ArcRules {
    let mut arcs = ArcRules {
        center: DistanceMode::Incremental,
        tolerance: if unit == MachineUnit::Inch { 0.01 / 25.4 } else { 0.01 },
        tolerance_share: 0.0,
        largest_tolerance: f64::INFINITY,
        max_radius: f64::INFINITY,
        helix: Helix::Any,
        turns: MultiTurnCircles::Always,
        stands: false,
        straight: false,
    };
    let Some(mut section) = top.table("arcs", "[arcs]") else { return arcs };
    let centers =
        [("offset", DistanceMode::Incremental), ("absolute", DistanceMode::Absolute), ("mode", DistanceMode::Mode)];
    arcs.center = section.choice("center", &centers).unwrap_or(arcs.center);
    arcs.tolerance = section.at_least_zero("tolerance").unwrap_or(arcs.tolerance);
    arcs.tolerance_share = section.at_least_zero("tolerance_share").unwrap_or(arcs.tolerance_share);
    arcs.largest_tolerance = section.at_least_zero("largest_tolerance").unwrap_or(arcs.largest_tolerance);
    arcs.max_radius = section.above_zero("max_radius").unwrap_or(arcs.max_radius);
    let helices = [("any", Helix::Any), ("codes", Helix::Codes), ("off", Helix::Off)];
    arcs.helix = section.choice("helix", &helices).unwrap_or(arcs.helix);
    let turns = [
        ("always", MultiTurnCircles::Always),
        ("helical", MultiTurnCircles::Helical),
        ("never", MultiTurnCircles::Never),
    ];
    arcs.turns = section.choice("turns", &turns).unwrap_or(arcs.turns);
    let starts = [("error", false), ("stand", true)];
    arcs.stands = section.choice("to_start", &starts).unwrap_or(arcs.stands);
    let lines = [("error", false), ("line", true)];
    arcs.straight = section.choice("without_center", &lines).unwrap_or(arcs.straight);
    section.finish();
    arcs
}

/// Reads `[turning]`.
pub(super) fn turning(top: &mut TableReader<'_>, unit: MachineUnit) -> TurningRules {
    let one = if unit == MachineUnit::Inch { 0.04 } else { 1.0 };
    let mut turning = TurningRules {
        two_lines: false,
        depth: 0.0,
        retract: one,
        back: one,
        pockets: true,
        retracts: false,
        opposite: 0.0,
    };
    let Some(mut section) = top.table("turning", "[turning]") else { return turning };
    let forms = [("one-line", false), ("two-line", true)];
    turning.two_lines = section.choice("form", &forms).unwrap_or(turning.two_lines);
    turning.depth = section.at_least_zero("depth").unwrap_or(turning.depth);
    turning.retract = section.at_least_zero("retract").unwrap_or(turning.retract);
    turning.back = section.at_least_zero("back").unwrap_or(turning.back);
    let types = [("by-first-block", true), ("by-word", false)];
    turning.pockets = section.choice("pockets", &types).unwrap_or(turning.pockets);
    let ends = [("contour", false), ("retract", true)];
    turning.retracts = section.choice("rapid_end", &ends).unwrap_or(turning.retracts);
    turning.opposite = section.at_least_zero("opposite").unwrap_or(turning.opposite);
    section.finish();
    turning
}

/// Reads `[threads]`.
pub(super) fn threads(top: &mut TableReader<'_>) -> ThreadingRules {
    let mut threads = ThreadingRules {
        two_lines: false,
        changes: false,
        infeed: 0,
        min_step: 0.0,
        finish_cuts: 0,
        finish: 0.0,
        nose: 60.0,
        noses: 0,
        chamfer: false,
        chamfer_length: 0.0,
        chamfer_angle: 45.0,
    };
    let Some(mut section) = top.table("threads", "[threads]") else { return threads };
    let forms = [("one-line", false), ("two-line", true)];
    threads.two_lines = section.choice("form", &forms).unwrap_or(threads.two_lines);
    let leads = [("codes", false), ("words", true)];
    threads.changes = section.choice("lead_change", &leads).unwrap_or(threads.changes);
    threads.infeed = section.integer("infeed", 0..=4).map_or(threads.infeed, |mode| mode as u8);
    threads.min_step = section.at_least_zero("min_step").unwrap_or(threads.min_step);
    threads.finish_cuts = section.integer("finish_cuts", 0..=99).map_or(threads.finish_cuts, |cuts| cuts as u16);
    threads.finish = section.at_least_zero("finish").unwrap_or(threads.finish);
    threads.nose = angle(&mut section, "nose", 0.0, WIDEST).unwrap_or(threads.nose);
    threads.noses = noses(&mut section);
    threads.chamfer = section.flag("chamfer").unwrap_or(threads.chamfer);
    threads.chamfer_length = section.at_least_zero("chamfer_length").unwrap_or(threads.chamfer_length);
    threads.chamfer_angle = angle(&mut section, "chamfer_angle", 10.0, 80.0).unwrap_or(threads.chamfer_angle);
    section.finish();
    threads
}

fn angle(section: &mut TableReader<'_>, key: &'static str, least: f64, most: f64) -> Option<f64> {
    let angle = section.number(key)?;
    if (least..=most).contains(&angle) {
        return Some(angle);
    }
    section.error(key, format!("`{key}` is an angle of {least} to {most} degrees"));
    None
}

/// Angles in whole degrees, bit by degree.
fn noses(section: &mut TableReader<'_>) -> u128 {
    let angles = section.numbers("noses", 0..=99).unwrap_or_default();
    if angles.iter().any(|angle| angle.fract() != 0.0 || !(0.0..=120.0).contains(angle)) {
        section.error("noses", "`noses` are whole degrees from 0 to 120");
        return 0;
    }
    angles.into_iter().fold(0, |bits, angle| bits | 1 << angle as u32)
}
