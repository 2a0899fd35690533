//! Turns for making results: each tenant makes only a few results at the same time, and its other calls wait.
//!
//! Making a result reads the whole log of a job and takes processor time from jobs. The client may disconnect before
//! the result is made, so the limit on calls in progress does not bound this work. *Invariants:* a turn is held only
//! while a result is being made, never while its client reads slowly; a tenant without turns takes no memory.

use std::sync::Arc;

use dashmap::DashMap;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Results that a tenant may make at the same time on a server with one core.
const FEW: usize = 2;

/// The turns of all tenants.
#[derive(Debug)]
pub(crate) struct Renders {
    each: usize,
    tenants: DashMap<String, Arc<Semaphore>>,
}

impl Default for Renders {
    fn default() -> Self {
        Self { each: crate::cpu::cores().max(FEW), tenants: DashMap::new() }
    }
}

impl Renders {
    /// Waits for a turn of a tenant.
    pub(crate) async fn turn(self: &Arc<Self>, tenant: &str) -> RenderTurn {
        let new = || Arc::new(Semaphore::new(self.each));
        // The guard of the entry must not be held while this call waits.
        let turns = self.tenants.entry(tenant.to_owned()).or_insert_with(new).clone();
        let mut turn = RenderTurn { all: self.clone(), tenant: tenant.to_owned(), turns, held: None };
        turn.resume().await;
        turn
    }
}

/// A turn to make a result. When it is dropped, the next call begins.
#[derive(Debug)]
pub(crate) struct RenderTurn {
    all: Arc<Renders>,
    tenant: String,
    turns: Arc<Semaphore>,
    held: Option<OwnedSemaphorePermit>,
}

impl RenderTurn {
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

impl Drop for RenderTurn {
    fn drop(&mut self) {
        self.held = None;
        // This turn and the map hold one handle each.
        self.all.tenants.remove_if(&self.tenant, |_, turns| Arc::strong_count(turns) <= 2);
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
    fn a_tenant_waits_for_its_own_turns_only() {
        let renders = Arc::new(Renders { each: 2, tenants: DashMap::new() });
        let mut first = ready(renders.turn("a")).unwrap();
        let second = ready(renders.turn("a")).unwrap();
        assert!(ready(renders.turn("a")).is_none(), "both turns are held");
        let other = ready(renders.turn("b")).expect("another tenant has turns of its own");
        first.pause();
        let third = ready(renders.turn("a")).expect("the client of the first call does not read");
        assert!(ready(first.resume()).is_none());
        drop(second);
        assert!(ready(first.resume()).is_some());
        drop((first, third, other));
        assert!(renders.tenants.is_empty(), "no memory is left");
    }
}
