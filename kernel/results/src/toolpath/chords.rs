//! Circles as chords, by positions of the axes.
//!
//! *Invariant:* the points where an axis turns back are among them, so the extent of the chords is that of the circle.

use counterpoint_event::event::{Motion, Position};
use counterpoint_event::info::JobAxis;

use crate::geometry::{Loop, Sweep, scale};

/// Longest chord, radians.
pub(super) const CHORD: f64 = std::f64::consts::TAU / 120.0;

/// Chords of a circle with many turns.
pub(super) const MOST_CHORDS: f64 = 4000.0;

/// Shares of the path at which chords of a turn through this angle end, both ends of the path excluded.
pub(super) fn shares(angle: f64) -> Vec<f64> {
    let parts = (angle.abs() / CHORD).ceil().clamp(1.0, MOST_CHORDS);
    (1..parts as u32).map(|part| f64::from(part) / parts).collect()
}

/// The path between two positions, all axes in proportion.
pub(super) fn between(motion: &Motion, share: f64) -> Position {
    let mut position = motion.to;
    for ((slot, to), from) in position.iter_mut().zip(motion.to).zip(motion.from) {
        *slot = from + (to - from) * share;
    }
    position
}

/// Positions on an arc in a plane, its ends excluded.
pub(super) fn of_arc(motion: &Motion, sweep: &Sweep, axes: &[JobAxis]) -> Vec<Position> {
    let mut shares = shares(sweep.angle);
    shares.extend(sweep.turning_points());
    shares.sort_by(f64::total_cmp);
    let at = |share| {
        let mut position = between(motion, share);
        for (axis, value) in sweep.axes.into_iter().zip(sweep.at(share)) {
            if let (Some(slot), Some(own)) = (position.get_mut(axis), axes.get(axis)) {
                *slot = value / scale(own);
            }
        }
        position
    };
    shares.into_iter().map(at).collect()
}

/// Positions on a circle in space, its ends excluded.
pub(super) fn of_loop(motion: &Motion, space: &Loop) -> Vec<Position> {
    let mut shares = shares(space.circle.sweep);
    shares.extend((0..3).flat_map(|side| space.circle.turning_points(side)).flatten());
    shares.sort_by(f64::total_cmp);
    shares.into_iter().map(|share| space.at(motion, share)).collect()
}
