//! Time of codes and spindles from the machine's tables, overlapping other work or alone.
//!
//! Facts: reference channel-synchronisation.md 3 (M, S and T times). *Invariant:* a function that overlaps other work
//! starts at a known time, so the path stops before the function. If the function must end but is still running, the
//! channel waits for its end, and the log shows the wait as that function.

use counterpoint_event::event::{Kind, MotionKind, TimedFunction};
use counterpoint_machine::rows::{CodeRow, TimeOverlap};
use counterpoint_program::block::PendingCode;

use crate::RunningFunction;
use crate::at::nanoseconds;
use crate::channel_context::ChannelContext;

/// Slots of the functions that end with their block, and of those that end before the next move at feed.
const SLOTS: [TimeOverlap; 2] = [TimeOverlap::Block, TimeOverlap::Rapids];

/// Time of a code from the machine's table.
pub fn take_time(channel: &mut ChannelContext<'_>, row: &CodeRow, pending: PendingCode) {
    let ns = nanoseconds(row.seconds);
    let (letter, value) = (channel.env.machine.letter_of(&row.form), pending.value);
    if runs_beside(channel, row.overlap, (letter, value), ns) {
        channel.emit(0, Kind::Function(TimedFunction { letter, value }));
        return;
    }
    channel.emit(ns, Kind::Function(TimedFunction { letter, value }));
    channel.advance(ns);
}

/// Starts a function that overlaps other work; `false` if the function takes its time alone.
pub fn runs_beside(
    channel: &mut ChannelContext<'_>,
    overlap: TimeOverlap,
    (letter, value): (char, f64),
    ns: i64,
) -> bool {
    let Some(slot) = SLOTS.iter().position(|slot| *slot == overlap) else { return false };
    channel.come_to_rest();
    let end_ns = channel.at.clock.saturating_add(ns);
    if let Some(slot) = channel.state.others.running.get_mut(slot)
        && slot.is_none_or(|running| running.end_ns <= end_ns)
    {
        *slot = Some(RunningFunction { letter, value, end_ns });
    }
    true
}

/// Ends the functions that overlap a block, at its end.
#[cold]
#[inline(never)]
pub fn end_functions(channel: &mut ChannelContext<'_>) {
    wait_for_function(channel, 0);
}

/// Ends the functions that may overlap rapid moves, before a move at feed.
#[cold]
#[inline(never)]
pub fn end_before_feed(channel: &mut ChannelContext<'_>, kind: MotionKind) {
    if kind != MotionKind::Rapid {
        wait_for_function(channel, 1);
    }
}

fn wait_for_function(channel: &mut ChannelContext<'_>, slot: usize) {
    let Some(running) = channel.state.others.running.get_mut(slot).and_then(Option::take) else { return };
    channel.come_to_rest();
    let left = running.end_ns - channel.at.clock;
    if left > 0 {
        let RunningFunction { letter, value, .. } = running;
        channel.emit(left, Kind::Function(TimedFunction { letter, value }));
        channel.advance(left);
    }
}

/// Waits until the turret has indexed.
pub fn wait_for_index(channel: &mut ChannelContext<'_>) {
    for slot in 0..SLOTS.len() {
        let running = channel.state.others.running.get(slot).copied().flatten();
        if running.is_some_and(|running| running.letter == 'T') {
            wait_for_function(channel, slot);
        }
    }
}
