//! Changes of frames that incremental words travel.
//!
//! On some controls an incremental word counts from the programmed value of its axis, not from the position of the
//! axis. After a change of the frame, of the work offset or of the tool length the change is then travelled with the
//! word (Siemens SD42440 and SD42442). The keys are `[control] frame_increments` and `[compensation] length_change`.
//! Invariants: an absolute word cancels the pending change of its axis; axes without a word keep it.

use super::NOISE;
use crate::channel_context::ChannelContext;
use crate::position::MotionState;
use counterpoint_event::event::{MAX_AXES, Position};

impl ChannelContext<'_> {
    /// Reference of incremental words, if it is not the position of the axes after a change of frames.
    pub fn counts_from(&self) -> Option<Position> {
        (self.env.machine.habits.frame_increments || self.block.flags.travels).then(|| self.state.place.counted())
    }
}

impl MotionState {
    /// The values that the axes were programmed to.
    pub fn counted(&self) -> Position {
        let mut from = self.programmed();
        if let Some(ways) = self.frames.as_deref().and_then(|frames| frames.ways.as_deref()) {
            for (slot, way) in from.iter_mut().zip(ways) {
                *slot += way;
            }
        }
        from
    }

    /// A frame has changed: records the distance to travel since then.
    pub fn keep_ways(&mut self, before: Option<Position>) {
        let Some(before) = before else { return };
        let after = self.programmed();
        let mut ways = [0.0; MAX_AXES];
        for ((slot, before), after) in ways.iter_mut().zip(before).zip(after) {
            let way = before - after;
            *slot = if way.abs() < NOISE { 0.0 } else { way };
        }
        let ways = ways.iter().any(|way| *way != 0.0).then(|| Box::new(ways));
        if ways.is_some() || self.frames.is_some() {
            self.frames().ways = ways;
            self.frames_changed();
        }
    }

    /// Axes that were programmed have no way left.
    pub fn ways_travelled(&mut self, coded: u8) {
        let Some(frames) = self.frames.as_deref_mut() else { return };
        let Some(ways) = frames.ways.as_deref_mut() else { return };
        for (at, way) in ways.iter_mut().enumerate() {
            if coded & 1 << at != 0 {
                *way = 0.0;
            }
        }
        if ways.iter().all(|way| *way == 0.0) {
            frames.ways = None;
            self.frames_changed();
        }
    }
}
