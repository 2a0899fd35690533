//! The board: jobs in memory, which of them wait, run, or have ended lately, and the path from one to the next.
//!
//! Invariant: a job that has not ended is on the board, and is either in the queue or on a worker thread, until the
//! server drains.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dashmap::DashMap;
use tokio::sync::{Notify, watch};

use super::feed::Feed;
use super::limits::late;
use super::live::LiveJob;
use super::lock::lock;
use super::recent::Recent;
use super::tally::JobTally;
use super::{Core, worker};
use crate::clock::Clock;
use crate::ledger::record::{Cause, JobRecord, JobState, ReachedLimit, now_ms};
use crate::memory::MemoryBudget;
use crate::queue::{EnqueueReason, Queue, SchedulingState, Ticket};

/// First and longest pause before a job is run again after the host has failed its run.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// The queue, and places in it.
#[derive(Debug)]
pub(super) struct QueueState {
    pub(super) jobs: Box<dyn Queue>,
    /// Places given to submits whose ledger entry is in progress, by tenant.
    pub(super) reserved: HashMap<String, usize>,
    /// Jobs on workers that let others have their core.
    suspended: BTreeMap<String, Arc<LiveJob>>,
    /// Busy jobs whose marks say that they use no processor time.
    pub(super) idle: BTreeSet<String>,
    /// Cleared suspects that the ledger still holds as suspects.
    pub(super) cleared: Vec<String>,
}

/// Jobs in memory.
#[derive(Debug)]
pub(super) struct Board {
    pub(super) live: DashMap<String, Arc<LiveJob>>,
    pub(super) queue: Mutex<QueueState>,
    /// A reserved place was released.
    pub(super) released: Notify,
    recent: Mutex<Recent>,
    /// Jobs with a deadline that has not been reached, in its order.
    deadlines: Mutex<BTreeSet<(i64, String)>>,
    pub(super) feed: Feed,
    /// The waits for clients that followers of many jobs have seen or are notified of, by job: the start of each, ms
    /// since 1970.
    pub(super) shown_waits: Mutex<BTreeMap<String, i64>>,
    /// Memory of jobs here, of submits in progress and of answers not yet sent.
    pub(super) memory: Arc<MemoryBudget>,
    /// Jobs on worker threads.
    running: watch::Sender<usize>,
    pub(super) tally: JobTally,
    /// The time by which jobs end.
    pub(super) clock: Clock,
    /// When the jobs were last looked after.
    ticked: Mutex<Instant>,
}

/// The work of the workers.
pub(crate) struct Busy {
    pub(crate) running: Vec<Arc<LiveJob>>,
    pub(crate) storing: usize,
    pub(crate) queued: usize,
}

impl Board {
    pub(super) fn new(queue: Box<dyn Queue>, clock: Clock, epoch: u64, memory_bytes: u64) -> Self {
        Self {
            live: DashMap::new(),
            queue: Mutex::new(QueueState {
                jobs: queue,
                reserved: HashMap::new(),
                suspended: BTreeMap::new(),
                idle: BTreeSet::new(),
                cleared: Vec::new(),
            }),
            released: Notify::new(),
            recent: Mutex::default(),
            deadlines: Mutex::default(),
            feed: Feed::new(epoch),
            shown_waits: Mutex::default(),
            memory: MemoryBudget::new(memory_bytes),
            running: watch::Sender::new(0),
            tally: JobTally::default(),
            clock,
            ticked: Mutex::new(Instant::now()),
        }
    }

    /// Records that the jobs have been checked, and reports the events since.
    pub(super) fn ticked(&self) {
        *lock(&self.ticked) = Instant::now();
        self.tally.report();
    }
}

/// Why and with that where a job waits that no worker has had.
fn entry(live: &LiveJob) -> EnqueueReason {
    let mut entry = EnqueueReason::Accepted(Instant::now());
    live.peek(|record| match (record.paused, record.runs.suspect) {
        (true, _) => entry = EnqueueReason::Paused,
        (false, true) => entry = EnqueueReason::Suspect(time_alone(record.runs.crashes.at_work)),
        (false, false) => {}
    });
    entry
}

fn push(queue: &mut dyn Queue, live: &LiveJob, entry: EnqueueReason) {
    live.peek(|record| {
        let (tenant, priority) = (record.tenant.as_str(), record.asked.priority);
        queue.push(Ticket { id: &record.id, tenant, priority }, entry);
    });
}

impl Core {
    /// Takes up a job, once.
    pub(super) fn admit(&self, live: Arc<LiveJob>) {
        if self.enter(&live) {
            self.wait_in_queue(&live);
        }
    }

    /// Adds a job to those in memory; `false` if it is there.
    pub(super) fn enter(&self, live: &Arc<LiveJob>) -> bool {
        let mut new = false;
        self.board.live.entry(live.id.clone()).or_insert_with(|| {
            new = true;
            live.clone()
        });
        new
    }

    /// Lets a job that is in memory wait for its turn.
    pub(super) fn wait_in_queue(&self, live: &LiveJob) {
        self.mind_deadline(live);
        push(&mut *lock(&self.board.queue).jobs, live, entry(live));
        self.changed(live);
    }

    /// Has the job ended at its deadline if it has one and waits then.
    fn mind_deadline(&self, live: &LiveJob) {
        live.peek(|record| {
            if record.asked.deadline_ms > 0 {
                lock(&self.board.deadlines).insert((record.asked.deadline_ms, live.id.clone()));
            }
        });
    }

    /// Holds a job back that waits; `false` if it does not wait, or is to be cancelled.
    pub(super) fn hold(&self, live: &LiveJob) -> bool {
        let mut queue = lock(&self.board.queue);
        let held = !live.cancelled() && queue.jobs.remove(&live.id);
        if held {
            push(&mut *queue.jobs, live, EnqueueReason::Paused);
        }
        held
    }

    /// Lets a job that is held back wait for a worker.
    pub(super) fn release(self: &Arc<Self>, live: &LiveJob) {
        {
            let mut queue = lock(&self.board.queue);
            if queue.jobs.is_paused(&live.id) && queue.jobs.remove(&live.id) {
                live.renew();
                push(&mut *queue.jobs, live, entry(live));
            }
        }
        self.pump();
    }

    /// Tells those who follow many jobs that one has changed.
    pub(super) fn changed(&self, live: &LiveJob) {
        live.peek(|record| self.board.feed.changed(&record.tenant, &record.id));
    }

    /// Divides the workers among the tenants, and starts waiting jobs while there are disk space and a ledger.
    pub(super) fn pump(self: &Arc<Self>) {
        while let Some(live) = self.take() {
            worker::start(self.clone(), live);
        }
    }

    /// Suspends and resumes runs; the next job, if a worker is to have one and there are disk space and a ledger.
    pub(super) fn take(&self) -> Option<Arc<LiveJob>> {
        let waits = lock(&self.board.queue).jobs.waiting() > 0;
        self.next(waits && *self.ledger.writable().borrow() && self.room().is_ok())
    }

    fn next(&self, starts: bool) -> Option<Arc<LiveJob>> {
        let mut queue = lock(&self.board.queue);
        let starts = starts && !self.drain.begun();
        let waits_for_client = |id: &str| self.live(id).is_some_and(|live| live.waits_for_client());
        loop {
            let (room, now) = (self.has_memory(&queue), Instant::now());
            let id = queue.jobs.next(&SchedulingState {
                slots: self.options.slots(),
                starts,
                room,
                now,
                waits_for_client: &waits_for_client,
            });
            self.share_cores(&mut queue);
            let id = id?;
            if let Some(live) = self.live(&id) {
                self.board.running.send_replace(queue.jobs.busy_count());
                return Some(live);
            }
            queue.jobs.free(&id, now);
        }
    }

    /// Whether there is memory for runs beyond twice `workers`.
    fn has_memory(&self, queue: &QueueState) -> bool {
        let most = self.options.maxima.memory_bytes;
        if most == 0 || queue.jobs.workers() < self.options.slots().saturating_mul(2) {
            return true;
        }
        let runs = queue.jobs.running();
        let held = runs.iter().filter_map(|id| self.live(id)).map(|live| live.held_bytes());
        held.fold(0, u64::saturating_add) < most
    }

    /// Threads for the kernels of a job whose run begins now, of which as many were `asked` for (0 = all): its share of
    /// the cores. A job alone gets them all; one thread is enough where more jobs wait than cores are free.
    pub(super) fn threads(&self, asked: u16) -> u16 {
        let cores = crate::cpu::cores();
        let jobs = {
            let queue = lock(&self.board.queue);
            queue.jobs.workers() + queue.jobs.waiting()
        };
        let share = u16::try_from(cores / jobs.max(1)).unwrap_or(u16::MAX).max(1);
        if asked == 0 { share } else { asked.min(share) }
    }

    /// The run is over and only its storage is left, which needs no core: the next job may run meanwhile. The caller
    /// takes it.
    pub(super) fn leave(&self, live: &LiveJob) {
        let mut queue = lock(&self.board.queue);
        queue.jobs.store(&live.id, Instant::now());
        self.share_cores(&mut queue);
    }

    /// Suspends and resumes jobs as the queue wants it.
    fn share_cores(&self, queue: &mut QueueState) {
        let (wanted, now) = (queue.jobs.suspended(), Instant::now());
        queue.suspended.retain(|id, live| {
            let stays = wanted.contains(id);
            if !stays {
                live.resume(now);
            }
            stays
        });
        for id in wanted {
            let Some(live) = self.live(&id).filter(|_| !queue.suspended.contains_key(&id)) else { continue };
            live.suspend(now);
            self.metrics.jobs.suspended.inc();
            queue.suspended.insert(id, live);
        }
        self.mark_working(queue);
        self.clear(queue);
    }

    /// Removes an ended job from memory.
    pub(super) fn drop_ended(&self, id: &str) {
        lock(&self.board.queue).jobs.forget(id);
        self.board.live.remove(id);
    }

    /// A worker is free again: the job has ended, or the drain has interrupted it.
    pub(super) fn free(self: &Arc<Self>, live: &LiveJob) {
        {
            let mut queue = lock(&self.board.queue);
            queue.jobs.free(&live.id, Instant::now());
            queue.jobs.forget(&live.id);
            self.share_cores(&mut queue);
            self.host.unmark(&live.id);
            self.board.running.send_replace(queue.jobs.busy_count());
        }
        self.changed(live);
        // Ended jobs that stay in memory have bounds of their own.
        live.give_back();
        let bytes = live.finished().map_or(0, |finished| finished.bytes);
        let gone = lock(&self.board.recent).push(live.id.clone(), bytes, self.options.embedded.ephemeral);
        for gone in gone {
            self.board.live.remove_if(&gone, |_, live| live.state().ended());
        }
        self.pump();
    }

    /// A worker is free again: the host has failed the run for the `failures`th time, and the job waits for the next.
    pub(super) fn again(&self, live: &LiveJob, failures: u32) {
        self.back(live, FIRST_PAUSE.saturating_mul(1 << failures.saturating_sub(1).min(16)).min(LONGEST_PAUSE));
    }

    /// A worker is free again: the run was dropped and its job is held back, if it still is to be.
    pub(super) fn aside(self: &Arc<Self>, live: &LiveJob) {
        self.mind_deadline(live);
        self.back(live, Duration::ZERO);
        self.pump();
    }

    /// Takes a job from its worker and lets it wait for the next run until the pause is over, or held back.
    fn back(&self, live: &LiveJob, pause: Duration) {
        {
            let (mut queue, now) = (lock(&self.board.queue), Instant::now());
            queue.jobs.free(&live.id, now);
            self.share_cores(&mut queue);
            self.host.unmark(&live.id);
            // A cancel comes after the job left the queue, or finds it there.
            let entry = if live.paused() && !live.cancelled() {
                EnqueueReason::Paused
            } else {
                EnqueueReason::Again(now + pause)
            };
            push(&mut *queue.jobs, live, entry);
            self.board.running.send_replace(queue.jobs.busy_count());
        }
        self.changed(live);
    }

    /// Stops runs that have reached their limit by the clock, and jobs whose deadline is over before they run.
    pub(super) fn stop_late_jobs(self: &Arc<Self>) {
        let now = Instant::now();
        let running = lock(&self.board.queue).jobs.running();
        running.iter().filter_map(|id| self.live(id)).for_each(|live| live.check_clock(now));
        let mut late = Vec::new();
        {
            let mut deadlines = lock(&self.board.deadlines);
            while let Some((deadline, id)) = deadlines.pop_first() {
                if deadline > now_ms() {
                    deadlines.insert((deadline, id));
                    break;
                }
                late.push((deadline, id));
            }
        }
        for (deadline, id) in late {
            // A job on a worker is stopped as a limit of its run.
            if let Some(live) = self.live(&id).filter(|_| self.withdraw(&id)) {
                self.end_late(&live, deadline);
            }
        }
    }

    /// Ends a job that has been withdrawn, because its deadline is over.
    fn end_late(self: &Arc<Self>, live: &Arc<LiveJob>, deadline: i64) {
        let record = live.record();
        let mut ended = JobRecord { state: JobState::Failed, paused: false, ..record };
        ended.end(&self.board.clock);
        ended.runs.limit = late(deadline, None);
        (ended.runs.cause, ended.runs.reached) = (Some(Cause::Limit), Some(ReachedLimit::Deadline));
        // The verdict is that of a started job, so that the answer does not depend on timing.
        ended.verdict.clone_from(&ended.runs.limit);
        if let Err(error) = self.ledger.update_blocking(vec![ended.clone()]) {
            tracing::debug!(%error, "a job beyond its deadline is ended later");
            self.put_back(live);
            lock(&self.board.deadlines).insert((deadline, live.id.clone()));
            return;
        }
        self.ended(&ended);
        live.change(|record| *record = ended);
        self.changed(live);
        self.drop_ended(&live.id);
    }

    /// Number of jobs in memory, which wait or run.
    pub(crate) fn unfinished_jobs(&self) -> usize {
        self.board.live.len()
    }

    /// Whether the jobs were looked after within this time.
    pub(crate) fn ticks_within(&self, time: Duration) -> bool {
        lock(&self.board.ticked).elapsed() <= time
    }

    /// The current work of the workers.
    pub(crate) fn workers(&self) -> Busy {
        let (ids, busy, queued) = {
            let queue = lock(&self.board.queue);
            (queue.jobs.running(), queue.jobs.busy_count(), queue.jobs.len())
        };
        let storing = busy.saturating_sub(ids.len());
        Busy { running: ids.iter().filter_map(|id| self.live(id)).collect(), storing, queued }
    }

    /// Number of running jobs, to be followed.
    pub(crate) fn running(&self) -> watch::Receiver<usize> {
        self.board.running.subscribe()
    }

    /// Jobs that run or whose end is being stored.
    pub(crate) fn busy(&self) -> BTreeSet<String> {
        lock(&self.board.queue).jobs.busy()
    }

    /// Jobs of a tenant that are held back.
    pub(crate) fn held_back(&self, tenant: &str) -> BTreeSet<String> {
        let held = |live: &LiveJob| live.peek(|record| record.tenant == tenant && record.paused);
        self.board.live.iter().filter(|live| held(live)).map(|live| live.id.clone()).collect()
    }

    /// Whether jobs of other tenants take processor time, or wait for it.
    pub(crate) fn others_work(&self, tenant: &str) -> bool {
        let running = lock(&self.board.queue).jobs.running();
        let stand: BTreeSet<String> =
            running.into_iter().filter(|id| self.live(id).is_some_and(|live| live.waits_for_client())).collect();
        lock(&self.board.queue).jobs.others_work(tenant, &|id| stand.contains(id))
    }

    /// Interrupts all running jobs; they are queued again in the ledger.
    pub(crate) fn interrupt(&self) {
        self.board.live.iter().filter(|live| live.state() == JobState::Running).for_each(|live| live.interrupt());
    }

    /// Jobs that are likely to run before this one.
    pub(crate) fn queued_before(&self, id: &str) -> usize {
        lock(&self.board.queue).jobs.before(id)
    }

    /// Takes a job out of the queue; `false` if it does not wait there.
    pub(super) fn withdraw(&self, id: &str) -> bool {
        lock(&self.board.queue).jobs.remove(id)
    }

    /// Lets a job wait again that was withdrawn.
    pub(super) fn put_back(&self, live: &LiveJob) {
        let entry = if live.paused() { EnqueueReason::Paused } else { EnqueueReason::Again(Instant::now()) };
        push(&mut *lock(&self.board.queue).jobs, live, entry);
    }
}

/// Time for which a suspect runs alone after one crash. Each further crash doubles the time, so that a job that crashes
/// the server late in its run is also found.
const ALONE: Duration = Duration::from_secs(5);

/// Maximum number of doublings. It bounds the time for which other jobs wait.
const MOST_DOUBLINGS: u32 = 2;

/// Time for which a suspect runs alone after `crashes` crashes during its work.
pub(super) fn time_alone(crashes: u32) -> Duration {
    ALONE * (1 << crashes.saturating_sub(1).min(MOST_DOUBLINGS))
}
