//! Suspects: jobs that were running when the previous server died.
//!
//! One after another, they run alone before other jobs run: any other runs are suspended meanwhile. A suspect is
//! cleared when it has run alone for its time, or when it pauses and cannot crash the server. It then continues beside
//! other jobs. A suspect whose run is stopped earlier keeps the rest of its time for its next run. *Invariant:*
//! suspects delay other jobs by at most the sum of their times alone, however often they are stopped.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::LocalQueue;
use super::turns::WorkerRun;
use crate::queue::SchedulingState;

/// A suspect that waits.
#[derive(Debug)]
struct Suspect {
    id: String,
    tenant: Arc<str>,
    /// Earliest start; `None` = at once.
    at: Option<Instant>,
}

/// The suspect that runs alone.
#[derive(Debug)]
struct SoloRun {
    id: String,
    since: Instant,
}

/// All suspects: waiting, running alone, or held back.
#[derive(Debug, Default)]
pub(super) struct Suspects {
    waiting: VecDeque<Suspect>,
    alone: Option<SoloRun>,
    /// Remaining time alone of each suspect, including suspects that are held back.
    left: HashMap<String, Duration>,
    /// Suspects that were cleared since the last call of `take_cleared`.
    cleared: Vec<String>,
}

impl Suspects {
    /// Makes a job a suspect; an existing suspect keeps the rest of its time.
    pub(super) fn suspect(&mut self, id: &str, alone: Duration) {
        self.left.entry(id.to_owned()).or_insert(alone);
    }

    pub(super) fn contains(&self, id: &str) -> bool {
        self.left.contains_key(id)
    }

    /// Queues a suspect; it starts at `at` or later.
    pub(super) fn push(&mut self, id: String, tenant: Arc<str>, at: Option<Instant>) {
        self.waiting.push_back(Suspect { id, tenant, at });
    }

    /// Removes a waiting suspect; returns its tenant.
    pub(super) fn remove(&mut self, id: &str) -> Option<Arc<str>> {
        let at = self.before(id)?;
        self.waiting.remove(at).map(|suspect| suspect.tenant)
    }

    /// Number of waiting suspects.
    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Number of suspects that wait before this job; `None` if the job is not a waiting suspect.
    pub(super) fn before(&self, id: &str) -> Option<usize> {
        self.waiting.iter().position(|suspect| suspect.id == id)
    }

    /// Whether a suspect runs alone.
    pub(super) fn runs_alone(&self) -> bool {
        self.alone.is_some()
    }

    /// The suspect that runs alone.
    pub(super) fn alone(&self) -> Option<&str> {
        self.alone.as_ref().map(|alone| alone.id.as_str())
    }

    /// Ends the run of a job. A suspect that has run alone for its time is cleared.
    pub(super) fn stop(&mut self, id: &str, now: Instant) {
        let Some(alone) = self.alone.take_if(|alone| alone.id == id) else { return };
        match self.left.get_mut(id) {
            Some(left) => *left = left.saturating_sub(now.saturating_duration_since(alone.since)),
            None => return,
        }
        if self.left.get(id).is_some_and(Duration::is_zero) {
            self.clear(alone.id);
        }
    }

    /// Forgets an ended job.
    pub(super) fn forget(&mut self, id: &str) {
        self.left.remove(id);
    }

    pub(super) fn take_cleared(&mut self) -> Vec<String> {
        std::mem::take(&mut self.cleared)
    }

    fn clear(&mut self, id: String) {
        self.left.remove(&id);
        self.cleared.push(id);
    }

    /// Clears the suspect that runs alone if other jobs may now run beside it.
    fn clear_alone(&mut self, running: &[WorkerRun], now: Instant) {
        let left = &self.left;
        let over = self.alone.take_if(|alone| {
            let waits_for_client = running.iter().any(|run| run.id == alone.id && run.waits_for_client);
            waits_for_client
                || left.get(&alone.id).is_none_or(|left| now.saturating_duration_since(alone.since) >= *left)
        });
        if let Some(over) = over {
            self.clear(over.id);
        }
    }

    /// Takes the first suspect that may start.
    fn first(&mut self, now: Instant) -> Option<Suspect> {
        let first = self.waiting.iter().position(|suspect| suspect.at.is_none_or(|at| at <= now))?;
        self.waiting.remove(first)
    }
}

impl LocalQueue {
    /// Clears the suspect that runs alone if it may have company now; returns the next suspect, if it starts.
    pub(super) fn next_suspect(&mut self, look: &SchedulingState<'_>) -> Option<String> {
        self.suspects.clear_alone(&self.running, look.now);
        let mut started = None;
        if self.suspects.alone.is_none() && look.starts {
            let Suspect { id, tenant, .. } = self.suspects.first(look.now)?;
            self.suspects.alone = Some(SoloRun { id: id.clone(), since: look.now });
            let longest = self.suspects.left.get(&id).copied().unwrap_or_default();
            tracing::warn!(
                job = id,
                ?longest,
                "the job runs alone after a crash, and other jobs wait; cancel it if they must not wait"
            );
            started = Some(self.begin(id, tenant, look.now));
        }
        let alone = self.suspects.alone.as_ref()?;
        for run in self.running.iter_mut().filter(|run| run.id != alone.id && !run.waits_for_client) {
            run.suspended = true;
        }
        started
    }
}
