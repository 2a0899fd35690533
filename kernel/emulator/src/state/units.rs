//! Factors from what a program counts in to what the machine counts in.

use super::channel::Channel;
use super::modal::group;
use counterpoint_event::info::Unit;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::dimension::Dimension;

impl Channel<'_> {
    /// Factor from program units to machine units.
    pub(crate) fn unit_factor(&self, dimension: Dimension) -> f64 {
        if !self.state.secondary {
            return 1.0;
        }
        match (dimension, self.env.machine.unit) {
            (Dimension::Length | Dimension::Feed, Unit::Mm) => 25.4,
            (Dimension::Length | Dimension::Feed, Unit::Inch) => 1.0 / 25.4,
            // The least increment of an inch is ten times finer.
            (Dimension::Increments, Unit::Mm) => 2.54,
            (Dimension::Increments, Unit::Inch) => 10.0 / 25.4,
            _ => 1.0,
        }
    }

    /// Factor from programmed positions of X to those of its axis: the program may count radii along a diameter axis, or
    /// diameters along another one (reference control-emulator.md 6.2).
    #[cold]
    pub(crate) fn diameter_factor(&self) -> f64 {
        match (self.state.modal.code(group::DIAMETER_X), self.state.place.scale_of(0) < 1.0) {
            (Some(codes::XAXIS_RADIUS), true) => 2.0,
            (Some(codes::XAXIS_DIAMETER), false) => 0.5,
            _ => 1.0,
        }
    }
}
