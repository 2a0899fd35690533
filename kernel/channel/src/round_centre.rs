//! How far a path goes around the centre of the part.

use crate::frames::polar::round_the_centre;
use counterpoint_motion::arc as geometry;
use std::f64::consts::TAU;

/// Degrees of a circle that one step goes around its own centre.
const STEP: f64 = 2.0;

/// Degrees that a circle goes around the centre of the part; every full turn goes as far as the others.
pub fn way_round(made: &geometry::PlaneArc) -> f64 {
    let turns = (made.sweep.abs() / TAU).floor();
    let rest = made.sweep - turns * TAU.copysign(made.sweep);
    let once = if turns > 0.0 { part_round(made, TAU.copysign(made.sweep)) } else { 0.0 };
    turns * once + part_round(made, rest)
}

/// The same for a part of at most one turn from its start, radians.
pub fn part_round(made: &geometry::PlaneArc, sweep: f64) -> f64 {
    let steps = (sweep.abs().to_degrees() / STEP).ceil().clamp(1.0, 360.0 / STEP);
    let point = |at: u32| {
        let angle = made.start_angle + sweep * (f64::from(at) / steps);
        [made.center[0] + made.radius * libm::cos(angle), made.center[1] + made.radius * libm::sin(angle)]
    };
    round_the_centre((0..=steps as u32).map(point))
}
