//! Limits of a run that the server enforces: running time, the deadline of its job, bytes.
//!
//! *Invariant:* suspended time counts for the deadline and not for the running time.

use std::time::{Duration, Instant};

use counterpoint_proto::v1;

use crate::ledger::record::ReachedLimit;
use crate::utc::instant;

/// The limit that has stopped a run, and its effect.
pub(crate) type Stopped = (ReachedLimit, String);

/// Limits of a run, and the limit that was reached.
#[derive(Debug, Default)]
pub(super) struct RunLimits {
    /// Maximum running time.
    wall: Option<Duration>,
    /// Running time up to the last suspension.
    ran: Duration,
    /// Start of the current running time; none while the run is suspended, or before it begins.
    since: Option<Instant>,
    suspended: bool,
    /// Time and reason of a planned stop.
    deadline: Option<(Instant, Stopped)>,
    pub(super) bytes: Option<u64>,
    /// Bytes that the run may hold in addition to the values of macros; known once the run is prepared.
    pub(super) held: Option<u64>,
    /// The limit that was reached.
    pub(super) reached: Option<Stopped>,
}

impl RunLimits {
    /// Sets the limits of a run that begins now. The run may already be suspended.
    pub(super) fn begin(&mut self, now: Instant, wall: Duration, deadline: Option<(Duration, Stopped)>, bytes: u64) {
        let deadline = deadline.and_then(|(left, stopped)| Some((now.checked_add(left)?, stopped)));
        let (suspended, since) = (self.suspended, (!self.suspended).then_some(now));
        *self = Self { wall: Some(wall), since, suspended, deadline, bytes: Some(bytes), ..Self::default() };
    }

    /// Stops the running time.
    pub(super) fn suspend(&mut self, now: Instant) {
        self.suspended = true;
        if let Some(since) = self.since.take() {
            self.ran += now.saturating_duration_since(since);
        }
    }

    /// Continues the running time.
    pub(super) fn resume(&mut self, now: Instant) {
        self.suspended = false;
        if self.wall.is_some() {
            self.since.get_or_insert(now);
        }
    }

    /// The time limit that has been reached; if both have, the earlier one.
    pub(super) fn over(&self, now: Instant) -> Option<Stopped> {
        let running = self.since.map_or(Duration::ZERO, |since| now.saturating_duration_since(since));
        let wall = self.wall.and_then(|wall| {
            let beyond = (self.ran + running).checked_sub(wall)?;
            let text = format!(
                "the run was stopped after {} ms of running time, its limit wall_ms: submit the job with a higher limit; \
                 the administrator sets the maximum of the server",
                wall.as_millis()
            );
            Some((beyond, (ReachedLimit::WallMs, text)))
        });
        let deadline = self.deadline.as_ref();
        let deadline = deadline.and_then(|(at, stopped)| Some((now.checked_duration_since(*at)?, stopped.clone())));
        wall.into_iter().chain(deadline).max_by_key(|(beyond, _)| *beyond).map(|(_, stopped)| stopped)
    }
}

/// The message for a job that ends at its deadline; `question` is the dialog for whose answer the job waits.
pub(super) fn late(deadline: i64, question: Option<&v1::Question>) -> String {
    let deadline = instant(deadline);
    if let Some(v1::Question { dialog: Some(dialog), file, line, .. }) = question {
        let place = match (file.as_str(), line) {
            ("", _) => String::new(),
            (file, 0) => format!(" ({file})"),
            (file, line) => format!(" ({file} line {line})"),
        };
        return format!(
            "the job had not ended at its deadline, {deadline} UTC: no client had answered the dialog '{}'{place}; \
             submit the job again and answer the dialog in time, or give prepared answers",
            dialog.name
        );
    }
    format!(
        "the job had not ended at its deadline, {deadline} UTC: submit it again with a later deadline or a \
         higher priority"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    fn limits(now: Instant, deadline: Option<u64>) -> RunLimits {
        let mut limits = RunLimits::default();
        let deadline = deadline.map(|left| (ms(left), (ReachedLimit::Deadline, "late".to_owned())));
        limits.begin(now, ms(1000), deadline, 1);
        limits
    }

    fn over(limits: &RunLimits, now: Instant) -> Option<ReachedLimit> {
        limits.over(now).map(|(reached, _)| reached)
    }

    #[test]
    fn time_while_suspended_is_no_running_time() {
        let begin = Instant::now();
        let mut limits = limits(begin, None);
        limits.suspend(begin + ms(600));
        assert_eq!(over(&limits, begin + ms(5000)), None);
        limits.resume(begin + ms(5000));
        assert_eq!(over(&limits, begin + ms(5399)), None);
        assert_eq!(over(&limits, begin + ms(5400)), Some(ReachedLimit::WallMs));
    }

    #[test]
    fn a_deadline_is_reached_also_while_suspended() {
        let begin = Instant::now();
        let mut limits = limits(begin, Some(2000));
        limits.suspend(begin + ms(600));
        assert_eq!(over(&limits, begin + ms(1999)), None);
        assert_eq!(over(&limits, begin + ms(2000)), Some(ReachedLimit::Deadline));
    }

    #[test]
    fn of_two_limits_the_first_counts() {
        let begin = Instant::now();
        for (deadline, reached) in [(990, ReachedLimit::Deadline), (1010, ReachedLimit::WallMs)] {
            assert_eq!(over(&limits(begin, Some(deadline)), begin + ms(1100)), Some(reached));
        }
    }

    #[test]
    fn a_run_that_is_suspended_before_it_begins_has_not_run() {
        let begin = Instant::now();
        let mut limits = RunLimits::default();
        limits.suspend(begin);
        limits.begin(begin, ms(1000), None, 1);
        assert_eq!(over(&limits, begin + ms(3000)), None);
        limits.resume(begin + ms(3000));
        assert_eq!(over(&limits, begin + ms(4000)), Some(ReachedLimit::WallMs));
        // The next run of the job has the full running time again.
        limits.begin(begin + ms(4000), ms(1000), None, 1);
        assert_eq!(over(&limits, begin + ms(4500)), None);
    }
}
