//! The turns of a kernel that runs alone.
//!
//! Invariant: only where no other kernel of the job is ever going to run.

use super::{KernelStatus, Order};
use crate::tag::Tag;

impl Order {
    /// The turn of the only kernel that runs: none comes before it. `false`: the job was stopped before this tag.
    pub fn take_turn(&mut self, tag: Tag) -> bool {
        if self.stop.is_some_and(|stop| stop < tag) {
            return false;
        }
        if let Some(seat) = self.seat(tag.channel) {
            seat.status = KernelStatus::Running;
            seat.bound = seat.bound.max(tag.t);
        }
        (self.now, self.acting) = (tag, Some(tag.channel));
        true
    }
}
