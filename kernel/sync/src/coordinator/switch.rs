//! How a kernel waits for others: on a thread of its own, which sleeps, or as one of several kernels on a thread, which
//! runs another kernel meanwhile.
//!
//! Invariant: a kernel that waits holds no lock.

use std::ops::Deref;

use super::turn::{MeetOutcome, TurnGuard, Waiter};
use super::wait_method::{WaitMethod, YieldReason};
use super::{Coordinator, Stopped};
use crate::backlog::Chunk;
use crate::merge::Feeder;
use crate::order::Wake;
use crate::tag::Tag;
use crate::wait::WaitingChannel;

/// Whether there is nothing to do meanwhile.
fn no_work<S>(_: &mut S, _: bool) -> bool {
    false
}

/// The coordinator as one kernel reaches it.
#[derive(Clone, Copy)]
pub struct Port<'a> {
    core: &'a Coordinator,
    switch: WaitMethod<'a>,
}

impl Deref for Port<'_> {
    type Target = Coordinator;

    #[inline]
    fn deref(&self) -> &Coordinator {
        self.core
    }
}

impl<'a> Port<'a> {
    /// The coordinator for a kernel that waits in this way.
    pub fn new(core: &'a Coordinator, switch: WaitMethod<'a>) -> Self {
        Self { core, switch }
    }

    /// Waits until an operation at this tag is next. `flush` sends the events so far, if that takes long.
    ///
    /// # Errors
    /// [`Stopped`] when the job was stopped before this tag.
    pub fn enter<S>(self, tag: Tag, state: &mut S, flush: impl FnOnce(&mut S)) -> Result<TurnGuard<'a>, Stopped> {
        self.enter_keeping((tag, tag), state, flush)
    }

    /// The same for a kernel that keeps its events from `upto` on back.
    ///
    /// # Errors
    /// [`Stopped`] when the job was stopped before this tag.
    pub fn enter_keeping<S>(
        self,
        (tag, upto): (Tag, Tag),
        state: &mut S,
        flush: impl FnOnce(&mut S),
    ) -> Result<TurnGuard<'a>, Stopped> {
        let waiter = self.waiter(tag.channel, state, flush, no_work::<S>);
        self.core.enter(tag, Waiter { keeps: upto < tag, ..waiter })
    }

    /// Waits until another kernel resumes this one, which is blocked.
    pub fn wait<S>(self, channel: u16, state: &mut S, flush: impl FnOnce(&mut S)) -> Wake {
        self.core.wait(self.waiter(channel, state, flush, no_work::<S>))
    }

    /// Arrives at a wait. `flush` sends the events so far, if no partner arrives soon; `work` is done for a moment
    /// while this thread waits.
    pub fn meet<S>(
        self,
        waiting: WaitingChannel,
        state: &mut S,
        flush: impl FnOnce(&mut S),
        work: impl Fn(&mut S, bool) -> bool,
    ) -> MeetOutcome<'a> {
        let channel = waiting.tag.channel;
        self.core.meet(waiting, self.waiter(channel, state, flush, work))
    }

    fn waiter<S, F, W>(self, channel: u16, state: S, flush: F, work: W) -> Waiter<'a, S, F, W> {
        Waiter { channel, switch: self.switch, keeps: false, state, flush, work }
    }

    /// Lets all other kernels advance to `tag`, if this kernel is free to wait.
    pub fn catch_up(self, tag: Tag) {
        if self.core.is_free(tag.channel) {
            let _ = self.enter(tag, &mut (), |()| ());
        }
    }

    /// Lets the operator choose the next kernel. `false`: there is no other kernel on this thread.
    pub fn pause_for_step(self) -> bool {
        match self.switch {
            WaitMethod::Thread => false,
            WaitMethod::Coroutine(yielder) => {
                yielder.suspend(YieldReason::Step);
                true
            }
        }
    }

    /// Lets the merger on this thread pass on the events that the kernel has sent.
    pub fn pass_on(self) {
        if let WaitMethod::Coroutine(yielder) = self.switch {
            yielder.suspend(YieldReason::Question);
        }
    }

    /// Waits for the merger to give a chunk back. In turns on one thread a kernel continues with an additional chunk if
    /// no other kernel can continue either: then no chunk would ever come back.
    pub fn wait_chunk(self, tag: Tag, feeder: &mut Feeder) -> Chunk {
        self.core.away(tag, || match self.switch {
            WaitMethod::Thread => feeder.wait_back(),
            WaitMethod::Coroutine(yielder) => {
                if let Some(chunk) = feeder.try_back() {
                    return chunk;
                }
                yielder.suspend(YieldReason::Chunk);
                feeder.try_back().unwrap_or_else(|| feeder.advance())
            }
        })
    }
}
