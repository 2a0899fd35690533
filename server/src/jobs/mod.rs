//! Jobs: admission, queue, workers, and the jobs in memory.
//!
//! [`Core`] is what all parts of the server share. Invariant: every job in the ledger that has not ended is in
//! `live`, and is either in the queue or on a worker thread, until the server drains.

pub(crate) mod describe;
mod files;
pub(crate) mod live;
pub(crate) mod operator;
pub(crate) mod progress;
mod sink;
mod system;
pub(crate) mod worker;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use dashmap::DashMap;
use tokio::sync::watch;

use crate::blobs::Blobs;
use crate::drain::Drain;
use crate::ledger::record::{Record, State, now_ms};
use crate::ledger::{Ledger, Submitted, recovered};
use crate::machines::Machines;
use crate::options::Options;
use crate::reason::Refusal;
use crate::runner::Runner;
use crate::store::Store;
pub(crate) use files::Sandbox;
use live::{Live, lock};

/// Ended jobs that stay in memory with their results.
const RECENT: usize = 8;

/// What all parts of the server share.
pub(crate) struct Core {
    pub(crate) options: Options,
    pub(crate) store: Store,
    pub(crate) blobs: Blobs,
    pub(crate) machines: Machines,
    pub(crate) ledger: Ledger,
    pub(crate) runner: Box<dyn Runner>,
    pub(crate) drain: Drain,
    live: DashMap<String, Arc<Live>>,
    queue: Mutex<Queue>,
    /// Jobs on worker threads.
    running: watch::Sender<usize>,
}

impl std::fmt::Debug for Core {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Core").field("options", &self.options).finish_non_exhaustive()
    }
}

/// Jobs that wait, and who has a place.
#[derive(Debug, Default)]
struct Queue {
    waiting: VecDeque<Arc<Live>>,
    /// Places given to submits whose ledger entry is under way.
    reserved: usize,
    running: usize,
    recent: VecDeque<String>,
}

impl Core {
    pub(crate) fn open(options: Options, runner: Box<dyn Runner>) -> Result<Arc<Self>, Refusal> {
        let store = Store::open(options.data.clone(), !options.ephemeral)?;
        let blobs = match options.ephemeral {
            true => Blobs::in_memory(options.max_blob_bytes),
            false => Blobs::new(store.clone(), options.max_blob_bytes),
        };
        let core = Arc::new(Self {
            ledger: Ledger::open(&store)?,
            machines: Machines::new(blobs.clone()),
            store,
            blobs,
            runner,
            drain: Drain::new(),
            live: DashMap::new(),
            queue: Mutex::default(),
            running: watch::Sender::new(0),
            options,
        });
        Ok(core)
    }

    /// Puts back into the queue what a server before this one left unfinished.
    pub(crate) fn recover(self: &Arc<Self>) -> Result<(), Refusal> {
        for record in self.ledger.unfinished()? {
            let before = record.state;
            let record = recovered(record, self.options.attempts);
            tracing::info!(job = record.id, state = ?record.state, attempt = record.attempt, "recovered");
            if record.state != before {
                self.ledger.update_blocking(record.clone())?;
            }
            if !record.state.ended() {
                self.admit(Arc::new(Live::new(record)));
            }
        }
        self.pump();
        Ok(())
    }

    /// Accepts a job; the answer says whether it was known.
    pub(crate) async fn submit(self: &Arc<Self>, record: Record) -> Result<(Record, bool), Refusal> {
        if let Some(known) = self.ledger.by_request(&record.request_id)? {
            return if known.content == record.content {
                Ok((self.current(known), true))
            } else {
                Err(Refusal::RequestIdReused(record.request_id))
            };
        }
        let place = self.reserve()?;
        let submitted = self.ledger.submit(record.clone()).await?;
        drop(place);
        match submitted {
            Submitted::Known(known) => Ok((self.current(*known), true)),
            Submitted::New => {
                tracing::info!(job = record.id, machine = record.machine_name, "accepted");
                self.admit(Arc::new(Live::new(record.clone())));
                self.pump();
                Ok((record, false))
            }
        }
    }

    /// The newest state of a record.
    fn current(&self, record: Record) -> Record {
        self.live(&record.id).map_or(record, |live| live.record())
    }

    /// A place in the queue for a submit under way, given back when dropped.
    fn reserve(self: &Arc<Self>) -> Result<impl Drop + Send + use<>, Refusal> {
        struct Place(Arc<Core>);
        impl Drop for Place {
            fn drop(&mut self) {
                lock(&self.0.queue).reserved -= 1;
            }
        }
        if self.drain.begun() {
            return Err(Refusal::Draining { cursor: 0 });
        }
        let mut queue = lock(&self.queue);
        let free = self.options.slots().saturating_sub(queue.running);
        if queue.waiting.len() + queue.reserved >= self.options.queue + free {
            return Err(Refusal::QueueFull(self.options.queue));
        }
        queue.reserved += 1;
        Ok(Place(self.clone()))
    }

    fn admit(&self, live: Arc<Live>) {
        self.live.insert(live.id.clone(), live.clone());
        lock(&self.queue).waiting.push_back(live);
    }

    /// Starts waiting jobs while there are free workers.
    fn pump(self: &Arc<Self>) {
        while let Some(live) = self.next() {
            worker::start(self.clone(), live);
        }
    }

    fn next(&self) -> Option<Arc<Live>> {
        let mut queue = lock(&self.queue);
        if self.drain.begun() || queue.running >= self.options.slots() {
            return None;
        }
        let live = queue.waiting.pop_front()?;
        queue.running += 1;
        self.running.send_replace(queue.running);
        Some(live)
    }

    /// A worker is free again.
    fn free(self: &Arc<Self>, live: &Live) {
        let gone = {
            let mut queue = lock(&self.queue);
            queue.running -= 1;
            self.running.send_replace(queue.running);
            queue.recent.push_back(live.id.clone());
            if queue.recent.len() > RECENT { queue.recent.pop_front() } else { None }
        };
        if let Some(gone) = gone {
            self.live.remove_if(&gone, |_, live| live.state().ended());
        }
        self.pump();
    }

    /// Number of running jobs, to be followed.
    pub(crate) fn running(&self) -> watch::Receiver<usize> {
        self.running.subscribe()
    }

    /// Interrupts all running jobs; they are queued again in the ledger.
    pub(crate) fn interrupt(&self) {
        self.live.iter().filter(|live| live.state() == State::Running).for_each(|live| live.interrupt());
    }

    pub(crate) fn live(&self, id: &str) -> Option<Arc<Live>> {
        self.live.get(id).map(|live| live.clone())
    }

    /// A job wherever it is.
    pub(crate) fn job(&self, id: &str) -> Result<Record, Refusal> {
        if let Some(live) = self.live(id) {
            return Ok(live.record());
        }
        self.ledger.job(id)?.ok_or_else(|| Refusal::UnknownJob(id.to_owned()))
    }

    /// Jobs before this one in the queue.
    pub(crate) fn queued_before(&self, id: &str) -> usize {
        lock(&self.queue).waiting.iter().position(|live| live.id == id).unwrap_or(0)
    }

    /// Cancels a job: durable first, then in memory.
    pub(crate) async fn cancel(self: &Arc<Self>, id: &str) -> Result<Record, Refusal> {
        let Some(live) = self.live(id) else { return self.job(id) };
        let waiting = {
            let mut queue = lock(&self.queue);
            let at = queue.waiting.iter().position(|waiting| waiting.id == id);
            at.and_then(|at| queue.waiting.remove(at)).is_some()
        };
        let record = live.change(|record| record.cancel |= !record.state.ended());
        if record.state.ended() {
            return Ok(record);
        }
        if waiting {
            let ended = Record { state: State::Cancelled, ended_ms: now_ms(), ..record };
            self.ledger.update(ended.clone()).await?;
            live.change(|record| record.clone_from(&ended));
            self.live.remove(id);
            return Ok(ended);
        }
        self.ledger.flag_cancel(id.to_owned()).await?;
        live.cancel();
        Ok(live.record())
    }

    /// Deletes an ended job.
    pub(crate) async fn delete(&self, id: &str) -> Result<(), Refusal> {
        let record = self.job(id)?;
        if !record.state.ended() {
            return Err(Refusal::JobNotEnded(id.to_owned()));
        }
        self.ledger.remove(record).await?;
        self.live.remove(id);
        Ok(self.store.remove_job(id)?)
    }
}
