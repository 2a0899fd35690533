//! The queue in memory: a server that starts fills it from its ledger.
//!
//! Tenants take turns as in deficit round robin: at its turn a tenant gets a quantum of time, it starts jobs while it
//! has credit, and each run is charged with the time that it took. Invariants: a tenant with jobs in its line is in the
//! ring exactly once; a question about a job's place costs the logarithm of the line's length, and one step per tenant.

mod line;
mod places;

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::sync::Arc;
use std::time::Instant;

use crate::queue::{Entry, Queue, Ticket};
use line::{Line, Spot, class};

/// Most jobs whose end is being stored while others have their workers.
const MOST_STORING: usize = 64;
/// Time of workers that a turn is worth, µs.
const QUANTUM: i64 = 10_000;

/// A job on a worker.
#[derive(Debug)]
struct Run {
    id: String,
    tenant: Arc<str>,
    since: Instant,
    /// The cost paid for it.
    price: i64,
}

/// Jobs that wait, and who has a place.
#[derive(Debug, Default)]
pub(crate) struct LocalQueue {
    /// Jobs that were running when the server before this one died: they run alone.
    suspects: VecDeque<(String, Arc<str>)>,
    /// Jobs whose run the host failed, and when they may be run again.
    again: Vec<(Instant, String, Arc<str>)>,
    /// Jobs that are held back.
    paused: BTreeMap<String, Arc<str>>,
    lines: HashMap<Arc<str>, Line>,
    /// Tenants with jobs in their lines, in the order of their turns; the first has its turn.
    ring: VecDeque<Arc<str>>,
    /// Jobs in lines.
    spots: HashMap<String, (Arc<str>, Spot)>,
    last_ordinal: u64,
    /// Most jobs of one tenant on workers, and of tenants for which that is another number; 0 = without limit.
    most_running: usize,
    own_running: HashMap<String, usize>,
    running: Vec<Run>,
    /// Jobs whose run is over and whose end is being stored.
    storing: BTreeSet<String>,
    /// The one running job is to have no company.
    alone: bool,
}

impl LocalQueue {
    /// The name of a tenant as it is kept.
    fn tenant(&self, tenant: &str) -> Arc<str> {
        self.lines.get_key_value(tenant).map_or_else(|| tenant.into(), |(name, _)| name.clone())
    }

    fn line(&mut self, tenant: &Arc<str>) -> &mut Line {
        self.lines.entry(tenant.clone()).or_default()
    }

    /// Drops an unneeded line.
    fn tidy(&mut self, tenant: &Arc<str>) {
        if self.lines.get(tenant).is_some_and(|line| line.held == 0 && line.running == 0) {
            self.lines.remove(tenant);
        }
    }

    /// Takes a job out of its line.
    fn take(&mut self, tenant: &Arc<str>, spot: Spot) -> Option<String> {
        let line = self.lines.get_mut(tenant)?;
        let id = line.remove(spot)?;
        if line.len() == 0 {
            self.ring.retain(|other| other != tenant);
        }
        self.spots.remove(&id);
        Some(id)
    }

    /// Whether a tenant may have another worker.
    fn may_run(&self, tenant: &Arc<str>) -> bool {
        let most = self.own_running.get(&**tenant).copied().unwrap_or(self.most_running);
        most == 0 || self.lines.get(tenant).is_none_or(|line| line.running < most)
    }

    /// The tenant whose turn it is. Tenants that have used up their credit go to the end; when all have, all get as
    /// many quanta as the one that needs the fewest.
    fn turn(&mut self) -> Option<Arc<str>> {
        let able: Vec<Arc<str>> = self.ring.iter().filter(|tenant| self.may_run(tenant)).cloned().collect();
        let lines = &self.lines;
        let credit = |tenant: &Arc<str>| lines.get(tenant).map_or(0, |line| line.credit);
        let richest = able.iter().map(credit).max()?;
        if richest <= 0 {
            // At least one is above zero afterwards.
            let quanta = -richest / QUANTUM + 1;
            for tenant in &able {
                self.line(tenant).credit += quanta * QUANTUM;
            }
        }
        let at = self
            .ring
            .iter()
            .position(|tenant| able.contains(tenant) && self.lines.get(tenant).is_some_and(|line| line.credit > 0))?;
        self.ring.rotate_left(at);
        self.ring.front().cloned()
    }

    /// A tenant without a worker, when all workers are taken.
    fn without_worker(&self) -> Option<Arc<str>> {
        self.ring.iter().find(|tenant| self.lines.get(*tenant).is_some_and(|line| line.running == 0)).cloned()
    }

    fn begin(&mut self, id: String, tenant: Arc<str>, now: Instant) -> String {
        let line = self.line(&tenant);
        line.held = line.held.saturating_sub(1);
        line.running += 1;
        let price = line.pay();
        self.running.push(Run { id: id.clone(), tenant, since: now, price });
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

    fn others_work(&self, tenant: &str, stands: &dyn Fn(&str) -> bool) -> bool {
        let others_wait = self.ring.iter().any(|other| **other != *tenant);
        let mut runs = self.running.iter().filter(|run| others_wait || *run.tenant != *tenant);
        runs.any(|run| !stands(&run.id))
    }

    fn push(&mut self, ticket: Ticket<'_>, entry: Entry) {
        let (id, tenant) = (ticket.id.to_owned(), self.tenant(ticket.tenant));
        self.line(&tenant).held += 1;
        match entry {
            Entry::Suspect => self.suspects.push_back((id, tenant)),
            Entry::Again(at) => self.again.push((at, id, tenant)),
            Entry::Paused => drop(self.paused.insert(id, tenant)),
            Entry::Accepted(since) => {
                self.last_ordinal += 1;
                let spot = Spot { class: class(ticket.priority), ordinal: self.last_ordinal };
                let line = self.line(&tenant);
                if line.len() == 0 {
                    // A tenant's credit is lost with its turn; its debt stays while its jobs run.
                    line.credit = line.credit.min(0);
                    self.ring.push_back(tenant.clone());
                }
                self.line(&tenant).push(spot, id.clone(), since);
                self.spots.insert(id, (tenant, spot));
            }
        }
    }

    fn next(&mut self, slots: usize, now: Instant) -> Option<String> {
        if self.alone {
            return None;
        }
        if !self.suspects.is_empty() {
            if !self.running.is_empty() {
                return None;
            }
            self.alone = true;
            let (id, tenant) = self.suspects.pop_front()?;
            return Some(self.begin(id, tenant, now));
        }
        if self.running.len() >= slots.saturating_mul(2) {
            return None;
        }
        let free = self.running.len() < slots;
        let due = |(at, _, tenant): &(Instant, String, Arc<str>)| *at <= now && self.may_run(tenant);
        if let Some(due) = self.again.iter().position(due).filter(|_| free) {
            let (_, id, tenant) = self.again.remove(due);
            return Some(self.begin(id, tenant, now));
        }
        let tenant = if free { self.turn()? } else { self.without_worker()? };
        let spot = self.lines.get(&tenant)?.first(now)?;
        let id = self.take(&tenant, spot)?;
        Some(self.begin(id, tenant, now))
    }

    fn store(&mut self, id: &str, now: Instant) {
        if self.storing.len() < MOST_STORING {
            self.free(id, now);
            self.storing.insert(id.to_owned());
        }
    }

    fn free(&mut self, id: &str, now: Instant) {
        self.storing.remove(id);
        let Some(at) = self.running.iter().position(|run| run.id == id) else { return };
        let run = self.running.swap_remove(at);
        self.alone = false;
        let line = self.line(&run.tenant);
        line.running = line.running.saturating_sub(1);
        line.settle(run.price, now.saturating_duration_since(run.since));
        self.tidy(&run.tenant);
    }

    fn remove(&mut self, id: &str) -> bool {
        let tenant = if let Some((tenant, spot)) = self.spots.get(id).cloned() {
            self.take(&tenant, spot);
            tenant
        } else if let Some(at) = self.suspects.iter().position(|(waiting, _)| waiting == id) {
            let Some((_, tenant)) = self.suspects.remove(at) else { return false };
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

    fn before(&self, id: &str) -> usize {
        if let Some((tenant, spot)) = self.spots.get(id) {
            let own = self.lines.get(tenant).map_or(0, |line| line.before(*spot));
            // The other tenants have had about as many turns by then.
            let others = self.ring.iter().filter(|other| *other != tenant);
            let others: usize =
                others.filter_map(|other| self.lines.get(other)).map(|line| line.len().min(own + 1)).sum();
            return self.suspects.len() + self.again.len() + own + others;
        }
        let suspect = self.suspects.iter().position(|(waiting, _)| waiting == id);
        let again = || self.again.iter().position(|(_, waiting, _)| waiting == id);
        suspect.or_else(|| again().map(|at| self.suspects.len() + at)).unwrap_or(0)
    }

    fn running(&self) -> Vec<String> {
        self.running.iter().map(|run| run.id.clone()).collect()
    }

    fn suspended(&self, slots: usize) -> BTreeSet<String> {
        let mut left: HashMap<&str, usize> = HashMap::new();
        let mut suspended = BTreeSet::new();
        let many = self.running.len().saturating_sub(slots);
        if many == 0 {
            return suspended;
        }
        for run in &self.running {
            *left.entry(&run.tenant).or_default() += 1;
        }
        while suspended.len() < many {
            // The tenant with the most jobs that use a core gives one.
            let runs = self.running.iter().filter(|run| !suspended.contains(&run.id));
            let last = runs.max_by_key(|run| (left.get(&*run.tenant).copied().unwrap_or(0), run.since));
            let Some(run) = last else { break };
            match left.get_mut(&*run.tenant) {
                Some(left) if *left > 1 => *left -= 1,
                _ => break,
            }
            suspended.insert(run.id.clone());
        }
        suspended
    }

    fn workers(&self) -> usize {
        self.running.len()
    }

    fn busy(&self) -> BTreeSet<String> {
        self.running.iter().map(|run| run.id.clone()).chain(self.storing.iter().cloned()).collect()
    }
}

#[cfg(test)]
mod tests;
