//! Channels in loops that only read shared data.
//!
//! Every change of shared data raises a counter. A pass that starts and ends at the same counter, and with the same
//! state of its own channel, repeats indefinitely unless another channel changes something. A kernel in such a loop
//! rests until another channel changes something, waits or ends. It continues at the start of the first pass after
//! that. *Invariants:* passes and changes come in tag order. So only simulated time decides when a kernel rests, when
//! it continues, and when no kernel is left to change anything. A resting kernel has seen all changes before its next
//! pass. Facts: reference channel-synchronisation.md 2.4.

use std::sync::Arc;

use counterpoint_event::FileId;
use counterpoint_event::event::VerdictMember;
use counterpoint_event::info::Info;

use super::{BLOCKED, KernelStatus, Order, Wake};
use crate::tag::Tag;
use crate::verdict;

/// A pass of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoopPass {
    /// File of the loop.
    pub file: FileId,
    /// First line, and the line of the jump back.
    pub lines: (u32, u32),
    /// Passes so far.
    pub count: u64,
    /// Shared data that it reads, a bit each.
    pub reads: u64,
}

/// A loop that cannot end by itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Spin {
    lap: LoopPass,
    /// The variables that it reads.
    names: Arc<str>,
    /// Number of changes of shared data before it.
    changes: u64,
}

/// Passes that a kernel does not execute, since each would be like the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Nap {
    /// Begin of the first one, ns.
    from: i64,
    /// Time of one, ns.
    every: i64,
}

impl Nap {
    /// Skipped passes, and the start of the next one: the first that can see the event at this tag.
    fn until(self, tag: Tag, channel: u16) -> (u64, Tag) {
        let whole = (tag.t - self.from).div_euclid(self.every).max(0);
        let begin =
            |passes: i64| Tag { t: self.from.saturating_add(self.every.saturating_mul(passes)), micro: 0, channel };
        let passes = if whole > 0 && begin(whole) > tag { whole } else { whole + 1 };
        (passes.unsigned_abs(), begin(passes))
    }

    /// Passes left out until this tag.
    fn count(self, tag: Tag, channel: u16) -> u64 {
        self.until(tag, channel).0 - 1
    }
}

/// Next action of a channel after a pass that has only read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PassOutcome {
    /// The next pass; this many changes there are until now.
    Pass(u64),
    /// Every pass is like this one until another channel does something: it waits for [`Wake::Roused`].
    Rest,
    /// Every pass is like this one, and no channel is left to change that.
    Hopeless,
}

impl Order {
    /// Something that channels share is changed.
    pub fn change(&mut self) {
        self.changes += 1;
        self.rouse();
    }

    /// A pass of the channel that acts ends and has only read; `begun` has the changes at its start if the channel is
    /// in the same state as then. `every`: the pass has read at one instant, and so long after it, ns, the next one
    /// begins.
    pub fn lap(
        &mut self,
        tag: Tag,
        lap: LoopPass,
        begun: Option<u64>,
        names: &Arc<str>,
        every: Option<i64>,
    ) -> PassOutcome {
        let (changes, channel) = (self.changes, tag.channel);
        if begun != Some(changes) {
            return PassOutcome::Pass(changes);
        }
        if let Some(seat) = self.seat(channel) {
            seat.spin = Some(Spin { lap, names: Arc::clone(names), changes });
        }
        let left = |seat: &super::Seat| {
            !matches!(seat.status, KernelStatus::Blocked | KernelStatus::Done) && !self.spins(seat)
        };
        if !self.seats.iter().any(left) {
            return PassOutcome::Hopeless;
        }
        let (Some(every), None) = (every.filter(|every| *every > 0), self.stop) else {
            return PassOutcome::Pass(changes);
        };
        self.rest(channel, KernelStatus::Blocked, BLOCKED);
        if let Some(seat) = self.seat(channel) {
            seat.nap = Some(Nap { from: tag.t, every });
        }
        self.napping = self.napping.with(channel);
        PassOutcome::Rest
    }

    /// The channel that acts has done something that may end loops of others.
    pub(super) fn rouse(&mut self) {
        let now = self.now;
        for channel in std::mem::take(&mut self.napping).iter() {
            if let Some(nap) = self.seat(channel).and_then(|seat| seat.nap.take()) {
                let (passes, tag) = nap.until(now, channel);
                self.resume(channel, Wake::Roused { tag, passes });
            }
        }
    }

    fn spins(&self, seat: &super::Seat) -> bool {
        seat.spin.as_ref().is_some_and(|spin| spin.changes == self.changes)
    }

    /// The variable that a channel polls, and the place, if the channel is in a loop that cannot end by itself.
    pub fn polling(&self, channel: u16, info: &Info) -> Option<(String, VerdictMember)> {
        let seat = self.seats.get(self.channels.index(channel))?;
        let running = seat.nap.is_some() || !matches!(seat.status, KernelStatus::Blocked | KernelStatus::Done);
        let Spin { lap, names, .. } = seat.spin.as_ref().filter(|_| running && self.spins(seat))?;
        let (first, last) = lap.lines;
        let left_out = seat.nap.map_or(0, |nap| nap.count(self.now, channel));
        let text = format!(
            "channel {channel} polls {names} at {}; it looped {} times over lines {first}-{last} of {} without reaching a wait",
            verdict::place(info, lap.file, first),
            lap.count + left_out,
            info.place_name(lap.file, last)
        );
        Some((text, VerdictMember { channel, file: lap.file, line: first, waiting_for: Vec::new() }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::Channels;
    use crate::shared::SharedState;
    use crate::testing::{info, waits};

    const LAP: LoopPass = LoopPass { file: 0, lines: (2, 3), count: 5, reads: 1 };

    fn order() -> Order {
        Order::new(Channels::new(1..=3), SharedState::default(), waits(3))
    }

    const TICK: i64 = 1_000_000;

    fn tag(channel: u16, t: i64) -> Tag {
        Tag { t, micro: 0, channel }
    }

    fn lap(order: &mut Order, channel: u16, begun: u64) -> bool {
        order.lap(tag(channel, 0), LAP, Some(begun), &"#100".into(), None) == PassOutcome::Hopeless
    }

    #[test]
    fn all_that_run_are_hopeless_at_the_same_change() {
        let mut order = order();
        assert_eq!(order.lap(tag(1, 0), LAP, None, &"#100".into(), None), PassOutcome::Pass(0));
        assert!(!lap(&mut order, 1, 0));
        assert!(!lap(&mut order, 2, 0), "channel 3 may still write");
        order.block(3);
        assert!(lap(&mut order, 1, 0));
        let (text, member) = order.polling(2, &info()).unwrap();
        assert!(text.starts_with("channel 2 polls #100 at "), "{text}");
        assert_eq!((member.line, order.polling(3, &info())), (2, None));
    }

    #[test]
    fn a_change_gives_hope_to_all() {
        let mut order = order();
        order.done(3);
        assert!(!lap(&mut order, 1, 0));
        order.change();
        assert!(!lap(&mut order, 2, 0), "its own pass has seen the old value");
        assert!(!lap(&mut order, 2, 1), "channel 1 has not looked since");
        assert_eq!(order.polling(1, &info()), None);
        assert!(lap(&mut order, 1, 1));
    }

    /// Channel 2 rests from 5 ms on; channel 1 or 3 acts at this tag.
    fn roused(by: impl FnOnce(&mut Order), at: Tag) -> Option<Wake> {
        let mut order = order();
        let rests = order.lap(tag(2, 5 * TICK), LAP, Some(0), &"#100".into(), Some(TICK));
        assert_eq!((rests, order.status(2)), (PassOutcome::Rest, KernelStatus::Blocked));
        order.now = at;
        by(&mut order);
        order.take_wake(2)
    }

    #[test]
    fn whoever_rests_goes_on_with_the_first_pass_that_sees_the_change() {
        let wake = |passes: u64, t: i64| Some(Wake::Roused { tag: tag(2, t), passes });
        let change = |order: &mut Order| order.change();
        // Between two passes; at the start of one, by a channel before and after this one; at once after the first.
        assert_eq!(roused(change, tag(1, 7 * TICK + 1)), wake(3, 8 * TICK));
        assert_eq!(roused(change, tag(1, 8 * TICK)), wake(3, 8 * TICK));
        assert_eq!(roused(change, tag(3, 8 * TICK)), wake(4, 9 * TICK));
        assert_eq!(roused(change, Tag { micro: 1, ..tag(1, 8 * TICK) }), wake(4, 9 * TICK));
        assert_eq!(roused(change, tag(3, 5 * TICK)), wake(1, 6 * TICK));
        // A channel that waits or ends may have been the last that could change something.
        assert_eq!(roused(|order| order.block(3), tag(3, 7 * TICK)), wake(3, 8 * TICK));
        assert_eq!(roused(|order| order.done(1), tag(1, 7 * TICK)), wake(2, 7 * TICK));
        // Others have got beyond the passes before a stop, so none is executed.
        assert_eq!(roused(|order| order.stop(tag(1, 7 * TICK)), tag(1, 7 * TICK)), Some(Wake::Stopped));
        assert_eq!(roused(|_| (), tag(1, 7 * TICK)), None);
    }

    #[test]
    fn the_last_one_finds_that_nobody_is_left() {
        let mut order = order();
        let lap = |order: &mut Order, own| order.lap(tag(own, 0), LAP, Some(0), &"#100".into(), Some(TICK));
        assert_eq!(
            [lap(&mut order, 1), lap(&mut order, 2), lap(&mut order, 3)],
            [PassOutcome::Rest, PassOutcome::Rest, PassOutcome::Hopeless]
        );
        order.now = tag(3, 4 * TICK);
        assert!(order.polling(1, &info()).unwrap().0.contains("it looped 9 times"), "{:?}", order.polling(1, &info()));
    }
}
