//! Meetings of two kernels that are alone in a job, without the lock.
//!
//! Who arrives writes its arrival into its cell and shows it with a ticket. Who finds the other one's ticket there, and
//! waits for the same meeting, takes it and writes when the other one goes on; both may do so at once, and write the
//! same. Whatever is not as simple as that (another code, a shared operation of the partner, a stop, patience at its
//! end) makes a kernel withdraw its ticket and arrive under the lock. Invariants: a ticket is used once; a cell is
//! written by its owner while it shows none, and by the other one while it is being taken; a kernel that stands here
//! counts as running at its arrival.

use std::sync::atomic::{
    AtomicBool, AtomicI64, AtomicU32, AtomicU64,
    Ordering::{Acquire, Relaxed, Release, SeqCst},
};

use super::sleep::YIELDS;
use super::{Coordinator, Wake};
use crate::multi::tag::Tag;
use crate::multi::waits::{Set, Waiting, after};

/// Nobody stands here.
const EMPTY: u64 = 0;
/// The other kernel is writing when to go on.
const TAKEN: u64 = u64::MAX;

/// The place where two kernels meet.
#[derive(Debug, Default)]
pub(super) struct Pair {
    /// The only two kernels; empty: there are more, or fewer.
    parts: AtomicU64,
    /// The lock is needed at the next meeting: it orders commands to a shared spindle.
    orders: AtomicBool,
    cells: [Cell; 2],
}

/// The arrival of one kernel, and its way on.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Cell {
    /// [`EMPTY`], [`TAKEN`] or the ticket of the kernel that stands here.
    state: AtomicU64,
    /// Tickets used; the owner's.
    tickets: AtomicU64,
    t: AtomicI64,
    micro: AtomicU32,
    code: AtomicU64,
    named: AtomicU64,
    /// Meetings so far, as the owner knew at its arrival.
    meetings: AtomicU64,
    on: On,
}

/// How it goes on: time, microstep, number of the meeting.
#[derive(Debug, Default)]
struct On {
    t: AtomicI64,
    micro: AtomicU32,
    meeting: AtomicU64,
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
        let (rank, parts) = (waiting.tag.rank, waiting.spec.parts);
        if parts.0 != pair.parts.load(Relaxed) || pair.orders.load(Relaxed) {
            return None;
        }
        let other = parts.iter().find(|&c| c != rank)?;
        let lower = usize::from(rank > other);
        let (own, its) = (pair.cells.get(lower)?, pair.cells.get(1 - lower)?);
        let meetings = self.meetings.load(Acquire);
        match self.take_partner(its, waiting, meetings) {
            Partner::Met(wake) => return Some(wake),
            Partner::Elsewhere => return None,
            Partner::Absent => {}
        }
        let ticket = own.show(waiting, meetings);
        // Both may have come at once: at least the later one sees the other.
        match self.take_partner(its, waiting, meetings) {
            Partner::Met(wake) => {
                let _ = own.withdraw(ticket);
                return Some(wake);
            }
            Partner::Elsewhere => {}
            Partner::Absent => self.stand(own, ticket, rank, work),
        }
        if own.withdraw(ticket) {
            return None;
        }
        Some(released(rank, (own.on.t.load(Relaxed), own.on.micro.load(Relaxed)), own.on.meeting.load(Relaxed)))
    }

    /// Takes the other kernel's ticket if it waits for the same meeting.
    fn take_partner(&self, its: &Cell, waiting: &Waiting, meetings: u64) -> Partner {
        let ticket = its.state.load(SeqCst);
        if ticket == EMPTY || ticket == TAKEN {
            return Partner::Absent;
        }
        let same = its.code.load(Relaxed) == waiting.spec.code() && its.named.load(Relaxed) == waiting.spec.named.0;
        let (t, micro) = (waiting.tag.t, waiting.tag.micro).max((its.t.load(Relaxed), its.micro.load(Relaxed)));
        let meeting = meetings.max(its.meetings.load(Relaxed)) + 1;
        if !same || its.state.compare_exchange(ticket, TAKEN, SeqCst, Relaxed).is_err() {
            return Partner::Elsewhere;
        }
        let on = after(t, micro, self.release_ns);
        self.meetings.fetch_max(meeting, SeqCst);
        its.on.t.store(on.0, Relaxed);
        its.on.micro.store(on.1, Relaxed);
        its.on.meeting.store(meeting, Relaxed);
        its.state.store(EMPTY, Release);
        Partner::Met(released(waiting.tag.rank, on, meeting))
    }

    /// Works and waits until the ticket is taken, something else is to be done, or the patience is over.
    fn stand(&self, own: &Cell, ticket: u64, rank: u16, work: &mut impl FnMut() -> bool) {
        let Some(slot) = self.slot(rank) else { return };
        let seen = slot.signal.load(Acquire);
        let standing = || own.state.load(Relaxed) == ticket;
        let disturbed = || slot.need.load(Relaxed) != i64::MAX || slot.signal.load(Relaxed) != seen;
        for turn in 0..self.spin + YIELDS {
            while standing() && work() {}
            if !standing() || disturbed() {
                return;
            }
            if turn < self.spin {
                std::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }
}

/// Where the other kernel is.
enum Partner {
    /// At the same meeting: both go on.
    Met(Wake),
    /// Not at a meeting.
    Absent,
    /// At another one, or it has just withdrawn.
    Elsewhere,
}

fn released(rank: u16, (t, micro): (i64, u32), meeting: u64) -> Wake {
    Wake::Released { tag: Tag { t, micro, rank }, meeting }
}

impl Cell {
    /// Shows an arrival; gives its ticket.
    fn show(&self, waiting: &Waiting, meetings: u64) -> u64 {
        let ticket = self.tickets.load(Relaxed) + 1;
        self.tickets.store(ticket, Relaxed);
        self.t.store(waiting.tag.t, Relaxed);
        self.micro.store(waiting.tag.micro, Relaxed);
        self.code.store(waiting.spec.code(), Relaxed);
        self.named.store(waiting.spec.named.0, Relaxed);
        self.meetings.store(meetings, Relaxed);
        self.state.store(ticket, SeqCst);
        ticket
    }

    /// Takes the ticket back; `false` if the other one has taken it, and has then written when to go on.
    fn withdraw(&self, ticket: u64) -> bool {
        if self.state.compare_exchange(ticket, EMPTY, SeqCst, Relaxed).is_ok() {
            return true;
        }
        while self.state.load(Acquire) != EMPTY {
            std::thread::yield_now();
        }
        false
    }
}
