//! Recovery: requeues the jobs that the previous server left unfinished.
//!
//! A mark shows whether its run was working when the server died; the job of such a run is a suspect. *Invariant:* a
//! crash is counted once for each job, even if further servers die during recovery. To ensure this, the jobs are stored
//! in one transaction, and a mark counts only if the ledger does not yet have the number of its run.

use std::collections::HashMap;
use std::sync::Arc;

use super::Core;
use crate::clock::Clock;
use crate::host::RunMark;
use crate::ledger::record::{Cause, JobRecord, JobState};
use crate::reason::Refusal;

impl Core {
    /// Requeues the jobs that a previous server left unfinished.
    pub(super) fn take_up_unfinished(self: &Arc<Self>) -> Result<(), Refusal> {
        let marks: HashMap<String, RunMark> =
            self.host.marks()?.into_iter().map(|mark| (mark.id.clone(), mark)).collect();
        let mut jobs = self.ledger.unfinished()?;
        let died = Died::new(&jobs, &marks, self.options.maxima.attempts);
        if !jobs.is_empty() {
            tracing::info!(jobs = jobs.len(), running = died.at_work, "jobs that have not ended are taken up again");
        }
        if died.at_work > 0 {
            let jobs = died.at_work;
            tracing::warn!(
                jobs,
                "the previous server died while these jobs were working: look for the cause at the end of its log; each \
                 of them runs alone at first"
            );
        }
        let mut changed = Vec::new();
        for job in &mut jobs {
            let before = job.clone();
            died.recover(job, &self.board.clock);
            if died.was_at_work(&before) {
                report(job);
            }
            if died.had_begun(&before) || job.state.ended() {
                // Log and results belong to a run that did not reach its end.
                self.logs.remove(&job.id)?;
            }
            if *job != before {
                changed.push(job.clone());
            }
        }
        if !changed.is_empty() {
            self.ledger.update_blocking(changed)?;
        }
        marks.keys().for_each(|id| self.host.unmark(id));
        for job in jobs {
            if job.state.ended() {
                self.ended(&job);
            } else {
                self.admit(self.in_memory(job));
            }
        }
        Ok(())
    }
}

/// Logs the new state of a job that was at work when the server died.
fn report(job: &JobRecord) {
    let (id, error) = (&job.id, &job.error);
    match job.state {
        JobState::Failed => tracing::warn!(
            job = id,
            tenant = job.tenant,
            "given up: {error}; look for the cause at the end of the log of the crashed server before you run the job again"
        ),
        JobState::Queued => tracing::warn!(
            job = id,
            crashes = job.runs.crashes.at_work,
            "suspect: the job waits to run alone; cancel it if it must not run again"
        ),
        state => tracing::info!(job = id, ?state, "recovered"),
    }
}

/// The runs at the death of the previous server.
struct Died<'a> {
    marks: &'a HashMap<String, RunMark>,
    /// Number of runs that were working.
    at_work: usize,
    /// Number of crashes after which a job is given up.
    attempts: u32,
}

impl<'a> Died<'a> {
    fn new(jobs: &[JobRecord], marks: &'a HashMap<String, RunMark>, attempts: u32) -> Self {
        let died = Self { marks, at_work: 0, attempts };
        Self { at_work: jobs.iter().filter(|job| died.was_at_work(job)).count(), ..died }
    }

    /// The mark of the interrupted run, unless the ledger already has its number.
    fn mark(&self, job: &JobRecord) -> Option<&RunMark> {
        self.marks.get(&job.id).filter(|mark| mark.attempt > job.runs.attempt)
    }

    /// Whether a run of this job was interrupted.
    fn had_begun(&self, job: &JobRecord) -> bool {
        job.state == JobState::Running || self.marks.contains_key(&job.id)
    }

    fn was_at_work(&self, job: &JobRecord) -> bool {
        job.state == JobState::Running || self.mark(job).is_some_and(|mark| mark.works)
    }

    /// Sets the state of a job after the crash. If a single run was working, that run may have caused the crash.
    fn recover(&self, job: &mut JobRecord, clock: &Clock) {
        let (suspect, alone) = (self.was_at_work(job), self.at_work == 1);
        if let Some(mark) = self.mark(job) {
            // An idle run was not the cause. If its job was a suspect, the job has already run alone.
            (job.runs.attempt, job.runs.suspect) = (mark.attempt, false);
        }
        if suspect {
            job.runs.crashes.count(alone);
        }
        let poison = job.runs.crashes.poison(self.attempts).filter(|_| suspect);
        if job.cancel {
            job.state = JobState::Cancelled;
            job.end(clock);
        } else if let Some(error) = poison {
            job.state = JobState::Failed;
            job.end(clock);
            job.runs.cause = Some(Cause::Host);
            job.error = error;
        } else {
            // A suspect that was not running at the next crash was not the cause.
            job.runs.suspect = suspect || job.runs.suspect && self.at_work == 0;
            (job.state, job.runs.started_ms) = (JobState::Queued, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::record::tests::record;

    const ATTEMPTS: u32 = 2;

    fn jobs<const N: usize>(ids: [&str; N]) -> Vec<JobRecord> {
        ids.map(record).to_vec()
    }

    /// Recovers the jobs of a server that left marks with these run numbers; numbers of idle runs are negative.
    fn after(jobs: &mut [JobRecord], marks: &[(&str, i32)]) {
        let mark = |(id, attempt): &(&str, i32)| {
            let id = (*id).to_owned();
            (id.clone(), RunMark { id, attempt: attempt.unsigned_abs(), works: *attempt > 0 })
        };
        let marks = marks.iter().map(mark).collect();
        let died = Died::new(jobs, &marks, ATTEMPTS);
        jobs.iter_mut().for_each(|job| died.recover(job, &Clock::from(0)));
    }

    fn suspects(jobs: &[JobRecord]) -> Vec<&str> {
        jobs.iter().filter(|job| job.runs.suspect).map(|job| job.id.as_str()).collect()
    }

    #[test]
    fn a_mark_that_stays_is_counted_once_and_its_job_stays_a_suspect() {
        let mut jobs = jobs(["a", "b", "c"]);
        after(&mut jobs, &[("a", 1), ("b", 1)]);
        assert_eq!(suspects(&jobs), ["a", "b"]);
        // Servers die after the transaction, before all marks are removed.
        for _ in 0..5 {
            after(&mut jobs, &[("b", 1)]);
            assert_eq!(suspects(&jobs), ["a", "b"]);
        }
        let counts = jobs.iter().map(|job| (job.state, job.runs.attempt, job.runs.crashes.at_work));
        let queued = |attempt| (JobState::Queued, attempt, attempt);
        assert_eq!(counts.collect::<Vec<_>>(), [queued(1), queued(1), queued(0)]);
    }

    #[test]
    fn a_job_that_runs_alone_at_each_crash_is_given_up_and_clears_the_others() {
        let mut jobs = jobs(["a", "b"]);
        after(&mut jobs, &[("a", 1), ("b", 1)]);
        after(&mut jobs, &[("a", 2)]);
        assert_eq!((suspects(&jobs), jobs[0].runs.crashes.alone), (vec!["a"], 1));
        after(&mut jobs, &[("a", 3)]);
        assert_eq!((jobs[0].state, jobs[0].runs.cause), (JobState::Failed, Some(Cause::Host)));
        assert!(jobs[0].error.starts_with("poison: the server died 2 times"), "{}", jobs[0].error);
        assert_eq!((jobs[1].state, jobs[1].runs.suspect), (JobState::Queued, false));
    }

    #[test]
    fn an_idle_run_counts_as_an_attempt_and_its_job_is_no_suspect() {
        let mut jobs = jobs(["a", "b"]);
        after(&mut jobs, &[("a", 1), ("b", 1)]);
        after(&mut jobs, &[("a", -2)]);
        assert_eq!((suspects(&jobs), jobs[0].runs.attempt, jobs[0].runs.crashes.at_work), (vec!["b"], 2, 1));
        after(&mut jobs, &[("a", -3), ("b", 2)]);
        assert_eq!((suspects(&jobs), jobs[0].runs.attempt), (vec!["b"], 3));
        assert_eq!((jobs[1].runs.attempt, jobs[1].runs.crashes.alone), (2, 1), "it was the only run at work");
    }

    #[test]
    fn jobs_that_are_never_alone_at_a_crash_are_given_up_after_three_times_as_many() {
        let mut jobs = jobs(["a", "b"]);
        for attempt in 1..6 {
            after(&mut jobs, &[("a", attempt), ("b", attempt)]);
            assert_eq!(suspects(&jobs), ["a", "b"]);
        }
        after(&mut jobs, &[("a", 6), ("b", -6)]);
        assert!(jobs[0].error.starts_with("poison: the server died 6 times"), "{}", jobs[0].error);
        assert_eq!(
            (jobs[0].state, jobs[1].state),
            (JobState::Failed, JobState::Queued),
            "an idle run was not the cause"
        );
    }
}
