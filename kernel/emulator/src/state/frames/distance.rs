//! Distances between positions, in geometry units.

use crate::state::channel::Channel;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::index::BySlot;

impl Channel<'_> {
    /// Change of each axis in geometry units (radius on a diameter axis).
    pub(crate) fn changes(&self, from: &Position, to: &Position) -> Position {
        let mut out = [0.0; MAX_AXES];
        for (((slot, axis), a), b) in out.iter_mut().zip(&self.state.place.layout.axes).zip(from).zip(to) {
            *slot = (b - a) * axis.scale;
        }
        out
    }

    /// Distance from the spindle axis at a position.
    pub(crate) fn radius(&self, position: &Position) -> f64 {
        let x = self.state.place.layout.cartesian.first().copied().flatten();
        x.map_or(0.0, |x| position.at(x) * self.state.place.layout.axes[x].scale)
    }
}
