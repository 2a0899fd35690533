//! Lines of the log about jobs that are accepted and that end: one for all of a second.
//!
//! *Invariant:* every job is counted in exactly one line for its acceptance and one for its end; with DEBUG each has
//! lines of its own besides.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::ledger::record::{JobRecord, JobState};

/// Between two lines.
const EVERY: Duration = Duration::from_secs(1);

/// Jobs since the last line.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct JobCounts {
    pub(super) accepted: u64,
    pub(super) succeeded: u64,
    pub(super) failed: u64,
    pub(super) cancelled: u64,
}

/// The events since the last line.
#[derive(Debug, Default)]
pub(super) struct JobTally(Mutex<(JobCounts, Option<Instant>)>);

impl JobTally {
    /// Counts an accepted job.
    pub(super) fn accepted(&self, record: &JobRecord) {
        tracing::debug!(job = record.id, machine = record.machine_name, tenant = record.tenant, "accepted");
        self.add(|counts| counts.accepted += 1);
    }

    /// Counts a job that has ended; others are left out.
    pub(super) fn ended(&self, record: &JobRecord) {
        let count = match record.state {
            JobState::Queued | JobState::Running => return,
            JobState::Succeeded => |counts: &mut JobCounts| counts.succeeded += 1,
            JobState::Failed => |counts: &mut JobCounts| counts.failed += 1,
            JobState::Cancelled => |counts: &mut JobCounts| counts.cancelled += 1,
        };
        tracing::debug!(job = record.id, state = ?record.state, events = record.events, error = record.error, "ended");
        self.add(count);
    }

    fn add(&self, count: impl FnOnce(&mut JobCounts)) {
        count(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner).0);
    }

    /// Writes a line when one is due.
    pub(super) fn report(&self) {
        if let Some(JobCounts { accepted, succeeded, failed, cancelled }) = self.due(Instant::now()) {
            tracing::info!(accepted, succeeded, failed, cancelled, "jobs");
        }
    }

    /// The current report.
    fn due(&self, now: Instant) -> Option<JobCounts> {
        let mut tally = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (counts, last) = &mut *tally;
        if *counts == JobCounts::default() || last.is_some_and(|last| now.saturating_duration_since(last) < EVERY) {
            return None;
        }
        *last = Some(now);
        Some(std::mem::take(counts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::record::tests::record;

    #[test]
    fn the_jobs_of_a_second_share_a_line_and_none_is_left_out() {
        let (tally, now) = (JobTally::default(), Instant::now());
        assert_eq!(tally.due(now), None, "nothing has happened");
        let job = record("1");
        tally.accepted(&job);
        tally.ended(&job);
        assert_eq!(
            tally.due(now),
            Some(JobCounts { accepted: 1, ..JobCounts::default() }),
            "a queued job has not ended"
        );
        for state in [JobState::Succeeded, JobState::Succeeded, JobState::Failed, JobState::Cancelled] {
            tally.accepted(&job);
            tally.ended(&JobRecord { state, ..job.clone() });
        }
        assert_eq!(tally.due(now + Duration::from_millis(999)), None);
        let all = JobCounts { accepted: 4, succeeded: 2, failed: 1, cancelled: 1 };
        assert_eq!(tally.due(now + EVERY), Some(all));
        assert_eq!(tally.due(now + EVERY * 2), None);
    }
}
