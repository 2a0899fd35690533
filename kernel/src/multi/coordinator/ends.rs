//! Standing, going on and coming to an end.
//!
//! Invariant: a kernel that stands is woken once: by a release, by an alarm of its wait, or because nobody is left who
//! could release it.

use std::sync::atomic::Ordering::SeqCst;

use super::switch::Switch;
use super::{Coordinator, DONE, Inner, STANDS, Status, Wake};
use crate::multi::merge::Message;
use crate::multi::tag::Tag;

impl Coordinator {
    /// The kernel stands still from now on; another one's operation will wake it.
    pub(crate) fn block(&self, inner: &mut Inner, rank: u16) {
        self.stand_still(inner, rank, Status::Blocked);
        self.settle(inner);
    }

    pub(super) fn stand_still(&self, inner: &mut Inner, rank: u16, status: Status) {
        inner.set(rank, status);
        if let Some(slot) = self.slot(rank) {
            slot.bound.store(if status == Status::Done { DONE } else { STANDS }, SeqCst);
        }
    }

    /// Resumes a blocked kernel.
    pub(crate) fn resume(&self, inner: &mut Inner, rank: u16, wake: Wake) {
        let tag = match &wake {
            Wake::Released { tag, .. } | Wake::Alarm { tag, .. } => Some(*tag),
            Wake::Over | Wake::Stopped => None,
        };
        if let (Some(slot), Some(tag)) = (self.slot(rank), tag) {
            self.resumes.fetch_add(1, SeqCst);
            slot.bound.store(tag.t, SeqCst);
            self.resumes.fetch_add(1, SeqCst);
            slot.need.store(i64::MAX, SeqCst);
        }
        if let Some(tag) = tag
            && inner.told.get(self.ranks.index(rank)).copied().unwrap_or(false)
        {
            inner.tell(Message::Resumed(rank, tag));
        }
        if let Some(told) = inner.told.get_mut(self.ranks.index(rank)) {
            *told = false;
        }
        if let Some(slot) = inner.wakes.get_mut(self.ranks.index(rank)) {
            *slot = Some(wake);
        }
        inner.set(rank, Status::Running);
        self.signal(rank);
    }

    /// Waits until another kernel resumes this one. The kernel's events up to its arrival must have been sent.
    pub(super) fn wait(&self, rank: u16, switch: Switch<'_>) -> Wake {
        let mut inner = self.lock();
        if inner.status(rank) == Status::Blocked {
            inner.tell(Message::Blocked(rank));
            if let Some(told) = inner.told.get_mut(self.ranks.index(rank)) {
                *told = true;
            }
        }
        let mut gave_permit = false;
        loop {
            if let Some(wake) = inner.take_wake(rank) {
                if gave_permit {
                    inner = self.acquire_permit(rank, inner);
                }
                self.wake_parked(&mut inner);
                return wake;
            }
            if self.limited && !gave_permit {
                gave_permit = true;
                self.release_permit(&mut inner);
            }
            inner = self.sleep(rank, inner, switch);
        }
    }

    /// The kernel is finished.
    pub(crate) fn done(&self, inner: &mut Inner, rank: u16) {
        self.stand_still(inner, rank, Status::Done);
        if self.limited {
            self.release_permit(inner);
        }
        self.settle(inner);
    }

    /// A channel that never runs.
    pub(crate) fn absent(&self, rank: u16) {
        self.stand_still(&mut self.lock(), rank, Status::Done);
    }

    /// The stream of the kernel is complete.
    pub(crate) fn closed(&self, rank: u16) {
        self.lock().tell(Message::Done(rank));
    }

    /// Stops the job at `tag`: nothing after it happens.
    pub(crate) fn stop(&self, inner: &mut Inner, tag: Tag) {
        if inner.stop.is_some_and(|stop| stop <= tag) {
            return;
        }
        inner.stop = Some(tag);
        self.stop_t.fetch_min(tag.t, SeqCst);
        inner.tell(Message::StopAt(tag));
        self.wake_all(inner);
    }

    /// Stops the job wherever it stands (cancel, full log): the log is cut by whoever asked.
    pub(crate) fn abort(&self) {
        let mut inner = self.lock();
        inner.stop = Some(Tag { t: i64::MIN, micro: 0, rank: 0 });
        self.stop_t.store(i64::MIN, SeqCst);
        self.wake_all(&mut inner);
    }

    fn wake_all(&self, inner: &mut Inner) {
        for &rank in self.ranks.numbers() {
            match inner.status(rank) {
                Status::Blocked => self.resume(inner, rank, Wake::Stopped),
                Status::Parked(_) | Status::Running => self.signal(rank),
                Status::Done => {}
            }
        }
    }

    /// After a kernel stopped running: lets the next parked one go, or ends all waits when nothing can happen any
    /// more.
    fn settle(&self, inner: &mut Inner) {
        if inner.quiet() {
            for &rank in self.ranks.numbers() {
                if inner.status(rank) == Status::Blocked {
                    self.resume(inner, rank, Wake::Over);
                }
            }
        } else {
            self.wake_parked(inner);
        }
    }
}
