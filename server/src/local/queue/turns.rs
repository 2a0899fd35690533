//! Turns of tenants: which runs use the slots, and which job starts next.
//!
//! Each tenant has an account of its used worker time; the tenant with the least is next. If no slot is free, the
//! tenant that has used the most gives a slot: its run that started last is suspended, once the run has had a slice.
//! An idle run (`waits_for_client`) uses no slot; it is not suspended, and delays only jobs of its own tenant.
//!
//! *Invariants:* a tenant without competitors loses no slot; of the suspended runs of a tenant, the run that started
//! first continues; a tenant with a suspended run starts no job; a new tenant starts with at least the lowest account.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::LocalQueue;
use super::line::TenantQueue;
use crate::queue::SchedulingState;

/// Time for which a run keeps its slot when other tenants wait. Checked at every tick, submit and end.
const SLICE: Duration = Duration::from_millis(25);
/// Limit by which an account can exceed the lowest account. A tenant waits at most this time for a new tenant.
const MOST_AHEAD: Duration = Duration::from_millis(500);

/// A job on a worker.
#[derive(Debug)]
pub(super) struct WorkerRun {
    pub(super) id: String,
    pub(super) tenant: Arc<str>,
    /// Sequence number of the start.
    start: u64,
    /// Time of the last charge.
    charged: Instant,
    /// Time with a slot since the run started or was resumed.
    slice: Duration,
    pub(super) suspended: bool,
    /// Whether the run used no processor time at the last look.
    pub(super) waits_for_client: bool,
}

impl WorkerRun {
    pub(super) fn new(id: String, tenant: Arc<str>, start: u64, now: Instant) -> Self {
        Self { id, tenant, start, charged: now, slice: Duration::ZERO, suspended: false, waits_for_client: false }
    }

    /// Whether the run uses a slot.
    pub(super) fn works(&self) -> bool {
        !self.suspended && !self.waits_for_client
    }

    /// Time with a slot that has not been charged yet.
    pub(super) fn uncharged(&self, now: Instant) -> Duration {
        if self.works() { now.saturating_duration_since(self.charged) } else { Duration::ZERO }
    }
}

/// Rank of a tenant for its next slot, lowest first: its used time plus a slice for each of its slots; then the numbers
/// of its last turn and of its arrival.
type Rank = (Duration, u64, u64);

/// Work that can get a slot.
enum SlotCandidate {
    /// The first job of a tenant starts.
    Start(Arc<str>),
    /// The run at this index is resumed.
    Resume(usize),
}

impl LocalQueue {
    /// Gives a tenant its turn; returns the number of the turn.
    pub(super) fn turn_of(&mut self, tenant: &Arc<str>) -> u64 {
        self.last_number += 1;
        let turn = self.last_number;
        self.line(tenant).turn = turn;
        turn
    }

    /// Charges the time since the last look, and limits the difference between the accounts.
    pub(super) fn charge(&mut self, look: &SchedulingState<'_>) {
        for run in &mut self.running {
            run.waits_for_client = (look.waits_for_client)(&run.id);
            run.suspended &= !run.waits_for_client;
            let time = run.uncharged(look.now);
            run.charged = look.now;
            run.slice = if run.waits_for_client { Duration::ZERO } else { run.slice + time };
            if let Some(line) = self.lines.get_mut(&run.tenant) {
                line.used += time;
            }
        }
        let works = |tenant: &Arc<str>| self.running.iter().any(|run| run.tenant == *tenant && !run.waits_for_client);
        let contend = self.lines.iter().filter(|(tenant, line)| works(tenant) || self.is_ready(tenant, line, look));
        let Some(lowest) = contend.map(|(_, line)| line.used).min() else { return };
        self.floor = self.floor.max(lowest);
        let floor = self.floor;
        for line in self.lines.values_mut() {
            line.used = line.used.clamp(floor, floor + MOST_AHEAD);
        }
        self.lines.retain(|_, line| !line.is_unneeded(floor));
    }

    /// Whether a tenant has a job whose start its own runs do not prevent.
    fn is_ready(&self, tenant: &Arc<str>, line: &TenantQueue, look: &SchedulingState<'_>) -> bool {
        (line.len() > 0 || self.due(tenant, look.now).is_some()) && self.may_start(tenant, look.slots)
    }

    /// Assigns free slots, and moves slots from the tenants that have used the most to those that have used the least.
    /// Returns the job that starts, if any.
    pub(super) fn divide(&mut self, look: &SchedulingState<'_>) -> Option<String> {
        loop {
            let working = self.running.iter().filter(|run| run.works()).count();
            if working > look.slots {
                // An idle run has become active again.
                let most = self.most(|_, _| true)?;
                self.suspend(most);
                continue;
            }
            let (rank, next) = self.next_work(look)?;
            if working == look.slots {
                let tenant = match &next {
                    SlotCandidate::Start(tenant) => tenant.clone(),
                    SlotCandidate::Resume(at) => self.running.get(*at)?.tenant.clone(),
                };
                let gives =
                    |run: &WorkerRun, keeps: Rank| run.slice >= SLICE && run.tenant != tenant && keeps.0 > rank.0;
                let most = self.most(gives)?;
                self.suspend(most);
            }
            match next {
                SlotCandidate::Start(tenant) => {
                    let id = self.first(&tenant, look.now)?;
                    return Some(self.begin(id, tenant, look.now));
                }
                SlotCandidate::Resume(at) => self.resume(at, look.now),
            }
        }
    }

    /// The next work, with the rank of its tenant.
    fn next_work(&self, look: &SchedulingState<'_>) -> Option<(Rank, SlotCandidate)> {
        let room = look.starts && (self.running.len() < look.slots.saturating_mul(2) || look.room);
        let ready = self.lines.iter().filter(|(tenant, line)| room && self.is_ready(tenant, line, look));
        let start = ready.filter_map(|(tenant, _)| Some((self.rank(tenant, 0)?, tenant)));
        let start = start.min().map(|(rank, tenant)| (rank, SlotCandidate::Start(tenant.clone())));
        let suspended = self.running.iter().enumerate().filter(|(_, run)| run.suspended);
        let resume = suspended.filter_map(|(at, run)| Some((self.rank(&run.tenant, 0)?, run.start, at)));
        let resume = resume.min().map(|(rank, _, at)| (rank, SlotCandidate::Resume(at)));
        start.into_iter().chain(resume).min_by_key(|(rank, _)| *rank)
    }

    /// Whether the runs of a tenant permit the start of another job.
    fn may_start(&self, tenant: &Arc<str>, slots: usize) -> bool {
        let mut own = self.running.iter().filter(|run| run.tenant == *tenant);
        own.clone().count() < slots && self.may_run(tenant) && !own.any(|run| run.suspended)
    }

    /// The rank of a tenant, counted without `without` of its slots.
    fn rank(&self, tenant: &Arc<str>, without: u32) -> Option<Rank> {
        let line = self.lines.get(tenant)?;
        let slots = self.running.iter().filter(|run| run.tenant == *tenant && run.works()).count();
        let slots = u32::try_from(slots).unwrap_or(u32::MAX).saturating_sub(without);
        Some((line.used + SLICE.saturating_mul(slots), line.turn, line.came))
    }

    /// The run that gives its slot: the last started run of the tenant that has used the most. `gives` filters the
    /// runs; its second argument is the rank of the tenant without this slot.
    fn most(&self, gives: impl Fn(&WorkerRun, Rank) -> bool) -> Option<usize> {
        let is_last = |run: &WorkerRun| {
            let mut own = self.running.iter().filter(|other| other.tenant == run.tenant && other.works());
            own.all(|other| other.start <= run.start)
        };
        let last = self.running.iter().enumerate().filter(|(_, run)| run.works() && is_last(run));
        let ranked = last.filter_map(|(at, run)| Some((self.rank(&run.tenant, 1)?, at, run)));
        let giving = ranked.filter(|(rank, _, run)| gives(run, *rank));
        giving.max_by_key(|(rank, _, _)| *rank).map(|(_, at, _)| at)
    }

    fn suspend(&mut self, at: usize) {
        if let Some(run) = self.running.get_mut(at) {
            run.suspended = true;
        }
    }

    fn resume(&mut self, at: usize, now: Instant) {
        let Some(run) = self.running.get_mut(at) else { return };
        (run.suspended, run.slice, run.charged) = (false, Duration::ZERO, now);
        let tenant = run.tenant.clone();
        self.turn_of(&tenant);
    }
}
