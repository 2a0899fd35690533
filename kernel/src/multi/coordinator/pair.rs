//! Meetings of two kernels that are alone in a job, without the lock.
//!
//! Who arrives writes its arrival into its cell and shows it with a ticket. Who finds the other one's ticket there, and
//! waits for the same meeting, takes it: one word says how much later the meeting lets go, and both know the rest. Both
//! may do so at once, and mean the same. Whatever is not as simple as that (another code, a shared operation of the
//! partner, a stop, patience at its end) makes a kernel withdraw its ticket and arrive under the lock. Invariants: a
//! ticket is used once; a cell is written by its owner, but for the word that takes its ticket; a kernel that stands
//! here counts as running at its arrival.

use std::sync::atomic::{
    AtomicBool, AtomicI64, AtomicU32, AtomicU64,
    Ordering::{Acquire, Relaxed, Release, SeqCst},
};

use super::sleep::LOOK_EVERY;
use super::{Coordinator, Wake};
use crate::multi::tag::Tag;
use crate::multi::waits::{Set, Waiting, after};

/// Nobody stands here.
const EMPTY: u64 = 0;
/// Of a word that took a ticket. Below it stand the time by which the partner came later, ns, and 16 bits of microstep.
const TAKEN: u64 = 1 << 63;
const MICRO_BITS: u32 = 16;
/// Never in a cell.
const NEVER: u64 = u64::MAX;

/// The place where two kernels meet.
#[derive(Debug, Default)]
pub(super) struct Pair {
    /// The only two kernels, 16 bits each; 0: there are more, or fewer.
    parts: AtomicU32,
    /// The lock is needed at the next meeting: it orders commands to a shared spindle.
    orders: AtomicBool,
    cells: [Cell; 2],
    known: [Known; 2],
}

/// The arrival of one kernel.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Cell {
    /// [`EMPTY`], the ticket of the kernel that stands here, or the word that took it.
    state: AtomicU64,
    t: AtomicI64,
    micro: AtomicU32,
    code: AtomicU64,
    named: AtomicU64,
    /// Meetings so far, as the owner knew at its arrival.
    meetings: AtomicU64,
}

/// What a kernel keeps for itself.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Known {
    /// Tickets used.
    tickets: AtomicU64,
    /// Number of the last meeting it took part in here.
    meetings: AtomicU64,
}

impl Coordinator {
    /// Only these two kernels are going to run.
    pub(crate) fn set_pair(&self, a: u16, b: u16) {
        if self.spin > 0 {
            self.pair.parts.store(u32::from(a) << 16 | u32::from(b), Relaxed);
        }
    }

    /// These are the only kernels that run.
    pub(crate) fn is_pair(&self, parts: Set) -> bool {
        let pair = self.pair.parts.load(Relaxed);
        pair != 0 && parts == Set::default().with((pair >> 16) as u16).with(pair as u16)
    }

    /// The next meeting has to order commands to spindles.
    pub(crate) fn set_orders(&self, orders: bool) {
        self.pair.orders.store(orders, Relaxed);
    }

    /// Meets the only other kernel if that is simple; `None`: arrive under the lock.
    pub(super) fn meet_pair(&self, waiting: &Waiting, work: &mut impl FnMut(bool) -> bool) -> Option<Wake> {
        let pair = &self.pair;
        let (rank, parts) = (waiting.tag.rank, waiting.spec.parts);
        if !self.is_pair(parts) || pair.orders.load(Relaxed) {
            return None;
        }
        let other = parts.iter().find(|&c| c != rank)?;
        let lower = usize::from(rank > other);
        let (own, its) = (pair.cells.get(lower)?, pair.cells.get(1 - lower)?);
        let known = pair.known.get(lower)?;
        let meetings = self.meetings.load(Acquire).max(known.meetings.load(Relaxed));
        let on = match its.take(waiting, meetings) {
            Partner::Met(t, micro) => (t, micro),
            Partner::Elsewhere => return None,
            Partner::Absent => {
                let ticket = known.tickets.load(Relaxed) + 1;
                known.tickets.store(ticket, Relaxed);
                own.show(ticket, waiting, meetings);
                // Both may have come at once: at least the later one sees the other.
                match its.take(waiting, meetings) {
                    Partner::Met(t, micro) => {
                        let _ = own.withdraw(ticket);
                        (t, micro)
                    }
                    partner => {
                        if matches!(partner, Partner::Absent) {
                            self.stand(own, ticket, rank, work);
                        }
                        own.withdraw(ticket).map(|word| taken_at(word, waiting.tag))?
                    }
                }
            }
        };
        let meeting = meetings + 1;
        known.meetings.store(meeting, Release);
        let (t, micro) = after(on.0, on.1, self.release_ns);
        Some(Wake::Released { tag: Tag { t, micro, rank }, meeting })
    }

    /// Meetings so far. Right while the caller holds the lock for a meeting: no two kernels can be in one here then.
    pub(super) fn pair_meetings(&self) -> u64 {
        self.pair.known.iter().map(|known| known.meetings.load(Acquire)).max().unwrap_or(0)
    }

    /// Works and waits until the ticket is taken, something else is to be done, or the patience is over.
    fn stand(&self, own: &Cell, ticket: u64, rank: u16, work: &mut impl FnMut(bool) -> bool) {
        let Some(slot) = self.slot(rank) else { return };
        let seen = slot.signal.load(Acquire);
        let standing = || own.state.load(Relaxed) == ticket;
        let disturbed = || slot.need.load(Relaxed) != i64::MAX || slot.signal.load(Relaxed) != seen;
        for turn in 0..self.spin {
            while standing() && work(turn % LOOK_EVERY == LOOK_EVERY - 1) {}
            if !standing() || disturbed() {
                return;
            }
            std::hint::spin_loop();
        }
        while standing() && work(true) {}
        self.give_way(|| !standing() || disturbed());
    }
}

/// Where the other kernel is.
enum Partner {
    /// At the same meeting, whose last arrival is at this time and microstep: both go on.
    Met(i64, u32),
    /// Not at a meeting.
    Absent,
    /// At another one, or at one that is not simple, or it has just withdrawn.
    Elsewhere,
}

/// Which of the two kernels, which are all that can take part, the list of a wait names.
fn named(waiting: &Waiting) -> u64 {
    waiting.spec.parts.iter().enumerate().fold(0, |bits, (at, c)| bits | u64::from(waiting.spec.named.has(c)) << at)
}

/// The last arrival, for the kernel whose ticket was taken.
fn taken_at(word: u64, own: Tag) -> (i64, u32) {
    let later = (word & !TAKEN) >> MICRO_BITS;
    let micro = (word & ((1 << MICRO_BITS) - 1)) as u32;
    (own.t + later as i64, micro)
}

/// The word that takes a ticket shown at `its`, when the last arrival is at `last`; `None` if it does not fit.
fn taking(its: i64, (t, micro): (i64, u32)) -> Option<u64> {
    let later = u64::try_from(t.checked_sub(its)?).ok()?;
    let fits = later < 1 << (63 - MICRO_BITS) && micro < 1 << MICRO_BITS;
    fits.then_some(TAKEN | later << MICRO_BITS | u64::from(micro))
}

impl Cell {
    /// Shows an arrival.
    fn show(&self, ticket: u64, waiting: &Waiting, meetings: u64) {
        self.t.store(waiting.tag.t, Relaxed);
        self.micro.store(waiting.tag.micro, Relaxed);
        self.code.store(waiting.spec.code(), Relaxed);
        self.named.store(named(waiting), Relaxed);
        self.meetings.store(meetings, Relaxed);
        self.state.store(ticket, SeqCst);
    }

    /// Takes the ticket of the owner if it waits for the same meeting.
    fn take(&self, waiting: &Waiting, meetings: u64) -> Partner {
        // A read for writing: the cell comes over once, not once to be read and once more to be written.
        let ticket = self.state.compare_exchange(NEVER, NEVER, SeqCst, SeqCst).unwrap_or_else(|state| state);
        if ticket == EMPTY || ticket & TAKEN != 0 {
            return Partner::Absent;
        }
        let its = (self.t.load(Relaxed), self.micro.load(Relaxed));
        let last = (waiting.tag.t, waiting.tag.micro).max(its);
        let same = self.code.load(Relaxed) == waiting.spec.code()
            && self.named.load(Relaxed) == named(waiting)
            && self.meetings.load(Relaxed) == meetings;
        match taking(its.0, last).filter(|_| same) {
            Some(word) if self.state.compare_exchange(ticket, word, SeqCst, Relaxed).is_ok() => {
                Partner::Met(last.0, last.1)
            }
            _ => Partner::Elsewhere,
        }
    }

    /// Takes the ticket back; gives the word if the other one has taken it.
    fn withdraw(&self, ticket: u64) -> Option<u64> {
        self.state.compare_exchange(ticket, EMPTY, SeqCst, SeqCst).err()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_says_when_the_last_one_came() {
        let own = |t, micro| Tag { t, micro, rank: 1 };
        for (its, last) in
            [((5, 3), (5, 3)), ((5, 3), (5, 9)), ((5, 3), (7_000_000_000, 0)), ((0, 0), (1 << 46, 65_535))]
        {
            let word = taking(its.0, last).unwrap();
            assert_eq!(taken_at(word, own(its.0, its.1)), last, "{its:?} {last:?}");
            assert!(word & TAKEN != 0 && word != NEVER);
        }
        assert_eq!(taking(0, (1 << 47, 0)), None, "too late");
        assert_eq!(taking(0, (0, 1 << 16)), None, "too many microsteps");
        assert_eq!(taking(i64::MIN, (i64::MAX, 0)), None);
    }
}
