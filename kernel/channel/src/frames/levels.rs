//! The level where a cycle began is a position of the machine, even if frames change while it is active.
//!
//! *Invariant:* without an active cycle nothing is done.

use crate::ChannelMemory;
use crate::channel_context::ChannelContext;
use counterpoint_event::event::Position;
use counterpoint_machine::index::{AxisSlot, BySlot};

/// Where the levels of an active cycle are in the machine.
#[derive(Debug, Clone, Copy)]
pub struct CycleLevels {
    axis: AxisSlot,
    initial: Position,
    reference: Position,
}

impl ChannelContext<'_> {
    /// The level at which a cycle starts. Where the control moves axes by changes of the tool length, a pending change
    /// is travelled on the way to the hole.
    pub fn cycle_level(&self, axis: AxisSlot) -> f64 {
        let from = if self.env.machine.compensation.length.moves {
            self.state.place.counted()
        } else {
            self.state.place.programmed()
        };
        from.at(axis)
    }
}

impl ChannelMemory {
    /// The levels of an active cycle, taken before frames change.
    pub fn cycle_levels(&mut self) -> Option<CycleLevels> {
        let (_, axis) = self.cycle.axis.filter(|_| self.cycle.running)?;
        let [initial, reference] = [self.cycle.heights.initial, self.cycle.heights.reference].map(|level| {
            let mut at = self.place.programmed();
            *at.at_mut(axis) = level;
            let work = self.place.work_point(&at);
            self.place.machine_point(&work)
        });
        Some(CycleLevels { axis, initial, reference })
    }

    /// Puts them back after the change.
    pub fn keep_levels(&mut self, levels: Option<CycleLevels>) {
        let Some(CycleLevels { axis, initial, reference }) = levels else { return };
        let [initial, reference] = [initial, reference].map(|machine| {
            let work = self.place.point_of_machine(&machine);
            Some(self.place.program_point(&work).at(axis)).filter(|level| level.is_finite())
        });
        self.cycle.heights.initial = initial.unwrap_or(self.cycle.heights.initial);
        self.cycle.heights.reference = reference.unwrap_or(self.cycle.heights.reference);
    }
}
