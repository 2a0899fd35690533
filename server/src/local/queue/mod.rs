//! The queue in memory: a server that starts fills it from its ledger.
//!
//! `turns` decides whose turn it is, and `suspects` which jobs run alone. Invariant: a question about a job's place
//! costs the logarithm of the line's length, and one step per tenant.

mod line;
mod places;
mod suspects;
mod turns;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::queue::{EnqueueReason, Queue, SchedulingState, TenantWorkers, Ticket};
use line::{QueuePosition, TenantQueue, class};
use suspects::Suspects;
use turns::WorkerRun;

/// Most jobs whose end is being stored while others have their workers.
const MOST_STORING: usize = 64;
/// Time for which the end of a job is stored before its run counts as idle. Most ends take less.
const LONG_STORED: Duration = Duration::from_millis(50);
/// Jobs that wait, and who has a place.
#[derive(Debug, Default)]
pub(crate) struct LocalQueue {
    /// Jobs that were running when the server before this one died: they run alone at first.
    suspects: Suspects,
    /// Jobs whose run the host failed, and when they may be run again.
    again: Vec<(Instant, String, Arc<str>)>,
    /// Jobs that are held back.
    paused: BTreeMap<String, Arc<str>>,
    lines: HashMap<Arc<str>, TenantQueue>,
    /// Jobs in lines.
    spots: HashMap<String, (Arc<str>, QueuePosition)>,
    last_ordinal: u64,
    /// Most jobs of one tenant on workers, and of tenants for which that is another number; 0 = without limit.
    most_running: usize,
    own_running: HashMap<String, usize>,
    running: Vec<WorkerRun>,
    /// Initial account of a new tenant: no tenant that takes turns has used less.
    floor: Duration,
    /// Number of the last turn or arrival.
    last_number: u64,
    /// Jobs whose run is over and whose end is being stored.
    storing: BTreeMap<String, Instant>,
    /// Time of the last look at the queue.
    looked: Option<Instant>,
}

impl LocalQueue {
    /// The name of a tenant as it is kept.
    fn tenant(&self, tenant: &str) -> Arc<str> {
        self.lines.get_key_value(tenant).map_or_else(|| tenant.into(), |(name, _)| name.clone())
    }

    fn line(&mut self, tenant: &Arc<str>) -> &mut TenantQueue {
        let Self { lines, floor, last_number, .. } = self;
        lines.entry(tenant.clone()).or_insert_with(|| {
            *last_number += 1;
            TenantQueue::new(*floor, *last_number)
        })
    }

    /// Drops an unneeded line.
    fn tidy(&mut self, tenant: &Arc<str>) {
        if self.lines.get(tenant).is_some_and(|line| line.is_unneeded(self.floor)) {
            self.lines.remove(tenant);
        }
    }

    /// Takes a job out of its line.
    fn take(&mut self, tenant: &Arc<str>, spot: QueuePosition) -> Option<String> {
        let id = self.lines.get_mut(tenant)?.remove(spot)?;
        self.spots.remove(&id);
        Some(id)
    }

    /// The jobs of [`Queue::idle`], each once.
    fn idle_jobs(&self) -> impl Iterator<Item = &String> {
        let idle = self.running.iter().filter(|run| !run.works());
        let looked = self.looked;
        let late =
            move |since: &Instant| looked.is_some_and(|now| now.saturating_duration_since(*since) >= LONG_STORED);
        let stored = self.storing.iter().filter(move |(_, since)| late(since));
        idle.map(|run| &run.id).chain(stored.map(|(id, _)| id))
    }

    /// Whether a tenant may have another worker.
    fn may_run(&self, tenant: &Arc<str>) -> bool {
        let most = self.own_running.get(&**tenant).copied().unwrap_or(self.most_running);
        most == 0 || self.lines.get(tenant).is_none_or(|line| line.running < most)
    }

    /// Index in `again` of a job of a tenant that is due.
    fn due(&self, tenant: &str, now: Instant) -> Option<usize> {
        self.again.iter().position(|(at, _, of)| *at <= now && **of == *tenant)
    }

    /// Takes the first job of a tenant.
    fn first(&mut self, tenant: &Arc<str>, now: Instant) -> Option<String> {
        if let Some(due) = self.due(tenant, now) {
            return Some(self.again.remove(due).1);
        }
        let spot = self.lines.get(tenant)?.first(now)?;
        self.take(tenant, spot)
    }

    fn begin(&mut self, id: String, tenant: Arc<str>, now: Instant) -> String {
        let turn = self.turn_of(&tenant);
        let line = self.line(&tenant);
        line.held = line.held.saturating_sub(1);
        line.running += 1;
        self.running.push(WorkerRun::new(id.clone(), tenant, turn, now));
        id
    }
}

impl Queue for LocalQueue {
    fn let_run(&mut self, most: usize, own: HashMap<String, usize>) {
        (self.most_running, self.own_running) = (most, own);
    }

    fn len(&self) -> usize {
        self.waiting() + self.paused.len()
    }

    fn waiting(&self) -> usize {
        self.suspects.len() + self.again.len() + self.spots.len()
    }

    fn is_paused(&self, id: &str) -> bool {
        self.paused.contains_key(id)
    }

    fn waiting_of(&self, tenant: &str) -> usize {
        self.lines.get(tenant).map_or(0, |line| line.held)
    }

    fn others_work(&self, tenant: &str, waits_for_client: &dyn Fn(&str) -> bool) -> bool {
        let others_wait = self.lines.iter().any(|(other, line)| **other != *tenant && line.len() > 0);
        let mut runs = self.running.iter().filter(|run| others_wait || *run.tenant != *tenant);
        runs.any(|run| !waits_for_client(&run.id))
    }

    fn push(&mut self, ticket: Ticket<'_>, entry: EnqueueReason) {
        let (id, tenant) = (ticket.id.to_owned(), self.tenant(ticket.tenant));
        self.line(&tenant).held += 1;
        if let EnqueueReason::Suspect(alone) = entry {
            self.suspects.suspect(&id, alone);
        }
        match entry {
            EnqueueReason::Suspect(_) => self.suspects.push(id, tenant, None),
            EnqueueReason::Again(at) if self.suspects.contains(&id) => self.suspects.push(id, tenant, Some(at)),
            EnqueueReason::Again(at) => self.again.push((at, id, tenant)),
            EnqueueReason::Paused => drop(self.paused.insert(id, tenant)),
            EnqueueReason::Accepted(since) => {
                self.last_ordinal += 1;
                let spot = QueuePosition { class: class(ticket.priority), ordinal: self.last_ordinal };
                self.line(&tenant).push(spot, id.clone(), since);
                self.spots.insert(id, (tenant, spot));
            }
        }
    }

    fn next(&mut self, look: &SchedulingState<'_>) -> Option<String> {
        self.charge(look);
        self.looked = Some(look.now);
        match self.next_suspect(look) {
            Some(id) => Some(id),
            None if self.suspects.runs_alone() => None,
            None => self.divide(look),
        }
    }

    fn store(&mut self, id: &str, now: Instant) {
        if self.storing.len() < MOST_STORING {
            self.free(id, now);
            self.storing.insert(id.to_owned(), now);
        }
    }

    fn free(&mut self, id: &str, now: Instant) {
        self.storing.remove(id);
        let Some(at) = self.running.iter().position(|run| run.id == id) else { return };
        let run = self.running.swap_remove(at);
        self.suspects.stop(id, now);
        let line = self.line(&run.tenant);
        line.running = line.running.saturating_sub(1);
        line.used += run.uncharged(now);
        self.tidy(&run.tenant);
    }

    fn remove(&mut self, id: &str) -> bool {
        let tenant = if let Some((tenant, spot)) = self.spots.get(id).cloned() {
            self.take(&tenant, spot);
            tenant
        } else if let Some(tenant) = self.suspects.remove(id) {
            tenant
        } else if let Some(at) = self.again.iter().position(|(_, waiting, _)| waiting == id) {
            self.again.remove(at).2
        } else if let Some(tenant) = self.paused.remove(id) {
            tenant
        } else {
            return false;
        };
        let line = self.line(&tenant);
        line.held = line.held.saturating_sub(1);
        self.tidy(&tenant);
        true
    }

    fn forget(&mut self, id: &str) {
        self.suspects.forget(id);
    }

    fn take_cleared(&mut self) -> Vec<String> {
        self.suspects.take_cleared()
    }

    fn alone(&self) -> Option<&str> {
        self.suspects.alone()
    }

    fn before(&self, id: &str) -> usize {
        if let Some((tenant, spot)) = self.spots.get(id) {
            let own = self.lines.get(tenant).map_or(0, |line| line.before(*spot));
            // The other tenants have had about as many turns by then.
            let others = self.lines.iter().filter(|(other, _)| *other != tenant);
            let others: usize = others.map(|(_, line)| line.len().min(own + 1)).sum();
            return self.suspects.len() + self.again.len() + own + others;
        }
        let again = || self.again.iter().position(|(_, waiting, _)| waiting == id);
        self.suspects.before(id).or_else(|| again().map(|at| self.suspects.len() + at)).unwrap_or(0)
    }

    fn running(&self) -> Vec<String> {
        self.running.iter().map(|run| run.id.clone()).collect()
    }

    fn suspended(&self) -> BTreeSet<String> {
        self.running.iter().filter(|run| run.suspended).map(|run| run.id.clone()).collect()
    }

    fn idle(&self) -> BTreeSet<String> {
        self.idle_jobs().cloned().collect()
    }

    fn are_idle(&self, jobs: &BTreeSet<String>) -> bool {
        let mut count = 0;
        self.idle_jobs().inspect(|_| count += 1).all(|id| jobs.contains(id)) && count == jobs.len()
    }

    fn on_workers(&self, tenant: &str) -> TenantWorkers {
        let own = || self.running.iter().filter(|run| *run.tenant == *tenant);
        TenantWorkers {
            running: own().count(),
            waiting_for_client: own().filter(|run| run.waits_for_client).count(),
            quota: self.own_running.get(tenant).copied().unwrap_or(self.most_running),
        }
    }

    fn workers(&self) -> usize {
        self.running.len()
    }

    fn busy(&self) -> BTreeSet<String> {
        self.running.iter().map(|run| run.id.clone()).chain(self.storing.keys().cloned()).collect()
    }

    fn busy_count(&self) -> usize {
        self.running.len() + self.storing.len()
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod turns_tests;
