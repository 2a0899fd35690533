//! Channels in loops that only read what all of them share.
//!
//! Whoever changes something shared raises a counter. A pass that begins and ends at the same counter, and with the same
//! state of its own channel, repeats for ever unless another channel changes something. *Invariant:* passes and changes come
//! in tag order, so it depends on simulated time alone when nobody is left to do that. Facts: reference
//! channel-synchronisation.md 2.4.

use std::sync::Arc;

use counterpoint_event::FileId;
use counterpoint_event::event::Member;
use counterpoint_event::info::Info;

use super::{Order, Status};
use crate::verdict;

/// A pass of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lap {
    /// File of the loop.
    pub file: FileId,
    /// First line, and the line of the jump back.
    pub lines: (u32, u32),
    /// Passes so far.
    pub count: u64,
    /// What it reads of what is shared, a bit each.
    pub reads: u64,
}

/// A loop that cannot end by itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Spin {
    lap: Lap,
    /// The variables that it reads.
    names: Arc<str>,
    /// Changes of what is shared before it.
    changes: u64,
}

impl Order {
    /// Something that channels share is changed.
    pub fn change(&mut self) {
        self.changes += 1;
    }

    /// A pass of a channel ends that has only read; `begun` has the changes at its begin if the channel is in the same state
    /// as then. Gives the changes until now, and whether nobody is left to make another one.
    pub fn lap(&mut self, channel: u16, lap: Lap, begun: Option<u64>, names: &Arc<str>) -> (u64, bool) {
        let changes = self.changes;
        if begun != Some(changes) {
            return (changes, false);
        }
        if let Some(seat) = self.seat(channel) {
            seat.spin = Some(Spin { lap, names: Arc::clone(names), changes });
        }
        let left = |seat: &super::Seat| !matches!(seat.status, Status::Blocked | Status::Done) && !self.spins(seat);
        (changes, !self.seats.iter().any(left))
    }

    fn spins(&self, seat: &super::Seat) -> bool {
        seat.spin.as_ref().is_some_and(|spin| spin.changes == self.changes)
    }

    /// What a channel polls, and where, if it is in a loop that cannot end by itself.
    pub fn polling(&self, channel: u16, info: &Info) -> Option<(String, Member)> {
        let seat = self.seats.get(self.channels.index(channel))?;
        let running = !matches!(seat.status, Status::Blocked | Status::Done);
        let Spin { lap, names, .. } = seat.spin.as_ref().filter(|_| running && self.spins(seat))?;
        let (first, last) = lap.lines;
        let text = format!(
            "channel {channel}: polls {names} at {}; it looped {} times over lines {first}-{last} of {} without a wait",
            verdict::place(info, lap.file, first),
            lap.count,
            info.place_name(lap.file, last)
        );
        Some((text, Member { channel, file: lap.file, line: last, waiting_for: Vec::new() }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channels::Channels;
    use crate::shared::Shared;
    use crate::testing::{info, waits};

    const LAP: Lap = Lap { file: 0, lines: (2, 3), count: 5, reads: 1 };

    fn order() -> Order {
        Order::new(Channels::new(1..=3), Shared::default(), waits(3))
    }

    fn lap(order: &mut Order, channel: u16, begun: u64) -> bool {
        order.lap(channel, LAP, Some(begun), &"#100".into()).1
    }

    #[test]
    fn all_that_run_are_hopeless_at_the_same_change() {
        let mut order = order();
        assert_eq!(order.lap(1, LAP, None, &"#100".into()), (0, false));
        assert!(!lap(&mut order, 1, 0));
        assert!(!lap(&mut order, 2, 0), "channel 3 may still write");
        order.block(3);
        assert!(lap(&mut order, 1, 0));
        let (text, member) = order.polling(2, &info()).unwrap();
        assert!(text.starts_with("channel 2: polls #100 at "), "{text}");
        assert_eq!((member.line, order.polling(3, &info())), (3, None));
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
}
