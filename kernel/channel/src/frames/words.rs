//! Words of the plane that are a radius and an angle (polar coordinate command).
//!
//! *Invariant:* nothing is remembered but the words of the last block, for holes that repeat it: a word that is missing
//! is that of the place where the tool is. Decisions: docs/emulation.md, "Polar coordinate command".

use counterpoint_event::event::Position;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::{direction, plus};

use super::clean;
use crate::frame_transforms::PolarWords;
use crate::position::MotionState;

impl PolarWords {
    /// Puts the point of the words into a target. A radius that is a distance counts from where the tool is, every
    /// other one from the zero of the program; an angle that is a distance counts from the direction in which the tool
    /// stands as seen from there.
    pub fn put(self, place: &MotionState, axes: [AxisSlot; 2], from: &Position, target: &mut Position) {
        let scales = axes.map(|axis| place.layout.axes[axis].scale);
        let [x, y] = [from.at(axes[0]) * scales[0], from.at(axes[1]) * scales[1]];
        let stands = libm::atan2(y, x).to_degrees();
        let (radius, center) = match self.radius {
            Some((radius, true)) => (radius, [x, y]),
            Some((radius, false)) => (radius, [0.0; 2]),
            None => (libm::hypot(x, y), [0.0; 2]),
        };
        let angle = match self.angle {
            Some((angle, true)) => stands + angle,
            Some((angle, false)) => angle,
            None => stands,
        };
        let point = plus(center, direction(angle), radius);
        for ((axis, value), scale) in axes.into_iter().zip(point).zip(scales) {
            *target.at_mut(axis) = clean(value / scale, from.at(axis)) + 0.0;
        }
    }
}
