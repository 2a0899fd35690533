//! Meetings of two kernels that are alone in a job, without the lock.
//!
//! The first one writes its arrival into its cell and stands in `first`; the second one finds it there, and if both
//! wait for the same meeting it takes it out and tells the first when to go on. Whatever is not as simple as that
//! (another code, a shared operation of the partner, a stop, patience at its end) makes the first one take itself out
//! and arrive under the lock. Invariants: who takes the first one out of `first` alone decides what becomes of it; a
//! kernel that stands here counts as running at its arrival.

use std::sync::atomic::{
    AtomicBool, AtomicI64, AtomicU16, AtomicU32, AtomicU64,
    Ordering::{Acquire, Relaxed, Release},
};

use super::sleep::YIELDS;
use super::{Coordinator, Wake};
use crate::multi::tag::Tag;
use crate::multi::waits::{Set, Waiting, after};

/// The place where two kernels meet.
#[derive(Debug, Default)]
pub(super) struct Pair {
    /// The only two kernels; empty: there are more, or fewer.
    parts: AtomicU64,
    /// The lock is needed at the next meeting: it orders commands to a shared spindle.
    orders: AtomicBool,
    /// Channel that stands here, 0 = none.
    first: AtomicU16,
    cells: [Cell; 2],
}

/// The arrival of one kernel, and its way on.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Cell {
    t: AtomicI64,
    micro: AtomicU32,
    code: AtomicU64,
    named: AtomicU64,
    /// Number of the meeting that took place, 0 = not yet.
    meeting: AtomicU64,
    on_t: AtomicI64,
    on_micro: AtomicU32,
}

impl Coordinator {
    /// Only these two kernels are going to run.
    pub(crate) fn set_pair(&self, a: u16, b: u16) {
        if self.spin > 0 {
            self.pair.parts.store(Set::default().with(a).with(b).0, Relaxed);
        }
    }

    /// The next meeting has to order commands to spindles.
    pub(crate) fn set_orders(&self, orders: bool) {
        self.pair.orders.store(orders, Relaxed);
    }

    /// Meets the only other kernel if that is simple; `None`: arrive under the lock.
    pub(super) fn meet_pair(&self, waiting: &Waiting, work: &mut impl FnMut() -> bool) -> Option<Wake> {
        let pair = &self.pair;
        let (tag, parts) = (waiting.tag, waiting.spec.parts);
        if parts.0 != pair.parts.load(Relaxed) || pair.orders.load(Relaxed) {
            return None;
        }
        let other = parts.iter().find(|&c| c != tag.rank)?;
        let lower = usize::from(tag.rank > other);
        let (own, its) = (pair.cells.get(lower)?, pair.cells.get(1 - lower)?);
        if pair.first.load(Acquire) == 0 {
            own.write(waiting);
            if pair.first.compare_exchange(0, tag.rank, Release, Acquire).is_ok() {
                return self.stand_first(own, tag, work);
            }
        }
        if !its.matches(waiting) || pair.first.compare_exchange(other, 0, Acquire, Relaxed).is_err() {
            return None;
        }
        let (t, micro) = (tag.t, tag.micro).max((its.t.load(Relaxed), its.micro.load(Relaxed)));
        let on = after(t, micro, self.release_ns);
        let meeting = self.meetings.fetch_add(1, Relaxed) + 1;
        its.on_t.store(on.0, Relaxed);
        its.on_micro.store(on.1, Relaxed);
        its.meeting.store(meeting, Release);
        Some(released(tag.rank, on, meeting))
    }

    fn stand_first(&self, own: &Cell, tag: Tag, work: &mut impl FnMut() -> bool) -> Option<Wake> {
        let slot = self.slot(tag.rank)?;
        let seen = slot.signal.load(Acquire);
        let disturbed = || slot.need.load(Relaxed) != i64::MAX || slot.signal.load(Relaxed) != seen;
        for turn in 0..self.spin + YIELDS {
            while own.meeting.load(Relaxed) == 0 && work() {}
            if own.meeting.load(Relaxed) != 0 || disturbed() {
                break;
            }
            if turn < self.spin {
                std::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
        if own.meeting.load(Relaxed) == 0 && self.pair.first.compare_exchange(tag.rank, 0, Relaxed, Relaxed).is_ok() {
            return None;
        }
        // The other one has taken this one out and is about to say when it goes on.
        loop {
            let meeting = own.meeting.load(Acquire);
            if meeting != 0 {
                return Some(released(tag.rank, (own.on_t.load(Relaxed), own.on_micro.load(Relaxed)), meeting));
            }
            std::thread::yield_now();
        }
    }
}

fn released(rank: u16, (t, micro): (i64, u32), meeting: u64) -> Wake {
    Wake::Released { tag: Tag { t, micro, rank }, meeting }
}

impl Cell {
    fn write(&self, waiting: &Waiting) {
        self.t.store(waiting.tag.t, Relaxed);
        self.micro.store(waiting.tag.micro, Relaxed);
        self.code.store(waiting.spec.code(), Relaxed);
        self.named.store(waiting.spec.named.0, Relaxed);
        self.meeting.store(0, Relaxed);
    }

    fn matches(&self, waiting: &Waiting) -> bool {
        self.code.load(Relaxed) == waiting.spec.code() && self.named.load(Relaxed) == waiting.spec.named.0
    }
}
