//! Arrivals at meeting points that need nobody's attention.
//!
//! An arrival that raises no alarm and no verdict changes shared state only, so whoever finds it next in tag order
//! carries it out: a kernel that arrives early parks once and hears again when its meeting takes place. Invariant: an
//! arrival is carried out once, in tag order, by whomever.

use std::sync::atomic::Ordering::SeqCst;

use super::switch::Switch;
use super::{Coordinator, Inner, Status, Wake};
use crate::multi::tag::Tag;
use crate::multi::waits::{Arrival, Set, Waiting};

/// What came of an arrival.
#[derive(Debug, PartialEq)]
pub(crate) enum Met {
    /// The kernel goes on.
    Woken(Wake),
    /// It has arrived and stands: send the events so far, then [`Coordinator::wait`].
    Stands,
    /// It has not arrived: that is the kernel's own affair.
    Not,
}

impl Coordinator {
    /// Arrives, and waits for a moment until the meeting takes place, with `work` to do meanwhile as long as there is
    /// some.
    pub(crate) fn meet(&self, waiting: &Waiting, mut work: impl FnMut(bool) -> bool) -> Met {
        if let Some(wake) = self.meet_pair(waiting, &mut work) {
            return Met::Woken(wake);
        }
        let tag = waiting.tag;
        let Some(slot) = self.slot(tag.rank) else { return Met::Not };
        let seen = {
            let mut inner = self.lock();
            if inner.stop.is_some() {
                return Met::Not;
            }
            inner.set(tag.rank, Status::Parked(tag));
            inner.put_arriving(Some(waiting.clone()), tag.rank);
            slot.bound.fetch_max(tag.t, SeqCst);
            let seen = slot.signal.load(SeqCst);
            self.wake_parked(&mut inner);
            if let Some(wake) = inner.take_wake(tag.rank) {
                return Met::Woken(wake);
            }
            seen
        };
        self.spin_for_signal(tag.rank, seen, work);
        let mut inner = self.lock();
        if let Some(wake) = inner.take_wake(tag.rank) {
            return Met::Woken(wake);
        }
        if inner.put_arriving(None, tag.rank).is_none() {
            return Met::Stands;
        }
        inner.set(tag.rank, Status::Running);
        Met::Not
    }

    /// Arrives, and lets the thread run other kernels until the meeting takes place. `stand` is called first: it sends the
    /// events so far.
    pub(super) fn meet_on_one_thread(&self, waiting: &Waiting, switch: Switch<'_>, stand: impl FnOnce()) -> Met {
        let tag = waiting.tag;
        let rank = tag.rank;
        {
            let mut inner = self.lock();
            if inner.stop.is_some() {
                return Met::Not;
            }
            inner.set(rank, Status::Parked(tag));
            inner.put_arriving(Some(waiting.clone()), rank);
            if let Some(slot) = self.slot(rank) {
                slot.bound.fetch_max(tag.t, SeqCst);
            }
            self.wake_parked(&mut inner);
            if let Some(wake) = inner.take_wake(rank) {
                return Met::Woken(wake);
            }
        }
        stand();
        let mut inner = self.lock();
        loop {
            if let Some(wake) = inner.take_wake(rank) {
                return Met::Woken(wake);
            }
            // With a log the merger has to hear that this stream stands.
            let arrived = inner.arriving(rank).is_none();
            if arrived && inner.messages.is_some() {
                return Met::Stands;
            }
            if !arrived && (inner.stop.is_some() || self.eligible(&inner, tag)) {
                inner.put_arriving(None, rank);
                inner.set(rank, Status::Running);
                return Met::Not;
            }
            inner = self.sleep(rank, inner, switch);
        }
    }

    /// Meetings so far.
    pub(crate) fn meetings(&self) -> u64 {
        self.meetings.load(SeqCst).max(self.pair_meetings())
    }

    /// Counts on from earlier meetings; nothing runs yet.
    pub(crate) fn go_on_from(&self, meetings: u64) {
        self.meetings.store(meetings, SeqCst);
    }

    /// A meeting takes place: its number.
    pub(crate) fn count_meeting(&self, inner: &mut Inner, channels: Set) -> u64 {
        inner.shared.met(channels);
        self.set_orders(inner.shared.has_orders(channels));
        let meeting = self.meetings() + 1;
        self.meetings.store(meeting, SeqCst);
        meeting
    }

    /// Carries out the arrival of a parked kernel that is next in tag order; `false` if its own attention is needed.
    pub(super) fn arrive_for(&self, inner: &mut Inner, tag: Tag) -> bool {
        let Some(waiting) = inner.put_arriving(None, tag.rank) else { return false };
        if !inner.waits.is_plain(&waiting) {
            inner.put_arriving(Some(waiting), tag.rank);
            return false;
        }
        self.stand_still(inner, tag.rank, Status::Blocked);
        let arrival = inner.waits.arrive(waiting);
        if self.one_thread && arrival == Arrival::Blocked && inner.messages.is_some() {
            self.signal(tag.rank);
        }
        if let Arrival::Released { channels, t, micro } = arrival {
            let meeting = self.count_meeting(inner, channels);
            for channel in channels.iter() {
                self.resume(inner, channel, Wake::Released { tag: Tag { t, micro, rank: channel }, meeting });
            }
        }
        true
    }
}

impl Inner {
    fn arriving(&self, rank: u16) -> Option<&Waiting> {
        self.arriving.get(self.ranks.index(rank)).and_then(Option::as_ref)
    }

    fn put_arriving(&mut self, waiting: Option<Waiting>, rank: u16) -> Option<Waiting> {
        self.arriving.get_mut(self.ranks.index(rank)).and_then(|slot| std::mem::replace(slot, waiting))
    }
}
