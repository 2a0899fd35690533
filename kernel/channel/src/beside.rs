//! Axes that move to a position independently of the path of their block, each at its own rate (Siemens POS).
//!
//! Facts: programming manual of the 840D, "Positioning axes (POS, POSA, FA)": every positioning axis has an
//! interpolator and a feed of its own; a block with POS ends when all axes, those of the path too, have arrived.
//! Decision: the path stops at the end of such a block. *Invariant:* this state is empty when the next block begins.

use crate::ChannelMemory;
use counterpoint_event::event::{FeedUnit, Motion, MotionKind, Position};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::profile::stop_to_stop_smoothly;

/// Positioning axes of a block.
#[derive(Debug, Clone, Default)]
pub struct PositioningAxes {
    /// Where they go, in the work frame.
    targets: Vec<(AxisSlot, f64)>,
    /// Seconds of the axis that arrives last.
    pub seconds: f64,
    /// Its feed per minute; none at rapid.
    feed: Option<f64>,
}

impl PositioningAxes {
    /// A move that takes the axes along.
    pub fn with(&self, motion: &Motion) -> Motion {
        let mut motion = *motion;
        for &(axis, to) in &self.targets {
            *motion.to.at_mut(axis) = to;
            motion.moving |= axis.bit();
        }
        motion
    }
}

impl ChannelMemory {
    /// An axis goes to a position of the program, at a feed per minute or rapidly.
    pub fn go_beside(&mut self, axis: AxisSlot, to: f64, feed: Option<f64>) {
        let mut point = self.place.programmed();
        *point.at_mut(axis) = to;
        let target = self.place.work_point(&point).at(axis);
        let from = self.place.position.at(axis);
        let of = &self.place.layout.axes[axis];
        let speed = feed.map_or(of.rapid, |feed| (feed / 60.0).min(of.rapid));
        let change = (target - from).abs() * of.scale;
        let seconds = stop_to_stop_smoothly(change, speed, of.dynamics.acceleration, of.dynamics.jerk);
        let beside = self.others.beside.get_or_insert_default();
        beside.targets.retain(|(other, _)| *other != axis);
        beside.targets.push((axis, target));
        if seconds > beside.seconds || beside.targets.len() == 1 {
            (beside.seconds, beside.feed) = (seconds, feed);
        }
    }

    /// The move of the positioning axes alone, if any of them moves.
    pub fn move_beside(&self, beside: &PositioningAxes) -> Option<Motion> {
        let from = self.place.position;
        let (kind, feed) = match beside.feed {
            None => (MotionKind::Rapid, (0.0, FeedUnit::Rapid)),
            Some(feed) => (MotionKind::Linear, (feed, FeedUnit::PerMinute)),
        };
        let mut motion = beside.with(&Motion::straight(kind, 0, [from, from], feed, 0.0));
        motion.length = self.way_beside(&from, &motion.to);
        (motion.to != from).then_some(motion)
    }

    fn way_beside(&self, from: &Position, to: &Position) -> f64 {
        let changes = self.place.changes(from, to);
        let sum = |rotary: bool| {
            let axes = self.place.layout.axes.iter().zip(&changes).filter(|(axis, _)| axis.rotary == rotary);
            axes.map(|(_, change)| change * change).sum::<f64>()
        };
        let linear = sum(false);
        if linear > 0.0 { linear.sqrt() } else { sum(true).sqrt() }
    }
}
