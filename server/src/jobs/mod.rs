//! Jobs: admission, queue, workers, and the jobs in memory.
//!
//! [`Core`] is the state that all parts of the server share. Invariant: every job in the ledger that has not ended is
//! in `live`, and is either in the queue or on a worker thread, until the server drains. A fault of the host never ends
//! a job: its run is dropped and started again later.

pub(crate) mod admission;
mod attended;
mod board;
pub(crate) mod describe;
mod ends;
pub(crate) mod feed;
mod files;
pub(crate) mod filter;
mod flusher;
pub(crate) mod growing;
mod hold;
mod housekeeping;
mod limits;
pub(crate) mod live;
pub(crate) mod lock;
mod observe;
pub(crate) mod operator;
pub(crate) mod operator_wait;
pub(crate) mod progress;
pub(crate) mod received;
mod recent;
mod recovery;
mod reuse;
pub(crate) mod seal;
pub(crate) mod shares;
mod sink;
pub(crate) mod step;
pub(crate) mod streams;
pub(crate) mod suspicion;
mod system;
mod tally;
pub(crate) mod turns;
pub(crate) mod worker;
pub(crate) mod worker_wait;

use std::sync::Arc;
use std::time::Duration;

use board::Board;
use ends::Ends;
use feed::{Feed, Removed};
use flusher::Flusher;
use live::LiveJob;
use shares::TenantQuotas;
use streams::Streams;

use crate::blobs::Blobs;
use crate::clock::Clock;
use crate::connections::Connections;
use crate::drain::Drain;
use crate::host::ServerHost;
use crate::ledger::record::{JobRecord, JobState, JobWork};
use crate::ledger::{Ledger, NewJob, SubmitOutcome};
use crate::log::Logs;
use crate::log::kept::StoredLog;
use crate::machines::{MachineCache, is_shipped};
use crate::memory::MemoryBudget;
use crate::metrics::Metrics;
use crate::options::ServerOptions;
use crate::queue::Queue;
use crate::reason::Refusal;
use crate::runner::Runner;
use crate::spans::JobSpans;
use crate::webhooks::Webhooks;

pub(crate) use files::JobSandbox;

/// Between two looks at jobs that wait for the disk, the ledger or their time.
const TICK: Duration = Duration::from_millis(50);

/// Stores in which a server keeps its jobs.
#[derive(Debug)]
pub(crate) struct Seams {
    pub(crate) ledger: Arc<dyn Ledger>,
    pub(crate) queue: Box<dyn Queue>,
    pub(crate) logs: Arc<dyn Logs>,
    pub(crate) blobs: Arc<dyn Blobs>,
    pub(crate) host: Arc<dyn ServerHost>,
}

/// The visible state of the server while it works.
#[derive(Debug)]
pub(crate) struct Telemetry {
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) spans: JobSpans,
    pub(crate) webhooks: Webhooks,
}

/// State that all parts of the server share.
pub(crate) struct Core {
    pub(crate) options: ServerOptions,
    pub(crate) host: Arc<dyn ServerHost>,
    pub(crate) logs: Arc<dyn Logs>,
    pub(crate) blobs: Arc<dyn Blobs>,
    pub(crate) machines: MachineCache,
    pub(crate) ledger: Arc<dyn Ledger>,
    pub(crate) runner: Box<dyn Runner>,
    pub(crate) drain: Drain,
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) streams: Arc<Streams>,
    pub(crate) connections: Arc<Connections>,
    flusher: Flusher,
    ends: Ends,
    board: Board,
    shares: TenantQuotas,
}

impl std::fmt::Debug for Core {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Core").field("options", &self.options).finish_non_exhaustive()
    }
}

impl Core {
    pub(crate) fn new(
        options: ServerOptions,
        runner: Box<dyn Runner>,
        seams: Seams,
        seen: Telemetry,
    ) -> Result<Arc<Self>, Refusal> {
        let Seams { ledger, queue, logs, blobs, host } = seams;
        let Telemetry { metrics, spans, webhooks } = seen;
        let core = Arc::new(Self {
            flusher: Flusher::start()?,
            ends: Ends::start(spans, webhooks)?,
            board: Board::new(queue, Clock::from(ledger.highest_ms()), ledger.epoch(), options.maxima.memory_bytes),
            ledger,
            machines: MachineCache::new(blobs.clone(), options.maxima.max_machine_bytes),
            host,
            logs,
            blobs,
            runner,
            drain: Drain::new(),
            metrics,
            streams: Arc::default(),
            connections: Arc::default(),
            shares: TenantQuotas::new(&options),
            options,
        });
        core.let_run();
        Ok(core)
    }

    /// Requeues the jobs that a previous server left unfinished, and starts to run jobs.
    pub(crate) fn recover(self: &Arc<Self>) -> Result<(), Refusal> {
        self.take_up_unfinished()?;
        housekeeping::remove_folders_without_a_row(self)?;
        self.pump();
        housekeeping::start(self)?;
        let core = Arc::downgrade(self);
        let mut writable = self.ledger.writable();
        std::thread::Builder::new().name("tick".to_owned()).spawn(move || {
            while let Some(core) = core.upgrade() {
                if writable.has_changed().unwrap_or(false) && *writable.borrow_and_update() {
                    core.find_unanswered();
                }
                core.stop_late_jobs();
                core.pump();
                core.keep_cleared();
                operator_wait::notify_followers(&core);
                core.board.ticked();
                drop(core);
                std::thread::sleep(TICK);
            }
        })?;
        Ok(())
    }

    /// Whether a name belongs to a shipped machine. In a server of one command its one user may replace those.
    pub(crate) fn reserved(&self, name: &str) -> bool {
        !self.options.embedded.ephemeral && is_shipped(name)
    }

    /// Whether there is enough disk space for new work.
    pub(crate) fn room(&self) -> Result<(), Refusal> {
        let least = self.options.min_free_bytes;
        match self.host.free() {
            Some(free) if free < least && !self.options.embedded.ephemeral => Err(Refusal::DiskFull(least)),
            _ => Ok(()),
        }
    }

    /// Accepts a job; the answer says whether it was known.
    pub(crate) async fn submit(self: &Arc<Self>, job: Box<NewJob>) -> Result<(Box<JobRecord>, bool), Refusal> {
        // The ledger finds out whether the request is a repeat. A repeat needs neither memory nor a place in the queue.
        let place = match admission::place(self, &job.record.tenant).await {
            Ok(place) => place,
            Err(refusal) => return admission::known(self, &job)?.ok_or(refusal),
        };
        let NewJob { record, work } = &*job;
        let core = Arc::downgrade(self);
        let kept = work.is_small().then(|| work.clone());
        // Jobs enter the queue in the order in which the ledger accepted them.
        let accepted = move |record: &JobRecord| {
            if let Some(core) = core.upgrade() {
                core.admit(core.accepted(record.clone(), kept));
            }
            // Only now: no other submit may have the place between the two.
            drop(place);
        };
        let (blobs, tenant) = (self.blobs.clone(), record.tenant.clone());
        let check = move |work: &JobWork| {
            blobs.of(&tenant).require(&mut work.files.iter().map(|(_, digest)| digest))?;
            blobs.of(&work.machine.tenant).require(&mut work.machine.files.values())
        };
        let submitted = self.ledger.submit(job, Box::new(check), Box::new(accepted)).await?;
        match submitted {
            SubmitOutcome::Known(known) => {
                self.answered(&known)?;
                Ok((Box::new(self.current(*known)), true))
            }
            SubmitOutcome::New(record) => {
                self.metrics.jobs.accepted.inc();
                self.board.tally.accepted(&record);
                self.pump();
                Ok((record, false))
            }
        }
    }

    /// Whether a job that is in the ledger is durable there. One that is not in memory may be from a transaction whose
    /// sync failed: a loss of power takes it back while the ledger cannot be written.
    fn answered(&self, known: &JobRecord) -> Result<(), Refusal> {
        if known.state.ended() || self.live(&known.id).is_some() {
            return Ok(());
        }
        if !*self.ledger.writable().borrow() {
            return Err(Refusal::Storage("it is not known yet whether the job has been accepted".to_owned()));
        }
        self.take_up(known.clone());
        Ok(())
    }

    /// Takes up jobs that the ledger holds although their submits were refused: the sync of their transaction failed,
    /// and the ledger was found to hold it when it was opened again.
    fn find_unanswered(&self) {
        for record in self.ledger.unfinished().unwrap_or_default() {
            if self.live(&record.id).is_none() {
                self.take_up(record);
            }
        }
    }

    /// The memory budget of the server.
    pub(crate) fn memory(&self) -> &Arc<MemoryBudget> {
        &self.board.memory
    }

    /// A job that is in memory from now on.
    fn in_memory(&self, record: JobRecord) -> Arc<LiveJob> {
        let live = self.accepted(record, None);
        // Answers that cannot be read are reported by the next run.
        if let Some(tenant) = live.peek(|record| record.attended.then(|| record.tenant.clone()))
            && let Ok(Some(work)) = self.ledger.work(&live.id)
        {
            *live.desk().received() = Some(received::received_before(self, &tenant, &work.outcomes()));
        }
        live
    }

    /// A job that is in memory from now on, with its work if the work is small.
    fn accepted(&self, record: JobRecord, work: Option<JobWork>) -> Arc<LiveJob> {
        let bytes = record.bytes() + work.as_ref().map_or(0, |_| JobWork::SMALL);
        let taken = self.board.memory.count(bytes);
        Arc::new(LiveJob::counted(record, Some(taken), work))
    }

    fn take_up(&self, record: JobRecord) {
        let live = self.in_memory(record);
        if !self.enter(&live) {
            return;
        }
        // It may have ended since it was looked at.
        match self.ledger.job(&live.id) {
            Ok(Some(record)) if !record.state.ended() => self.wait_in_queue(&live),
            _ => drop(self.board.live.remove(&live.id)),
        }
    }

    /// The newest state of a record.
    pub(crate) fn current(&self, record: JobRecord) -> JobRecord {
        self.live(&record.id).map_or(record, |live| live.record())
    }

    /// The log of a job, wherever it is.
    pub(crate) fn kept_log(&self, id: &str) -> Result<Option<StoredLog>, Refusal> {
        if let Some(small) = self.live(id).and_then(|live| live.small_log()) {
            return Ok(Some(small));
        }
        match self.logs.kept(id) {
            Some(kept) => Ok(Some(kept)),
            None => Ok(self.ledger.log(id)?.map(|log| StoredLog::in_ledger(id, log))),
        }
    }

    pub(crate) fn live(&self, id: &str) -> Option<Arc<LiveJob>> {
        self.board.live.get(id).map(|live| live.clone())
    }

    /// A job wherever it is.
    pub(crate) fn job(&self, id: &str) -> Result<JobRecord, Refusal> {
        if let Some(live) = self.live(id) {
            return Ok(live.record());
        }
        self.ledger.job(id)?.ok_or_else(|| Refusal::UnknownJob(id.to_owned()))
    }

    /// The work of a job.
    pub(crate) fn work(&self, id: &str) -> Result<JobWork, Refusal> {
        self.ledger.work(id)?.ok_or_else(|| {
            Refusal::DataLoss(format!("the request of job '{id}' is gone from the ledger; submit the job again"))
        })
    }

    /// A job of a tenant; those of others are not there for it.
    pub(crate) fn job_of(&self, tenant: &str, id: &str) -> Result<JobRecord, Refusal> {
        let record = self.job(id)?;
        if record.tenant == tenant { Ok(record) } else { Err(Refusal::UnknownJob(id.to_owned())) }
    }

    /// Cancels a job: durable first, then in memory.
    pub(crate) async fn cancel(self: &Arc<Self>, id: &str) -> Result<JobRecord, Refusal> {
        self.cancel_first(id).await.map(|(record, _)| record)
    }

    /// Does the same, and says whether the job had not ended and no other call had requested its cancel before.
    pub(crate) async fn cancel_first(self: &Arc<Self>, id: &str) -> Result<(JobRecord, bool), Refusal> {
        let Some(live) = self.live(id) else { return Ok((self.job(id)?, false)) };
        let waiting = self.withdraw(id);
        let mut first = false;
        let record = live.change(|record| {
            first = !record.state.ended() && !record.cancel;
            record.cancel |= !record.state.ended();
        });
        if record.state.ended() {
            return Ok((record, false));
        }
        let forget = || {
            live.change(|record| record.cancel = false);
        };
        if waiting {
            let ended = self.end_cancelled(&live, record).await.inspect_err(|_| {
                forget();
                self.put_back(&live);
            });
            return Ok((ended?, first));
        }
        self.ledger.flag_cancel(id.to_owned()).await.inspect_err(|_| {
            if first {
                forget();
            }
        })?;
        live.cancel();
        if self.withdraw(id) {
            // A pause has taken it from its worker meanwhile.
            let ended = self.end_cancelled(&live, live.record()).await.inspect_err(|_| self.put_back(&live));
            return Ok((ended?, first));
        }
        self.changed(&live);
        Ok((live.record(), first))
    }

    /// Ends a job that was withdrawn, because it was cancelled.
    async fn end_cancelled(&self, live: &LiveJob, record: JobRecord) -> Result<JobRecord, Refusal> {
        let mut ended = JobRecord { state: JobState::Cancelled, paused: false, ..record };
        ended.end(&self.board.clock);
        self.ledger.update(ended.clone()).await?;
        live.change(|record| record.clone_from(&ended));
        self.ended(&ended);
        self.changed(live);
        self.drop_ended(&live.id);
        Ok(ended)
    }

    /// Deletes an ended job. If several calls delete a job at the same time, one succeeds; for the other calls the job
    /// is unknown.
    pub(crate) async fn delete(&self, id: &str) -> Result<(), Refusal> {
        let record = self.job(id)?;
        if !record.state.ended() {
            return Err(Refusal::JobNotEnded(id.to_owned()));
        }
        if !self.ledger.remove(record.clone()).await? {
            return Err(Refusal::UnknownJob(id.to_owned()));
        }
        self.forget(id, Some(&record))
    }

    /// Removes the remains of a job that is no longer in the ledger.
    fn forget(&self, id: &str, record: Option<&JobRecord>) -> Result<(), Refusal> {
        self.board.live.remove(id);
        if let Some(record) = record {
            let removed = Removed { machine: record.machine.full_name(), labels: record.asked.labels.clone() };
            self.board.feed.removed(&record.tenant, id, removed);
        }
        Ok(self.logs.remove(id)?)
    }

    /// Changes of all jobs.
    pub(crate) fn feed(&self) -> &Feed {
        &self.board.feed
    }

    /// Whether a job is referenced outside the list of jobs.
    fn watched(&self, id: &str) -> bool {
        self.board.live.get(id).is_some_and(|live| Arc::strong_count(&live) > 1)
    }
}
