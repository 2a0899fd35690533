//! Suspicion: marks runs for the next server, in case this server dies, and clears suspects.
//!
//! The marks show which runs are working. *Invariant:* a job that the queue has cleared is no longer a suspect: at once
//! in memory, and by the next tick in the ledger. The job becomes a suspect again if its run is working when the server
//! dies.

use std::io;

use counterpoint_proto::v1;

use super::Core;
use super::board::QueueState;
use super::live::LiveJob;
use super::lock::lock;
use crate::host::RunMark;
use crate::ledger::record::{JobRecord, JobState, now_ms};

/// The suspect that runs alone.
#[derive(Debug)]
pub(crate) struct LoneSuspect {
    job: String,
    tenant: String,
}

impl LoneSuspect {
    /// The suspect that runs alone while other jobs wait.
    pub(crate) fn of(core: &Core) -> Option<Self> {
        let job = lock(&core.board.queue).jobs.alone()?.to_owned();
        let tenant = core.live(&job)?.peek(|record| record.tenant.clone());
        Some(Self { job, tenant })
    }

    /// Adds the wait for this suspect to the status of another job. A suspect of another tenant is not named.
    pub(crate) fn mark(&self, status: &mut v1::JobStatus) {
        let open = matches!(status.state(), v1::JobState::Queued | v1::JobState::Running);
        if open && !status.paused && status.job_id != self.job {
            status.waits_for_suspect = true;
            if status.tenant == self.tenant {
                status.waits_for_job.clone_from(&self.job);
            }
        }
    }
}

impl Core {
    /// Takes the jobs that the queue has cleared, and removes their suspicion in memory.
    pub(super) fn clear(&self, queue: &mut QueueState) {
        let cleared = queue.jobs.take_cleared();
        for live in cleared.iter().filter_map(|id| self.live(id)) {
            tracing::warn!(job = live.id, "no longer a suspect: other jobs run beside it; no action is needed");
            live.change(|record| record.runs.suspect = false);
        }
        queue.cleared.extend(cleared);
    }

    /// Stores the cleared suspects in the ledger, from a thread that may block.
    pub(crate) fn keep_cleared(&self) {
        let cleared = std::mem::take(&mut lock(&self.board.queue).cleared);
        if cleared.is_empty() {
            return;
        }
        if let Err(error) = self.ledger.clear_blocking(cleared.clone()) {
            tracing::debug!(%error, "the end of a suspicion is stored later");
            lock(&self.board.queue).cleared.extend(cleared);
        }
    }

    /// Updates the marks of runs that have started or stopped using processor time: only a working run can crash the
    /// server, and one that is over and waits for its storage does not work.
    pub(super) fn mark_working(&self, queue: &mut QueueState) {
        if queue.jobs.are_idle(&queue.idle) {
            return;
        }
        let idle = queue.jobs.idle();
        let busy = queue.jobs.busy();
        let changed = idle.symmetric_difference(&queue.idle).filter(|id| busy.contains(*id));
        for live in changed.filter_map(|id| self.live(id)) {
            let attempt = live.peek(|record| record.runs.attempt);
            let mark = RunMark { id: live.id.clone(), attempt, works: !idle.contains(&live.id) };
            // If the server dies, a job without a mark is queued again and does not run alone.
            if let Err(error) = self.host.mark(&mark) {
                tracing::debug!(job = live.id, %error, "the run has no mark");
            }
        }
        queue.idle = idle;
    }

    /// Marks a run that starts now, and sets its number and its start time.
    pub(super) fn begin_run(&self, live: &LiveJob) -> io::Result<JobRecord> {
        // The lock keeps the number and the mark consistent.
        let queue = lock(&self.board.queue);
        let attempt = live.peek(|record| record.runs.attempt) + 1;
        self.host.mark(&RunMark { id: live.id.clone(), attempt, works: !queue.idle.contains(&live.id) })?;
        Ok(live.change(|record| {
            (record.state, record.runs.started_ms) = (JobState::Running, now_ms().max(record.submitted_ms));
            record.runs.attempt = attempt;
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::board::time_alone;
    use super::*;

    #[test]
    fn a_suspect_of_another_tenant_is_not_named() {
        let alone = LoneSuspect { job: "suspect".to_owned(), tenant: "a".to_owned() };
        let waits = |tenant: &str, id: &str, state: v1::JobState, paused: bool| {
            let (job_id, tenant, state) = (id.to_owned(), tenant.to_owned(), state.into());
            let mut status = v1::JobStatus { job_id, tenant, state, paused, ..Default::default() };
            alone.mark(&mut status);
            (status.waits_for_suspect, status.waits_for_job)
        };
        use v1::JobState::{Failed, Queued, Running};
        assert_eq!(waits("a", "one", Queued, false), (true, "suspect".to_owned()));
        assert_eq!(waits("b", "two", Running, false), (true, String::new()));
        for (id, state, paused) in [("suspect", Running, false), ("one", Failed, false), ("one", Queued, true)] {
            assert_eq!(waits("a", id, state, paused), (false, String::new()), "{id} {state:?}");
        }
    }

    #[test]
    fn the_time_alone_doubles_up_to_twenty_seconds() {
        assert_eq!([0, 1, 2, 3, 4, 100].map(|crashes| time_alone(crashes).as_secs()), [5, 5, 10, 20, 20, 20]);
    }
}
