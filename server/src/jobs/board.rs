//! The board: jobs in memory, which of them wait, run, or have ended lately, and the way from one to the next.
//!
//! Invariant: a job that has not ended is on the board, and is either in the queue or on a worker thread, until the
//! server drains.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dashmap::DashMap;
use tokio::sync::watch;

use super::live::{Live, lock};
use super::recent::Recent;
use super::{Core, worker};
use crate::ledger::record::State;
use crate::queue::{Entry, Queue};
use crate::reason::Refusal;

/// First and longest pause before a job is run again after the host has failed its run.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);

/// The queue, and places in it.
#[derive(Debug)]
struct Waiting {
    jobs: Box<dyn Queue>,
    /// Places given to submits whose ledger entry is under way.
    reserved: usize,
}

/// Jobs in memory.
#[derive(Debug)]
pub(super) struct Board {
    pub(super) live: DashMap<String, Arc<Live>>,
    queue: Mutex<Waiting>,
    recent: Mutex<Recent>,
    /// Jobs on worker threads.
    running: watch::Sender<usize>,
}

impl Board {
    pub(super) fn new(queue: Box<dyn Queue>) -> Self {
        Self {
            live: DashMap::new(),
            queue: Mutex::new(Waiting { jobs: queue, reserved: 0 }),
            recent: Mutex::default(),
            running: watch::Sender::new(0),
        }
    }
}

impl Core {
    /// A place in the queue for a submit under way, given back when dropped.
    pub(super) fn reserve(self: &Arc<Self>) -> Result<impl Drop + Send + use<>, Refusal> {
        struct Place(Arc<Core>);
        impl Drop for Place {
            fn drop(&mut self) {
                lock(&self.0.board.queue).reserved -= 1;
            }
        }
        if self.drain.begun() {
            return Err(Refusal::Draining { cursor: 0 });
        }
        let mut queue = lock(&self.board.queue);
        let free = self.options.slots().saturating_sub(queue.jobs.running().len());
        if queue.jobs.len() + queue.reserved >= self.options.queue + free {
            return Err(Refusal::QueueFull(self.options.queue));
        }
        queue.reserved += 1;
        Ok(Place(self.clone()))
    }

    /// Takes up a job, once.
    pub(super) fn admit(&self, live: Arc<Live>) {
        if self.enter(&live) {
            self.wait_in_queue(&live);
        }
    }

    /// Adds a job to those in memory; `false` if it is there.
    pub(super) fn enter(&self, live: &Arc<Live>) -> bool {
        let mut new = false;
        self.board.live.entry(live.id.clone()).or_insert_with(|| {
            new = true;
            live.clone()
        });
        new
    }

    pub(super) fn wait_in_queue(&self, live: &Live) {
        let entry = if live.record().runs.suspect { Entry::Suspect } else { Entry::Accepted };
        lock(&self.board.queue).jobs.push(&live.id, entry);
    }

    /// Starts waiting jobs while there are free workers, disk space and a ledger.
    pub(super) fn pump(self: &Arc<Self>) {
        while let Some(live) = self.take() {
            worker::start(self.clone(), live);
        }
    }

    /// The next job, if there is a free worker for it, disk space and a ledger.
    pub(super) fn take(&self) -> Option<Arc<Live>> {
        let waits = lock(&self.board.queue).jobs.len() > 0;
        if waits && *self.ledger.writable().borrow() && self.room().is_ok() { self.next() } else { None }
    }

    fn next(&self) -> Option<Arc<Live>> {
        let mut queue = lock(&self.board.queue);
        if self.drain.begun() {
            return None;
        }
        loop {
            let id = queue.jobs.next(self.options.slots(), Instant::now())?;
            if let Some(live) = self.live(&id) {
                self.board.running.send_replace(queue.jobs.busy());
                return Some(live);
            }
            queue.jobs.free(&id);
        }
    }

    /// Threads for the kernels of a job whose run begins now, of which as many were `asked` for (0 = all): its share of
    /// the cores. A job alone gets them all; one thread is enough where more jobs wait than cores are free.
    pub(super) fn threads(&self, asked: u16) -> u16 {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let jobs = {
            let queue = lock(&self.board.queue);
            queue.jobs.running().len() + queue.jobs.len()
        };
        let share = u16::try_from(cores / jobs.max(1)).unwrap_or(u16::MAX).max(1);
        if asked == 0 { share } else { asked.min(share) }
    }

    /// The run is over and only its storage is left, which needs no core: the next job may run meanwhile.
    pub(super) fn leave(&self, live: &Live) {
        lock(&self.board.queue).jobs.store(&live.id);
    }

    /// A worker is free again: the job has ended, or the drain has interrupted it.
    pub(super) fn free(self: &Arc<Self>, live: &Live) {
        {
            let mut queue = lock(&self.board.queue);
            queue.jobs.free(&live.id);
            self.board.running.send_replace(queue.jobs.busy());
        }
        let bytes = live.finished().map_or(0, |finished| finished.bytes);
        let gone = lock(&self.board.recent).push(live.id.clone(), bytes, self.options.ephemeral);
        for gone in gone {
            self.board.live.remove_if(&gone, |_, live| live.state().ended());
        }
        self.pump();
    }

    /// A worker is free again: the host has failed the run for the `failures`th time, and the job waits for the next.
    pub(super) fn again(&self, live: &Live, failures: u32) {
        let pause = FIRST_PAUSE.saturating_mul(1 << failures.saturating_sub(1).min(16)).min(LONGEST_PAUSE);
        let mut queue = lock(&self.board.queue);
        queue.jobs.free(&live.id);
        queue.jobs.push(&live.id, Entry::Again(Instant::now() + pause));
        self.board.running.send_replace(queue.jobs.busy());
    }

    /// Stops runs that have reached their limit by the clock.
    pub(super) fn stop_late_runs(&self) {
        let now = Instant::now();
        let running = lock(&self.board.queue).jobs.running().to_vec();
        running.iter().filter_map(|id| self.live(id)).for_each(|live| live.check_clock(now));
    }

    /// Number of running jobs, to be followed.
    pub(crate) fn running(&self) -> watch::Receiver<usize> {
        self.board.running.subscribe()
    }

    /// Interrupts all running jobs; they are queued again in the ledger.
    pub(crate) fn interrupt(&self) {
        self.board.live.iter().filter(|live| live.state() == State::Running).for_each(|live| live.interrupt());
    }

    /// Jobs before this one in the queue.
    pub(crate) fn queued_before(&self, id: &str) -> usize {
        lock(&self.board.queue).jobs.before(id)
    }

    /// Takes a job out of the queue; `false` if it does not wait there.
    pub(super) fn withdraw(&self, id: &str) -> bool {
        lock(&self.board.queue).jobs.remove(id)
    }

    /// Lets a job wait again that was withdrawn.
    pub(super) fn put_back(&self, id: &str) {
        lock(&self.board.queue).jobs.push(id, Entry::Again(Instant::now()));
    }
}
