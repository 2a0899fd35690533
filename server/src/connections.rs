//! Open connections: their callers, their start, and their calls.
//!
//! *Invariant:* a connection is listed exactly as long as its [`ListedConnection`] lives, a call counts until its [`ActiveCall`] is
//! dropped.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use dashmap::DashMap;

use crate::access::Identity;
use crate::ledger::record::now_ms;

/// Counts of a connection.
#[derive(Debug)]
struct ConnectionCounters {
    number: u64,
    peer: SocketAddr,
    since_ms: i64,
    identity: Mutex<Option<Arc<Identity>>>,
    /// Several identities have called.
    shared: AtomicBool,
    open: AtomicUsize,
    all: AtomicU64,
    /// Calls begun since the last request.
    served: AtomicUsize,
}

/// Data of a connection.
#[derive(Debug)]
pub(crate) struct ConnectionStatus {
    pub(crate) number: u64,
    pub(crate) peer: SocketAddr,
    pub(crate) since_ms: i64,
    pub(crate) identity: Option<Arc<Identity>>,
    pub(crate) open: usize,
    pub(crate) all: u64,
}

/// All connections.
#[derive(Debug, Default)]
pub(crate) struct Connections {
    last: AtomicU64,
    open: DashMap<u64, Arc<ConnectionCounters>>,
}

impl Connections {
    /// Lists a connection.
    pub(crate) fn list(self: &Arc<Self>, peer: SocketAddr) -> ListedConnection {
        let number = self.last.fetch_add(1, Ordering::Relaxed) + 1;
        let counts = Arc::new(ConnectionCounters {
            number,
            peer,
            since_ms: now_ms(),
            identity: Mutex::default(),
            shared: AtomicBool::new(false),
            open: AtomicUsize::new(0),
            all: AtomicU64::new(0),
            served: AtomicUsize::new(0),
        });
        self.open.insert(number, counts.clone());
        ListedConnection { all: self.clone(), counts }
    }

    /// How many are open.
    pub(crate) fn count(&self) -> usize {
        self.open.len()
    }

    /// All of them, oldest first.
    pub(crate) fn seen(&self) -> Vec<ConnectionStatus> {
        let seen = |counts: &ConnectionCounters| ConnectionStatus {
            number: counts.number,
            peer: counts.peer,
            since_ms: counts.since_ms,
            identity: counts.identity.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            open: counts.open.load(Ordering::Relaxed),
            all: counts.all.load(Ordering::Relaxed),
        };
        let mut all: Vec<ConnectionStatus> = self.open.iter().map(|counts| seen(&counts)).collect();
        all.sort_by_key(|connection| connection.number);
        all
    }
}

/// A connection that is listed.
#[derive(Debug)]
pub(crate) struct ListedConnection {
    all: Arc<Connections>,
    counts: Arc<ConnectionCounters>,
}

impl ListedConnection {
    /// Counts a call.
    pub(crate) fn begin(&self) -> ActiveCall {
        self.counts.open.fetch_add(1, Ordering::Relaxed);
        self.counts.all.fetch_add(1, Ordering::Relaxed);
        self.counts.served.fetch_add(1, Ordering::Relaxed);
        ActiveCall(self.counts.clone())
    }

    /// Whether no call is in progress.
    pub(crate) fn is_idle(&self) -> bool {
        self.counts.open.load(Ordering::Relaxed) == 0
    }

    /// Calls begun since the last time this was asked.
    pub(crate) fn take_served(&self) -> usize {
        self.counts.served.swap(0, Ordering::Relaxed)
    }
}

impl Drop for ListedConnection {
    fn drop(&mut self) {
        self.all.open.remove(&self.counts.number);
    }
}

/// A call in progress, until its answer has been sent or dropped.
#[derive(Debug)]
pub(crate) struct ActiveCall(Arc<ConnectionCounters>);

impl ActiveCall {
    /// Whether no identity has called on the connection.
    pub(crate) fn of_a_stranger(&self) -> bool {
        self.0.identity.lock().unwrap_or_else(PoisonError::into_inner).is_none()
    }

    /// Notes the caller; returns whether no other identity has called on the connection.
    pub(crate) fn by(&self, identity: &Arc<Identity>) -> bool {
        let mut last = self.0.identity.lock().unwrap_or_else(PoisonError::into_inner);
        if !last.as_ref().is_some_and(|last| Arc::ptr_eq(last, identity)) {
            let other = last.as_ref().is_some_and(|last| last != identity);
            self.0.shared.fetch_or(other, Ordering::Relaxed);
            *last = Some(identity.clone());
        }
        !self.0.shared.load(Ordering::Relaxed)
    }
}

impl Drop for ActiveCall {
    fn drop(&mut self) {
        self.0.open.fetch_sub(1, Ordering::Relaxed);
    }
}
