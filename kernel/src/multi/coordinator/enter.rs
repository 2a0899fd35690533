//! How a kernel comes to a shared operation.
//!
//! Invariant: an operation is entered with the smallest tag of all that are still possible, and never at a tag after the
//! stop of the job.

use std::sync::atomic::Ordering::SeqCst;

use super::switch::Switch;
use super::{Coordinator, Guard, Status, Stopped};
use crate::multi::tag::Tag;

impl Coordinator {
    /// Enters a shared operation if it may run at once; else `None` (flush, then [`enter`](Self::enter)).
    pub(crate) fn try_enter(&self, tag: Tag) -> Option<Guard<'_>> {
        let inner = self.lock();
        (inner.stop.is_none() && self.eligible(&inner, tag)).then_some(inner)
    }

    /// Parks at `tag` and spins for a moment: most partners are only a few blocks behind. `None`: still parked; send
    /// the events so far, then [`enter`](Self::enter).
    pub(crate) fn try_park(&self, tag: Tag) -> Option<Guard<'_>> {
        if self.spin == 0 {
            return None;
        }
        let mut inner = self.lock();
        inner.set(tag.rank, Status::Parked(tag));
        self.ask(&inner, tag);
        self.wake_parked(&mut inner);
        let seen = self.slot(tag.rank)?.signal.load(SeqCst);
        if !self.eligible(&inner, tag) {
            drop(inner);
            self.spin_for_signal(tag.rank, seen, |_| false);
            inner = self.lock();
            if !self.eligible(&inner, tag) {
                return None;
            }
        }
        if inner.stop.is_some() {
            return None;
        }
        inner.set(tag.rank, Status::Running);
        if let Some(slot) = self.slot(tag.rank) {
            slot.bound.fetch_max(tag.t, SeqCst);
        }
        Some(inner)
    }

    /// Enters a shared operation: waits until it has the smallest tag.
    ///
    /// # Errors
    /// [`Stopped`] when the job was stopped before this tag.
    pub(super) fn enter(&self, tag: Tag, switch: Switch<'_>) -> Result<Guard<'_>, Stopped> {
        let rank = tag.rank;
        let mut inner = self.lock();
        inner.set(rank, Status::Parked(tag));
        let mut gave_permit = false;
        loop {
            if inner.stop.is_some_and(|stop| stop < tag) {
                inner.set(rank, Status::Running);
                break;
            }
            // Arrivals that are next in order come first: carrying them out may be what this kernel waited for, and the
            // signal it gives itself by that would be lost.
            self.wake_parked(&mut inner);
            self.ask(&inner, tag);
            if self.eligible(&inner, tag) {
                inner.set(rank, Status::Running);
                break;
            }
            if self.limited && !gave_permit {
                gave_permit = true;
                self.release_permit(&mut inner);
            }
            inner = self.sleep(rank, inner, switch);
        }
        if let Some(slot) = self.slot(rank) {
            slot.bound.fetch_max(tag.t, SeqCst);
        }
        if gave_permit {
            // The operation itself is done at once; only what follows needs the permit. Taking it first would be
            // wrong: another kernel could be the only one with a permit and wait for this operation.
            inner = self.reacquire(rank, inner, tag);
        }
        if inner.stop.is_some_and(|stop| stop < tag) { Err(Stopped) } else { Ok(inner) }
    }

    /// Gets the permit back while keeping the place in tag order.
    fn reacquire<'a>(&'a self, rank: u16, mut inner: Guard<'a>, tag: Tag) -> Guard<'a> {
        inner.set(rank, Status::Parked(tag));
        inner = self.acquire_permit(rank, inner);
        inner.set(rank, Status::Running);
        inner
    }
}
