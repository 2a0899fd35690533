//! Feeds that depend on the way of a move, while a code says so.
//!
//! *Invariant:* the radius of a turn is that of the beginning of the move.

use counterpoint_event::event::Position;
use counterpoint_machine::index::{AxisSlot, BySlot};

use crate::channel_context::ChannelContext;

impl ChannelContext<'_> {
    /// How far the tip is from the line about which a rotary axis leads it over the part, at a point of the work frame.
    fn turn_radius(&self, from: &Position, axis: AxisSlot) -> f64 {
        let machine = self.state.place.machine_point(from);
        let place = &self.state.place;
        let (linear, tool) = (place.geometry(&machine), place.geometry(&self.tool_shift()));
        let chain = self.chain();
        // Half a turn leads to the other end of a diameter.
        let ends = [0.0, 180.0]
            .map(|turn| chain.tip(linear, tool, |of: AxisSlot| machine.at(of) + if of == axis { turn } else { 0.0 }));
        let [Some(one), Some(other)] = ends else { return 0.0 };
        one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt() / 2.0
    }

    /// Angles of rotary axes as the distances that the tip makes on the part.
    #[cold]
    pub(super) fn as_ways(&self, changes: &mut Position, from: &Position) {
        for (axis, of) in self.state.place.layout.axes.entries() {
            let turned = changes.at(axis).to_radians();
            if of.rotary && turned != 0.0 {
                *changes.at_mut(axis) = turned * self.turn_radius(from, axis);
            }
        }
    }
}
