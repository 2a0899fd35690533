//! How a kernel waits for others: on a thread of its own, which sleeps, or as one of several on a thread, which runs
//! another one meanwhile.
//!
//! Invariant: a kernel that waits holds no lock.

use std::ops::Deref;

use corosensei::Yielder;

use super::meet::Met;
use super::{Coordinator, Guard, Stopped, Wake};
use crate::multi::tag::Tag;
use crate::multi::waits::Waiting;

/// Why a kernel lets its thread run another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pause {
    /// It has nothing to do until it is signalled.
    Sleep,
    /// It needs an empty chunk, which the merger gives back.
    Chunk,
}

/// How a kernel waits.
#[derive(Clone, Copy)]
pub(crate) enum Switch<'a> {
    /// Its thread sleeps.
    Thread,
    /// Its thread runs another kernel.
    Coroutine(&'a Yielder<(), Pause>),
}

/// The coordinator as one kernel reaches it.
#[derive(Clone, Copy)]
pub(crate) struct Port<'a> {
    core: &'a Coordinator,
    switch: Switch<'a>,
}

impl Deref for Port<'_> {
    type Target = Coordinator;

    fn deref(&self) -> &Coordinator {
        self.core
    }
}

impl<'a> Port<'a> {
    pub(crate) fn new(core: &'a Coordinator, switch: Switch<'a>) -> Self {
        Self { core, switch }
    }

    /// The coordinator itself.
    pub(crate) fn core(self) -> &'a Coordinator {
        self.core
    }

    /// See [`Coordinator::enter`].
    ///
    /// # Errors
    /// [`Stopped`] when the job was stopped before this tag.
    pub(crate) fn enter(self, tag: Tag) -> Result<Guard<'a>, Stopped> {
        self.core.enter(tag, self.switch)
    }

    /// See [`Coordinator::wait`].
    pub(crate) fn wait(self, rank: u16) -> Wake {
        self.core.wait(rank, self.switch)
    }

    /// See [`Coordinator::meet`] and [`Coordinator::meet_on_one_thread`]. `stand` is called before this thread runs other
    /// kernels: it sends the events so far. `work` is done while the thread waits for others.
    pub(crate) fn meet<S>(
        self,
        waiting: &Waiting,
        state: &mut S,
        stand: impl FnOnce(&mut S),
        work: impl Fn(&mut S, bool) -> bool,
    ) -> Met {
        match self.switch {
            Switch::Thread => self.core.meet(waiting, |look| work(state, look)),
            Switch::Coroutine(_) => self.core.meet_on_one_thread(waiting, self.switch, || stand(state)),
        }
    }

    /// Lets all other kernels come up to `tag`, if this one is running.
    pub(crate) fn catch_up(self, tag: Tag) {
        let running = self.core.lock().status(tag.rank) == super::Status::Running;
        if running && let Ok(mut guard) = self.enter(tag) {
            self.leave(&mut guard);
        }
    }

    /// Waits for the merger to give chunks back: `try_now` asks for one, `wait` waits for one on a thread of its own. See
    /// [`Coordinator::wait_credit`].
    pub(crate) fn wait_chunk<R, S>(
        self,
        tag: Tag,
        source: &mut S,
        mut try_now: impl FnMut(&mut S) -> Option<R>,
        wait: impl FnOnce(&mut S) -> R,
    ) -> R {
        self.core.wait_credit(tag, || match self.switch {
            Switch::Thread => wait(source),
            Switch::Coroutine(yielder) => loop {
                if let Some(chunk) = try_now(source) {
                    break chunk;
                }
                yielder.suspend(Pause::Chunk);
            },
        })
    }
}
