//! A job in memory: from its acceptance until it has ended and left the short list of recent ones.
//!
//! Invariant: the state in [`LiveJob`] is never ahead of the ledger for an end state; a watcher that sees an end can
//! read the results.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use counterpoint_kernel::control::{JobControl, StopSignal};
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::info::Info;
use tokio::sync::watch;

use super::limits::{RunLimits, Stopped, late};
use super::lock::lock;
use super::operator::Desk;
use super::step::Stepping;
use crate::ledger::record::{JobRecord, JobState, JobWork, ReachedLimit, now_ms};
use crate::log::kept::StoredLog;
use crate::log::tail::Tail;
use crate::log::writer::Writer;
use crate::memory::MemoryReservation;
use crate::results::Finished;
use crate::trace::TraceContext;

/// State that exists once a worker has prepared the job.
#[derive(Debug)]
pub(crate) struct PreparedRun {
    pub(crate) info: Arc<Info>,
    pub(crate) control: Arc<JobControl>,
}

/// Bytes that a run counts for until it is prepared.
const UNKNOWN: u64 = 64 << 20;

/// The bytes of the texts of a prepared run, and those that its results may take.
fn held_by(info: &Info) -> u64 {
    let texts = info.files.iter().filter_map(|file| file.text.get()?.as_ref()).map(|text| text.size() as u64);
    let results = info.room.path.saturating_add(info.room.bars).saturating_add(info.room.waiting);
    texts.fold(results.saturating_mul(info.channels.len() as u64), u64::saturating_add)
}

/// Parts of a job in the memory budget.
#[derive(Debug, Default)]
struct Counted {
    /// The memory of the job, until the job has ended.
    taken: Option<MemoryReservation>,
    /// Small work for the first run; otherwise a run reads the work from the ledger.
    work: Option<JobWork>,
}

/// A job in memory.
#[derive(Debug)]
pub(crate) struct LiveJob {
    counted: Mutex<Counted>,
    pub(crate) id: String,
    record: Mutex<JobRecord>,
    state: watch::Sender<JobState>,
    cancel: AtomicBool,
    /// The run is to end, for any reason.
    stop: Mutex<StopSignal>,
    /// End of the log; made on request, since most waiting jobs do not need it yet.
    tail: OnceLock<Arc<Tail>>,
    run: Mutex<Option<Arc<PreparedRun>>>,
    finished: OnceLock<Arc<Finished>>,
    /// Log of the running job; locked for the time of one append or write.
    writer: Mutex<Option<Writer>>,
    /// The log will be written soon.
    promised: AtomicBool,
    /// Where dialogs wait for the operator.
    desk: OnceLock<Arc<Desk>>,
    /// Queue of the commands of the operator who steps through the job.
    stepping: OnceLock<Arc<Stepping>>,
    limits: Mutex<RunLimits>,
    /// Held while the job is paused or resumed, so that ledger and memory agree.
    pub(super) holding: tokio::sync::Mutex<()>,
}

impl LiveJob {
    pub(crate) fn new(record: JobRecord) -> Self {
        Self::counted(record, None, None)
    }

    /// A job whose memory is counted until the job has ended; `work` is given if it is small.
    pub(super) fn counted(record: JobRecord, taken: Option<MemoryReservation>, work: Option<JobWork>) -> Self {
        Self {
            counted: Mutex::new(Counted { taken, work }),
            id: record.id.clone(),
            state: watch::Sender::new(record.state),
            cancel: AtomicBool::new(record.cancel),
            stop: Mutex::default(),
            desk: OnceLock::new(),
            stepping: OnceLock::new(),
            record: Mutex::new(record),
            tail: OnceLock::new(),
            run: Mutex::default(),
            finished: OnceLock::new(),
            writer: Mutex::new(None),
            limits: Mutex::default(),
            promised: AtomicBool::new(false),
            holding: tokio::sync::Mutex::default(),
        }
    }

    /// Takes the small work that was kept in memory.
    pub(super) fn take_work(&self) -> Option<JobWork> {
        lock(&self.counted).work.take()
    }

    pub(crate) fn record(&self) -> JobRecord {
        lock(&self.record).clone()
    }

    /// The span of the job, which continues the trace of its client.
    pub(super) fn span(&self) -> tracing::Span {
        let record = lock(&self.record);
        let TraceContext { trace, span, parent, .. } = TraceContext::of(&record.id, &record.runs.traceparent);
        let attempt = record.runs.attempt + 1;
        tracing::info_span!("job", id = record.id, tenant = record.tenant, attempt, trace, span, parent)
    }

    /// End of its log.
    pub(crate) fn tail(&self) -> &Arc<Tail> {
        self.tail.get_or_init(|| Arc::new(Tail::new()))
    }

    /// Desk where its dialogs wait.
    pub(crate) fn desk(&self) -> &Arc<Desk> {
        self.desk.get_or_init(|| Arc::new(Desk::new()))
    }

    /// Its desk, unless it has asked nothing and has no client that attends.
    pub(super) fn desk_if_used(&self) -> Option<&Arc<Desk>> {
        self.desk.get()
    }

    /// Its console, unless neither a run nor a client has used it.
    pub(super) fn stepping_if_used(&self) -> Option<&Arc<Stepping>> {
        self.stepping.get()
    }

    /// The console of the job.
    pub(crate) fn stepping(&self) -> &Arc<Stepping> {
        self.stepping.get_or_init(|| Arc::new(Stepping::new()))
    }

    pub(crate) fn state(&self) -> JobState {
        *self.state.borrow()
    }

    pub(crate) fn follow(&self) -> watch::Receiver<JobState> {
        self.state.subscribe()
    }

    /// Changes the record, then tells waiting channels.
    pub(crate) fn change(&self, change: impl FnOnce(&mut JobRecord)) -> JobRecord {
        let mut record = lock(&self.record);
        change(&mut record);
        self.state.send_if_modified(|state| std::mem::replace(state, record.state) != record.state);
        record.clone()
    }

    /// Looks at the record without a copy.
    pub(crate) fn peek<T>(&self, look: impl FnOnce(&JobRecord) -> T) -> T {
        look(&lock(&self.record))
    }

    pub(crate) fn run(&self) -> Option<Arc<PreparedRun>> {
        lock(&self.run).clone()
    }

    /// Forgets a run that the host failed or a pause has stopped; the job will be run again, and watchers stay at their
    /// cursors.
    pub(crate) fn forget_run(&self) {
        drop(self.end_log());
        self.tail().begin_again();
        *lock(&self.run) = None;
        lock(&self.limits).held = None;
        self.renew();
    }

    /// A request that was to end the last run does not end the next one.
    pub(super) fn renew(&self) {
        *lock(&self.stop) = StopSignal::default();
        self.desk().begin_again();
        if let Some(stepping) = self.stepping.get() {
            stepping.begin_again();
        }
    }

    /// Processor time of the threads of the run.
    pub(super) fn cpu(&self) -> Duration {
        self.run().map_or(Duration::ZERO, |run| run.control.cpu())
    }

    /// Whether the job is held back.
    pub(super) fn paused(&self) -> bool {
        lock(&self.record).paused
    }

    /// Sets the state of a prepared run; the job may have been cancelled by then.
    pub(crate) fn prepared(&self, run: PreparedRun) {
        lock(&self.limits).held = Some(held_by(&run.info));
        *lock(&self.run) = Some(Arc::new(run));
        if self.cancelled() || self.reached().is_some() {
            self.interrupt();
        }
    }

    /// The stop request of the run; exists before the run is prepared.
    pub(crate) fn stop(&self) -> StopSignal {
        lock(&self.stop).clone()
    }

    /// Lets others have the cores of the run until it is resumed.
    pub(super) fn suspend(&self, now: Instant) {
        lock(&self.limits).suspend(now);
        self.stop().suspend();
    }

    /// Lets a suspended run continue.
    pub(super) fn resume(&self, now: Instant) {
        lock(&self.limits).resume(now);
        self.stop().resume();
    }

    /// Bytes that the run may hold besides the values of macros.
    pub(super) fn held_bytes(&self) -> u64 {
        lock(&self.limits).held.unwrap_or(UNKNOWN)
    }

    /// Sets the limits of the run that begins now: running time, ms, and bytes of log and files; and the deadline of
    /// the job, ms since 1970, 0 = none.
    pub(crate) fn set_limits(&self, wall_ms: u64, bytes: u64, deadline_ms: i64) {
        let left = u64::try_from(deadline_ms.saturating_sub(now_ms())).unwrap_or(0);
        let deadline =
            (deadline_ms > 0).then(|| (Duration::from_millis(left), (ReachedLimit::Deadline, late(deadline_ms, None))));
        lock(&self.limits).begin(Instant::now(), Duration::from_millis(wall_ms), deadline, bytes);
    }

    /// The limit that has stopped the run.
    pub(crate) fn reached(&self) -> Option<Stopped> {
        lock(&self.limits).reached.clone()
    }

    /// Stops the run if its time is over.
    pub(crate) fn check_clock(&self, now: Instant) {
        let over = lock(&self.limits).over(now);
        let Some((reached, text)) = over else { return };
        let questions = self.desk_if_used().map(|desk| desk.questions()).unwrap_or_default();
        match (reached, questions.first()) {
            (ReachedLimit::Deadline, question @ Some(_)) => {
                let deadline = self.peek(|record| record.asked.deadline_ms);
                self.reach((reached, late(deadline, question)));
            }
            _ => self.reach((reached, text)),
        }
    }

    /// Limit `max_job_bytes` of the run.
    pub(crate) fn most_bytes(&self) -> u64 {
        lock(&self.limits).bytes.unwrap_or(u64::MAX)
    }

    /// Stops the run if its log or files have more bytes than allowed; `false` if so.
    pub(crate) fn check_bytes(&self, bytes: u64) -> bool {
        let most = self.most_bytes();
        if bytes > most {
            let text = format!(
                "the run was stopped after {most} bytes of log and files, its limit max_job_bytes: submit the job with a \
                 higher limit, or without a trace; the administrator sets the maximum of the server"
            );
            self.reach((ReachedLimit::MaxJobBytes, text));
        }
        bytes <= most
    }

    fn reach(&self, limit: Stopped) {
        let first = {
            let mut limits = lock(&self.limits);
            let first = limits.reached.is_none();
            limits.reached.get_or_insert(limit);
            first
        };
        if first {
            self.interrupt();
        }
    }

    /// Whether its run takes no processor time until a client acts: it is paused, or all its channels ask.
    pub(crate) fn waits_for_client(&self) -> bool {
        let channels = self.peek(|record| record.programs.len().max(1));
        let asks = |desk: &Arc<Desk>| desk.asking() >= channels;
        self.stepping.get().is_some_and(|stepping| stepping.waits_for_client()) || self.desk.get().is_some_and(asks)
    }

    pub(crate) fn cancelled(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// Asks the run to stop.
    pub(crate) fn cancel(&self) {
        self.cancel.store(true, Ordering::SeqCst);
        self.interrupt();
    }

    /// Stops the run without a cancel on the record: the job will be run again.
    pub(crate) fn interrupt(&self) {
        self.stop().ask();
        self.desk().close();
    }

    /// Whether the run is to end but the job continues later: a pause or the end of the server has stopped the run.
    pub(super) fn will_be_repeated(&self) -> bool {
        self.stop().asked() && !self.cancelled() && self.reached().is_none()
    }

    /// Hands the log over for the time of the run.
    pub(crate) fn begin_log(&self, writer: Writer) {
        *lock(&self.writer) = Some(writer);
    }

    /// Gives back its part of the memory budget.
    pub(super) fn give_back(&self) {
        drop(lock(&self.counted).taken.take());
    }

    /// Takes the log back.
    pub(crate) fn end_log(&self) -> Option<Writer> {
        lock(&self.writer).take()
    }

    /// Appends to the log of the running job. Returns whether a watcher waits for events that are neither written yet
    /// nor promised to it.
    pub(crate) fn append(&self, first_seq: u64, batch: &[Event]) -> io::Result<bool> {
        let mut writer = lock(&self.writer);
        let Some(log) = writer.as_mut() else { return Ok(false) };
        log.append(first_seq, batch)?;
        let (bytes, unwritten) = (log.bytes(), log.unwritten());
        drop(writer);
        self.check_bytes(bytes);
        Ok(unwritten && self.tail().followed() && !self.promised.swap(true, Ordering::SeqCst))
    }

    /// Whether events may have come that are not written yet.
    pub(crate) fn may_flush(&self) -> bool {
        self.writer.try_lock().map_or(true, |writer| writer.is_some())
    }

    /// Makes all events readable that the kernel has handed over. An error shows at the next append.
    pub(crate) fn flush(&self) {
        self.promised.store(false, Ordering::SeqCst);
        if let Some(writer) = lock(&self.writer).as_mut() {
            let _ = writer.flush();
        }
    }

    pub(crate) fn finished(&self) -> Option<&Arc<Finished>> {
        self.finished.get()
    }

    /// The log of a job that has ended, if it is small.
    pub(crate) fn small_log(&self) -> Option<StoredLog> {
        let log = self.finished.get().filter(|_| self.state().ended())?.log.clone();
        log.map(|log| StoredLog::in_ledger(&self.id, log))
    }

    pub(crate) fn keep(&self, finished: Arc<Finished>) {
        let _ = self.finished.set(finished);
    }
}
