//! Turns for work on blocking threads: each caller has only a few at the same time, and its other calls wait.
//!
//! Making a result reads the whole log of a job, and a list reads many rows; both take processor time from others. A
//! client may disconnect before the work ends, so the limit on calls in progress does not bound this work.
//!
//! *Invariants:* a turn is held only while its work is done, never while its client reads slowly. A call that waits for
//! a turn uses no thread, and ends when its client disconnects. A caller without turns takes no memory.

use std::sync::Arc;

use dashmap::DashMap;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Turns of a caller on a server with one core.
const FEW: usize = 2;

/// The turns of all callers: tenants or identities.
#[derive(Debug)]
pub(crate) struct CallerTurns {
    each: usize,
    callers: DashMap<String, Arc<Semaphore>>,
}

impl Default for CallerTurns {
    fn default() -> Self {
        Self { each: crate::cpu::cores().max(FEW), callers: DashMap::new() }
    }
}

impl CallerTurns {
    /// Waits for a turn of a caller.
    pub(crate) async fn turn(self: &Arc<Self>, caller: &str) -> OwnTurn {
        let new = || Arc::new(Semaphore::new(self.each));
        // The guard of the entry must not be held while this call waits.
        let turns = self.callers.entry(caller.to_owned()).or_insert_with(new).clone();
        let mut turn = OwnTurn { all: self.clone(), caller: caller.to_owned(), turns, held: None };
        turn.resume().await;
        turn
    }
}

/// A turn. When it is dropped, the next call begins.
#[derive(Debug)]
pub(crate) struct OwnTurn {
    all: Arc<CallerTurns>,
    caller: String,
    turns: Arc<Semaphore>,
    held: Option<OwnedSemaphorePermit>,
}

impl OwnTurn {
    /// Gives the turn to another call while this one waits for its client.
    pub(crate) fn pause(&mut self) {
        self.held = None;
    }

    /// Waits until this call has a turn again.
    pub(crate) async fn resume(&mut self) {
        // The semaphore is never closed.
        self.held = self.turns.clone().acquire_owned().await.ok();
    }
}

impl Drop for OwnTurn {
    fn drop(&mut self) {
        self.held = None;
        // This turn and the map hold one handle each.
        self.all.callers.remove_if(&self.caller, |_, turns| Arc::strong_count(turns) <= 2);
    }
}

#[cfg(test)]
mod tests {
    use std::future::Future;
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    use super::*;

    /// The output of a future that is ready.
    fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
        match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(output) => Some(output),
            Poll::Pending => None,
        }
    }

    #[test]
    fn a_caller_waits_for_its_own_turns_only() {
        let turns = Arc::new(CallerTurns { each: 2, callers: DashMap::new() });
        let mut first = ready(turns.turn("a")).unwrap();
        let second = ready(turns.turn("a")).unwrap();
        assert!(ready(turns.turn("a")).is_none(), "both turns are held");
        let other = ready(turns.turn("b")).expect("another caller has turns of its own");
        first.pause();
        let third = ready(turns.turn("a")).expect("the client of the first call does not read");
        assert!(ready(first.resume()).is_none());
        drop(second);
        assert!(ready(first.resume()).is_some());
        drop((first, third, other));
        assert!(turns.callers.is_empty(), "no memory is left");
    }
}
