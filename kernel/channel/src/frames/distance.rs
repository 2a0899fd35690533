//! Distances between positions, in geometry units.

use super::FrameTransforms;
use crate::channel_context::ChannelContext;
use crate::feed_group::FeedGroup;
use crate::position::MotionState;
use counterpoint_event::event::{FeedUnit, MAX_AXES, Position};
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::index::BySlot;

impl ChannelContext<'_> {
    /// The changes that count for a feed. A degree counts as a unit of length of the program (Fanuc B-63174EN/03 4.2),
    /// unless degrees are distances along the part or its tip, or the control counts certain axes only.
    pub fn feed_ways(&self, changes: &Position) -> Position {
        if let Some(group) = self.state.place.feed_group.as_deref() {
            return self.ways_of_group(group, changes);
        }
        let mut out = *changes;
        let unit = self.unit_factor(Dimension::Feed);
        let frames = self.state.place.frames.as_deref();
        let on_part =
            |frames: &FrameTransforms| frames.tip.is_some() || frames.polar.is_some() || frames.feeds.rotary_length;
        if unit != 1.0 && !frames.is_some_and(on_part) {
            for (slot, _) in out.iter_mut().zip(&self.state.place.layout.axes).filter(|(_, axis)| axis.rotary) {
                *slot *= unit;
            }
        }
        out
    }

    /// Feed of a move by the unit of its axes: degrees if only rotary axes move.
    pub fn feed_of_axes(&self, feed: Option<f64>, unit: FeedUnit, changes: &Position) -> f64 {
        let feed = feed.unwrap_or(0.0);
        if !self.state.place.layout.rotary || unit == FeedUnit::InverseTime {
            return feed;
        }
        let moves = self.state.place.layout.axes.iter().zip(changes).filter(|(_, change)| **change != 0.0);
        let turns = moves.fold(None, |turns, (axis, _)| Some(turns.unwrap_or(true) && axis.rotary));
        if turns == Some(true) && !self.state.place.feed_group.as_deref().is_some_and(FeedGroup::turns_by_length) {
            feed / self.unit_factor(Dimension::Feed)
        } else {
            feed
        }
    }
}

impl MotionState {
    /// Sets the group that the feed is for.
    pub(crate) fn put_feed_group(&mut self, group: Option<Box<FeedGroup>>) {
        self.weighs = FeedGroup::weighs(group.as_deref(), &self.layout.axes);
        self.feed_group = group;
    }

    /// Seconds of a move at feed; no axis that moves along exceeds its rate.
    pub fn seconds_of_group(&self, seconds: f64, changes: &Position) -> f64 {
        self.feed_group.as_deref().map_or(seconds, |group| group.seconds(&self.layout.axes, seconds, changes))
    }

    /// Change of each axis in geometry units (radius on a diameter axis).
    pub fn changes(&self, from: &Position, to: &Position) -> Position {
        let mut out = [0.0; MAX_AXES];
        for (((slot, axis), a), b) in out.iter_mut().zip(&self.layout.axes).zip(from).zip(to) {
            *slot = (b - a) * axis.scale;
        }
        out
    }

    /// Distance from the spindle axis at a position.
    pub fn radius(&self, position: &Position) -> f64 {
        let x = self.layout.cartesian.first().copied().flatten();
        x.map_or(0.0, |x| position.at(x) * self.layout.axes[x].scale)
    }
}
