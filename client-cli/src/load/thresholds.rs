//! The thresholds of a load.

use std::time::Duration;

use serde::Serialize;

use super::arguments::Thresholds;
use super::growth::Growth;
use super::measure::{JobPhase, Measured};

/// A threshold and the measured value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Threshold {
    pub(super) what: &'static str,
    pub(super) unit: &'static str,
    pub(super) limit: f64,
    /// `None` = nothing was measured, which misses the threshold.
    pub(super) measured: Option<f64>,
    pub(super) kept: bool,
}

impl std::fmt::Display for Threshold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, unit, limit, measured, .. } = self;
        match measured {
            Some(value) => write!(f, "{what}: {value:.3} {unit}, limit {limit} {unit}"),
            None => write!(f, "{what}: nothing was measured, limit {limit} {unit}"),
        }
    }
}

/// All thresholds that were requested.
pub(super) fn thresholds(asked: &Thresholds, measured: &Measured, growth: &[Growth]) -> Vec<Threshold> {
    let seconds = measured.seconds_measured();
    let p99 = |stretch| measured.times(stretch).and_then(|times| times.ms(0.99));
    let ms = |limit: Option<Duration>| limit.map(|limit| limit.as_secs_f64() * 1e3);
    let counts = &measured.counts;
    let errors: u64 = measured.errors.values().sum();
    let due = (counts.submitted + errors).max(1) as f64;
    let most = [
        ("p99 of submit", "ms", ms(asked.max_p99_submit), p99(JobPhase::Submit)),
        ("p99 of queue", "ms", ms(asked.max_p99_queue), p99(JobPhase::Queue)),
        ("p99 of first event", "ms", ms(asked.max_p99_first_event), p99(JobPhase::FirstEvent)),
        ("p99 of end", "ms", ms(asked.max_p99_end), p99(JobPhase::End)),
        ("errors", "%", asked.max_errors, Some(errors as f64 * 100.0 / due)),
    ];
    let least = [
        ("submits", "jobs/s", asked.min_submits, counts.submitted),
        ("ends", "jobs/s", asked.min_ends, counts.ended),
        ("events", "events/s", asked.min_events, counts.events),
    ];
    let most = most.into_iter().filter_map(|(what, unit, limit, measured)| {
        let limit = limit?;
        Some(Threshold { what, unit, limit, measured, kept: measured.is_some_and(|value| value <= limit) })
    });
    let least = least.into_iter().filter_map(|(what, unit, limit, count)| {
        let (limit, value) = (limit?, count as f64 / seconds);
        Some(Threshold { what, unit, limit, measured: Some(value), kept: value >= limit })
    });
    let grown = growth.iter().map(|growth| (growth.what, Some(growth.percent)));
    // A server that could not be measured, or not for long enough, misses the threshold.
    let grown = grown.chain(growth.is_empty().then_some(("growth of the server", None)));
    let grown = grown.filter_map(|(what, measured)| {
        let limit = asked.max_growth?;
        Some(Threshold { what, unit: "%", limit, measured, kept: measured.is_some_and(|value| value <= limit) })
    });
    most.chain(least).chain(grown).collect()
}

#[cfg(test)]
mod tests {
    use tokio::time::Instant;

    use super::*;

    #[test]
    fn growth_beyond_the_limit_or_not_measured_misses_it() {
        let start = Instant::now();
        let measured = Measured::new((start, start + Duration::from_secs(3600)));
        let asked = Thresholds { max_growth: Some(5.0), ..Thresholds::default() };
        let growth = |what, percent| Growth { what, first: 1.0, last: 1.0, percent, per_hour: 0.0 };
        let both = [growth("growth of memory", 5.0), growth("growth of threads", 5.1)];
        let kept = |growth: &[Growth]| -> Vec<_> {
            thresholds(&asked, &measured, growth).into_iter().map(|t| (t.what, t.kept)).collect()
        };
        assert_eq!(kept(&both), [("growth of memory", true), ("growth of threads", false)]);
        assert_eq!(kept(&[]), [("growth of the server", false)]);
    }

    #[test]
    fn what_was_not_measured_or_is_beyond_a_limit_misses_it() {
        let start = Instant::now();
        let mut measured = Measured::new((start, start + Duration::from_secs(3600)));
        measured.time(JobPhase::Submit, start, Duration::from_millis(20));
        measured.submitted("a");
        measured.error("QUEUE_FULL");
        let asked = Thresholds {
            max_p99_submit: Some(Duration::from_millis(30)),
            max_p99_end: Some(Duration::from_millis(30)),
            max_errors: Some(49.0),
            min_events: Some(1.0),
            ..Thresholds::default()
        };
        let kept: Vec<_> = thresholds(&asked, &measured, &[]).into_iter().map(|t| (t.what, t.kept)).collect();
        assert_eq!(kept, [("p99 of submit", true), ("p99 of end", false), ("errors", false), ("events", false)]);
    }
}
