//! Open watches: their clients, jobs and positions.
//!
//! Invariant: a watch is listed exactly as long as its [`Listed`] lives.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use dashmap::DashMap;
use tokio::sync::{Semaphore, SemaphorePermit};

use super::live::LiveJob;
use super::turns::CallerTurns;

/// A watch.
#[derive(Debug)]
pub(crate) struct OpenWatch {
    live: Arc<LiveJob>,
    cursor: AtomicU64,
}

impl OpenWatch {
    /// Events of the log that have not been sent.
    fn lag(&self) -> u64 {
        self.live.tail().position().last_seq.saturating_sub(self.cursor.load(Ordering::Relaxed))
    }
}

/// All watches.
#[derive(Debug)]
pub(crate) struct Streams {
    next: AtomicU64,
    open: DashMap<u64, Arc<OpenWatch>>,
    /// Places for reads of logs: more at once make none of them faster, and each thread keeps memory of its own.
    reads: Semaphore,
    /// Turns of tenants to make results.
    pub(crate) renders: Arc<CallerTurns>,
    /// Turns of identities to read rows of the ledger, machines and blobs.
    pub(crate) lookups: Arc<CallerTurns>,
}

impl Default for Streams {
    fn default() -> Self {
        let cores = crate::cpu::cores();
        Self {
            next: AtomicU64::default(),
            open: DashMap::new(),
            reads: Semaphore::new(2 * cores),
            renders: Arc::default(),
            lookups: Arc::default(),
        }
    }
}

/// Data of a watch.
#[derive(Debug)]
pub(crate) struct WatchStatus {
    pub(crate) number: u64,
    pub(crate) job: String,
    pub(crate) tenant: String,
    pub(crate) cursor: u64,
    pub(crate) behind: u64,
}

/// A place in the list, left when it is dropped.
#[derive(Debug)]
pub(crate) struct Listed {
    streams: Arc<Streams>,
    number: u64,
    stream: Arc<OpenWatch>,
}

impl Streams {
    /// A place for a read of a log; none once the server is gone.
    pub(crate) async fn reading(&self) -> Option<SemaphorePermit<'_>> {
        self.reads.acquire().await.ok()
    }

    pub(crate) fn list(self: &Arc<Self>, live: Arc<LiveJob>) -> Listed {
        let number = self.next.fetch_add(1, Ordering::Relaxed) + 1;
        let stream = Arc::new(OpenWatch { live, cursor: AtomicU64::new(0) });
        self.open.insert(number, stream.clone());
        Listed { streams: self.clone(), number, stream }
    }

    /// All of them, oldest first.
    pub(crate) fn seen(&self) -> Vec<WatchStatus> {
        let seen = |number: u64, stream: &OpenWatch| {
            let mut tenant = String::new();
            stream.live.peek(|record| tenant.clone_from(&record.tenant));
            let cursor = stream.cursor.load(Ordering::Relaxed);
            WatchStatus { number, job: stream.live.id.clone(), tenant, cursor, behind: stream.lag() }
        };
        let mut all: Vec<WatchStatus> = self.open.iter().map(|stream| seen(*stream.key(), stream.value())).collect();
        all.sort_by_key(|seen| seen.number);
        all
    }

    /// How many there are, and how many events the slowest is behind.
    pub(super) fn count(&self) -> (usize, u64) {
        (self.open.len(), self.open.iter().map(|stream| stream.lag()).max().unwrap_or(0))
    }
}

impl Listed {
    /// Notes how far the watch is.
    pub(crate) fn reached(&self, cursor: u64) {
        self.stream.cursor.store(cursor, Ordering::Relaxed);
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        self.streams.open.remove(&self.number);
    }
}
