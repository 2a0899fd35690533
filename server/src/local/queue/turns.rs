//! Turns of tenants: whose run uses a slot, and whose job starts next.
//!
//! Each tenant has an account of the worker time that it has used; the tenant with the least is next. If no slot is
//! free, the tenant that has used the most gives one: its run that started last is suspended, once it has had a slice.
//! A run that stands uses no slot; it is not suspended, and delays only jobs of its own tenant. Invariants: a tenant
//! alone loses no slot; of the runs of a tenant the one that started first continues, and the tenant starts no job
//! while it has a suspended run; a tenant that comes has used no less than the others.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::LocalQueue;
use crate::queue::Look;

/// Time that a run has a slot in any case. The server looks at it at every tick, submit and end.
const SLICE: Duration = Duration::from_millis(25);
/// Most that an account can be ahead of the lowest: so long a tenant may have to wait for one that comes.
const MOST_AHEAD: Duration = Duration::from_millis(500);

/// A job on a worker.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) id: String,
    pub(super) tenant: Arc<str>,
    /// The number of its start.
    start: u64,
    /// When its time was last charged.
    charged: Instant,
    /// Time that it has had a slot since it started or was resumed.
    slice: Duration,
    pub(super) suspended: bool,
    /// It used no processor time at the last look.
    stands: bool,
}

impl Run {
    pub(super) fn new(id: String, tenant: Arc<str>, start: u64, now: Instant) -> Self {
        Self { id, tenant, start, charged: now, slice: Duration::ZERO, suspended: false, stands: false }
    }

    /// Whether it uses a slot.
    fn works(&self) -> bool {
        !self.suspended && !self.stands
    }

    /// Time with a slot that is not charged yet.
    pub(super) fn uncharged(&self, now: Instant) -> Duration {
        if self.works() { now.saturating_duration_since(self.charged) } else { Duration::ZERO }
    }
}

/// Rank of a tenant for its next slot, the lowest first: the time that it has used, with a slice for each slot that it
/// has; then the number of its last turn, and that of its arrival.
type Rank = (Duration, u64, u64);

/// Work that can get a slot.
enum Next {
    /// The first job of a tenant starts.
    Start(Arc<str>),
    /// The run in this place is resumed.
    Resume(usize),
}

impl LocalQueue {
    /// The number of a turn that a tenant has now.
    pub(super) fn turn_of(&mut self, tenant: &Arc<str>) -> u64 {
        self.last_number += 1;
        let turn = self.last_number;
        self.line(tenant).turn = turn;
        turn
    }

    /// Charges the time since the last look, and brings the accounts closer together.
    pub(super) fn charge(&mut self, look: &Look<'_>) {
        for run in &mut self.running {
            run.stands = (look.stands)(&run.id);
            run.suspended &= !run.stands;
            let time = run.uncharged(look.now);
            run.charged = look.now;
            run.slice = if run.stands { Duration::ZERO } else { run.slice + time };
            if let Some(line) = self.lines.get_mut(&run.tenant) {
                line.used += time;
            }
        }
        let ready = self.ready(look);
        let works = |tenant: &Arc<str>| self.running.iter().any(|run| run.tenant == *tenant && !run.stands);
        let contend = self.lines.iter().filter(|(tenant, _)| works(tenant) || ready.contains(*tenant));
        let Some(lowest) = contend.map(|(_, line)| line.used).min() else { return };
        self.floor = self.floor.max(lowest);
        let floor = self.floor;
        for line in self.lines.values_mut() {
            line.used = line.used.clamp(floor, floor + MOST_AHEAD);
        }
        self.lines.retain(|_, line| !line.is_unneeded(floor));
    }

    /// Tenants with a job that may start now, as far as their own runs are concerned.
    fn ready(&self, look: &Look<'_>) -> HashSet<Arc<str>> {
        let due = self.again.iter().filter(|(at, _, _)| *at <= look.now).map(|(_, _, tenant)| tenant);
        let waiting = self.lines.iter().filter(|(_, line)| line.len() > 0).map(|(tenant, _)| tenant);
        let tenants: HashSet<&Arc<str>> = due.chain(waiting).collect();
        tenants.into_iter().filter(|tenant| self.may_start(tenant, look.slots)).cloned().collect()
    }

    /// Gives free slots away, and slots of tenants that have used the most to those that have used the least. Returns
    /// the job that starts, if there is one.
    pub(super) fn divide(&mut self, look: &Look<'_>) -> Option<String> {
        loop {
            let working = self.running.iter().filter(|run| run.works()).count();
            if working > look.slots {
                // A run that stood works again.
                let most = self.most(|_, _| true)?;
                self.suspend(most);
                continue;
            }
            let (rank, next) = self.next_work(look)?;
            if working == look.slots {
                let tenant = match &next {
                    Next::Start(tenant) => tenant.clone(),
                    Next::Resume(at) => self.running.get(*at)?.tenant.clone(),
                };
                let gives = |run: &Run, keeps: Rank| run.slice >= SLICE && run.tenant != tenant && keeps.0 > rank.0;
                let most = self.most(gives)?;
                self.suspend(most);
            }
            match next {
                Next::Start(tenant) => {
                    let id = self.first(&tenant, look.now)?;
                    return Some(self.begin(id, tenant, look.now));
                }
                Next::Resume(at) => self.resume(at, look.now),
            }
        }
    }

    /// The work whose turn it is, with the rank of its tenant.
    fn next_work(&self, look: &Look<'_>) -> Option<(Rank, Next)> {
        let room = look.starts && (self.running.len() < look.slots.saturating_mul(2) || look.room);
        let ready = if room { self.ready(look) } else { HashSet::new() };
        let start = ready.into_iter().filter_map(|tenant| Some((self.rank(&tenant, 0)?, Next::Start(tenant))));
        let start = start.min_by_key(|(rank, _)| *rank);
        let suspended = self.running.iter().enumerate().filter(|(_, run)| run.suspended);
        let resume = suspended.filter_map(|(at, run)| Some((self.rank(&run.tenant, 0)?, run.start, at)));
        let resume = resume.min().map(|(rank, _, at)| (rank, Next::Resume(at)));
        start.into_iter().chain(resume).min_by_key(|(rank, _)| *rank)
    }

    /// Whether a tenant may start another job, as far as its own runs are concerned.
    fn may_start(&self, tenant: &Arc<str>, slots: usize) -> bool {
        let mut own = self.running.iter().filter(|run| run.tenant == *tenant);
        own.clone().count() < slots && self.may_run(tenant) && !own.any(|run| run.suspended)
    }

    /// The rank of a tenant, without so many of its slots.
    fn rank(&self, tenant: &Arc<str>, without: u32) -> Option<Rank> {
        let line = self.lines.get(tenant)?;
        let slots = self.running.iter().filter(|run| run.tenant == *tenant && run.works()).count();
        let slots = u32::try_from(slots).unwrap_or(u32::MAX).saturating_sub(without);
        Some((line.used + SLICE.saturating_mul(slots), line.turn, line.came))
    }

    /// The run that gives its slot: of the tenant that has used the most, the one that started last. `gives` gets the
    /// rank that its tenant has without this slot.
    fn most(&self, gives: impl Fn(&Run, Rank) -> bool) -> Option<usize> {
        let is_last = |run: &Run| {
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
