//! How a kernel gets its turn, and how it waits for its partners.
//!
//! Invariant: a kernel that sleeps has sent all its events before, or the merger knows that it keeps some back; before
//! that it waits for a moment, since most partners are only a few blocks away.

use std::ops::{Deref, DerefMut};

use super::locks::atomic::Ordering::SeqCst;
use super::wait_method::WaitMethod;
use super::{Coordinator, Guard, Stopped};
use crate::merge::MergerMessage;
use crate::order::{KernelStatus, Order, Wake};
use crate::tag::Tag;
use crate::wait::WaitingChannel;

/// The order while a kernel has its turn, which ends when this is dropped.
pub struct TurnGuard<'a> {
    coordinator: &'a Coordinator,
    channel: u16,
    inner: Guard<'a>,
}

impl Deref for TurnGuard<'_> {
    type Target = Order;

    fn deref(&self) -> &Order {
        &self.inner.order
    }
}

impl DerefMut for TurnGuard<'_> {
    fn deref_mut(&mut self) -> &mut Order {
        &mut self.inner.order
    }
}

impl Drop for TurnGuard<'_> {
    fn drop(&mut self) {
        self.inner.order.leave(self.channel);
        // No kernel waits for the turn of the only kernel.
        if !self.coordinator.is_single() || self.inner.order.has_effects() {
            self.coordinator.settle(&mut self.inner);
        }
    }
}

/// The outcome of an arrival.
pub enum MeetOutcome<'a> {
    /// The wait is over.
    Woken(Wake),
    /// The arrival concerns more than shared state (an alarm, a verdict): the kernel carries it out itself.
    Turn(TurnGuard<'a>),
}

/// A kernel that waits.
pub(super) struct Waiter<'s, S, F, W> {
    pub(super) channel: u16,
    pub(super) switch: WaitMethod<'s>,
    /// Keeps events back that are before its request.
    pub(super) keeps: bool,
    /// The operand of the next two.
    pub(super) state: S,
    /// Sends the events so far.
    pub(super) flush: F,
    /// Does a little work, `true`: with a look at how far the others are; `false` when there is none.
    pub(super) work: W,
}

impl Coordinator {
    /// Waits until this operation is next.
    ///
    /// # Errors
    /// [`Stopped`] when the job was stopped before this tag.
    pub(super) fn enter<S>(
        &self,
        tag: Tag,
        waiter: Waiter<'_, &mut S, impl FnOnce(&mut S), impl Fn(&mut S, bool) -> bool>,
    ) -> Result<TurnGuard<'_>, Stopped> {
        let mut inner = self.lock();
        if self.is_single() {
            let comes = inner.order.take_turn(tag);
            return if comes { Ok(TurnGuard { coordinator: self, channel: tag.channel, inner }) } else { Err(Stopped) };
        }
        inner.order.request(tag, None);
        self.settle(&mut inner);
        match self.wake(inner, waiter) {
            (inner, Wake::Turn) => Ok(TurnGuard { coordinator: self, channel: tag.channel, inner }),
            _ => Err(Stopped),
        }
    }

    /// Arrives at a wait, and waits until the wait is over or the kernel has to execute its arrival itself.
    pub(super) fn meet<S>(
        &self,
        waiting: WaitingChannel,
        waiter: Waiter<'_, &mut S, impl FnOnce(&mut S), impl Fn(&mut S, bool) -> bool>,
    ) -> MeetOutcome<'_> {
        let mut inner = self.lock();
        let tag = waiting.tag;
        inner.order.request(tag, Some(waiting));
        self.settle(&mut inner);
        match self.wake(inner, waiter) {
            (inner, Wake::Turn) => MeetOutcome::Turn(TurnGuard { coordinator: self, channel: tag.channel, inner }),
            (_, wake) => MeetOutcome::Woken(wake),
        }
    }

    /// Waits until another kernel resumes this one, which is blocked.
    pub(super) fn wait<S>(
        &self,
        waiter: Waiter<'_, &mut S, impl FnOnce(&mut S), impl Fn(&mut S, bool) -> bool>,
    ) -> Wake {
        self.wake(self.lock(), waiter).1
    }

    /// Waits for the answer to a request: looks at once, then for a moment, then sleeps.
    fn wake<'a, S>(
        &'a self,
        mut inner: Guard<'a>,
        waiter: Waiter<'_, &mut S, impl FnOnce(&mut S), impl Fn(&mut S, bool) -> bool>,
    ) -> (Guard<'a>, Wake) {
        let Waiter { channel, switch, keeps, state, flush, work } = waiter;
        if let Some(wake) = inner.order.take_wake(channel) {
            return (inner, wake);
        }
        if self.spin > 0
            && let Some(slot) = self.slot(channel)
        {
            let seen = slot.signal.load(SeqCst);
            drop(inner);
            if !self.holds_up_others(slot) {
                self.spin_for_signal(slot, seen, |look| work(state, look));
                slot.note_processor();
            }
            inner = self.lock();
            if let Some(wake) = inner.order.take_wake(channel) {
                return (inner, wake);
            }
        }
        drop(inner);
        flush(state);
        inner = self.lock();
        let index = self.channels.index(channel);
        let (mut gave_permit, mut told) = (false, false);
        loop {
            if let Some(wake) = inner.order.take_wake(channel) {
                if told {
                    inner.send(MergerMessage::Awake(channel));
                }
                if let Some(flushed) = inner.flushed.get_mut(index) {
                    *flushed = false;
                }
                // A turn that waits for a permit holds back other turns only, and those who sleep have no permit.
                if gave_permit {
                    inner = self.acquire_permit(channel, inner);
                }
                return (inner, wake);
            }
            if let Some(flushed) = inner.flushed.get_mut(index)
                && !std::mem::replace(flushed, true)
                && inner.order.status(channel) == KernelStatus::Blocked
            {
                self.stream_blocked(&mut inner, channel);
            }
            if keeps && !std::mem::replace(&mut told, true) {
                inner.send(MergerMessage::Asleep(channel));
            }
            if self.limited && !gave_permit {
                gave_permit = true;
                self.release_permit(&mut inner);
            }
            inner = self.sleep(channel, inner, switch);
        }
    }

    /// Runs an operation that waits for something outside the job's order: for chunks that the merger returns.
    /// Meanwhile a running kernel acts at `tag` at the earliest, and earlier kernels may continue, so that the merger
    /// can advance. A kernel that is parked or blocked already keeps its place.
    pub(super) fn away<R>(&self, tag: Tag, wait: impl FnOnce() -> R) -> R {
        let mut inner = self.lock();
        let running = inner.order.is_free(tag.channel);
        if running {
            inner.order.away(tag);
        }
        if self.limited {
            self.release_permit(&mut inner);
        }
        self.settle(&mut inner);
        drop(inner);
        let result = wait();
        let mut inner = self.acquire_permit(tag.channel, self.lock());
        if running {
            inner.order.back(tag.channel);
            self.settle(&mut inner);
        }
        result
    }

    /// Whether the kernel executes blocks and no answer waits for it.
    pub(super) fn is_free(&self, channel: u16) -> bool {
        self.lock().order.is_free(channel)
    }
}
