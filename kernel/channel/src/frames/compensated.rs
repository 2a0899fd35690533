//! The active compensation of a channel.
//!
//! *Invariant:* a channel without frames has no active compensation.

use crate::cutter::CutterCompensation;
use crate::position::MotionState;

impl MotionState {
    /// Compensation, if it is active.
    pub fn cutter(&mut self) -> Option<&mut CutterCompensation> {
        self.frames.as_deref_mut()?.cutter.as_deref_mut()
    }

    /// Delays the moves that compensation holds back, by the delay of the clock, ns.
    pub fn delay_waiting_moves(&mut self, ns: i64) {
        if let Some(cutter) = self.cutter().filter(|_| ns != 0) {
            cutter.waiting.iter_mut().for_each(|waiting| waiting.clock += ns);
        }
    }

    /// Whether compensation is active.
    #[inline(always)]
    pub fn is_compensated(&self) -> bool {
        self.frames.as_deref().is_some_and(|frames| frames.cutter.is_some())
    }

    /// Records the end of compensation.
    pub fn forget_cutter(&mut self) {
        if let Some(frames) = self.frames.as_deref_mut() {
            frames.cutter = None;
        }
        self.frames_changed();
    }
}
