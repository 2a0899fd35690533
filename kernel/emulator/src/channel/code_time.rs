//! Time of codes and spindles from the machine's tables, overlapping other work or alone.
//!
//! Facts: reference channel-synchronisation.md 3 (M, S and T times). *Invariant:* a function that overlaps other work
//! starts at a known time, so the path stops before it. A function that is still running when it must be over is waited
//! for, and the wait is shown as that function.

use super::Kernel;
use counterpoint_channel::RunningFunction;
use counterpoint_channel::at::nanoseconds;
use counterpoint_event::event::{Kind, MotionKind, TimedFunction};
use counterpoint_machine::rows::{CodeRow, TimeOverlap};
use counterpoint_program::block::PendingCode;

/// Where the functions that end with their block are kept, and those that end before the next move at feed.
const SLOTS: [TimeOverlap; 2] = [TimeOverlap::Block, TimeOverlap::Rapids];

impl Kernel<'_> {
    /// Time of a code from the machine's table.
    pub(crate) fn take_time(&mut self, row: &CodeRow, pending: PendingCode) {
        let ns = nanoseconds(row.seconds);
        let (letter, value) = (self.channel.env.machine.letter_of(&row.form), pending.value);
        if self.runs_beside(row.overlap, (letter, value), ns) {
            self.channel.emit(0, Kind::Function(TimedFunction { letter, value }));
            return;
        }
        self.channel.emit(ns, Kind::Function(TimedFunction { letter, value }));
        self.channel.advance(ns);
    }

    /// Starts a function that takes its time beside other work; `false` if it takes its time alone.
    pub(super) fn runs_beside(&mut self, overlap: TimeOverlap, (letter, value): (char, f64), ns: i64) -> bool {
        let Some(slot) = SLOTS.iter().position(|slot| *slot == overlap) else { return false };
        self.channel.come_to_rest();
        let end_ns = self.channel.at.clock.saturating_add(ns);
        if let Some(slot) = self.channel.state.others.running.get_mut(slot)
            && slot.is_none_or(|running| running.end_ns <= end_ns)
        {
            *slot = Some(RunningFunction { letter, value, end_ns });
        }
        true
    }

    /// Ends the functions that overlap a block, at its end.
    #[cold]
    #[inline(never)]
    pub(crate) fn end_functions(&mut self) {
        self.wait_for_function(0);
    }

    /// A move begins: before one at feed everything that runs is over.
    #[cold]
    #[inline(never)]
    pub(super) fn end_before_feed(&mut self, kind: MotionKind) {
        if kind != MotionKind::Rapid {
            self.wait_for_function(1);
        }
    }

    fn wait_for_function(&mut self, slot: usize) {
        let Some(running) = self.channel.state.others.running.get_mut(slot).and_then(Option::take) else { return };
        self.channel.come_to_rest();
        let left = running.end_ns - self.channel.at.clock;
        if left > 0 {
            let RunningFunction { letter, value, .. } = running;
            self.channel.emit(left, Kind::Function(TimedFunction { letter, value }));
            self.channel.advance(left);
        }
    }
}

/// Waits until the turret has indexed.
pub(super) fn wait_for_index(kernel: &mut Kernel<'_>) {
    for slot in 0..SLOTS.len() {
        let running = kernel.channel.state.others.running.get(slot).copied().flatten();
        if running.is_some_and(|running| running.letter == 'T') {
            kernel.wait_for_function(slot);
        }
    }
}
