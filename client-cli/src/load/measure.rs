//! The measurements of a load.
//!
//! *Invariants:* times are kept in microseconds with three digits; figures of a second and of the whole come from the
//! same calls.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use hdrhistogram::Histogram;
use serde::Serialize;
use tokio::time::Instant;

use super::process::Sample;

/// Reason of jobs that were still in progress when the patience ran out.
pub(super) const UNFINISHED: &str = "UNFINISHED";

/// Stretches of the life of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JobPhase {
    /// From the moment at which the job was due to the answer of its submit.
    Submit,
    /// From its acceptance to the start of its run, as the server says.
    Queue,
    /// From the moment at which it was due to its first event.
    FirstEvent,
    /// From the moment at which it was due to its end.
    End,
}

impl JobPhase {
    pub(super) const ALL: [Self; 4] = [Self::Submit, Self::Queue, Self::FirstEvent, Self::End];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Submit => "submit",
            Self::Queue => "queue",
            Self::FirstEvent => "first_event",
            Self::End => "end",
        }
    }
}

/// Longest time that is counted exactly, µs: a day. Longer ones count as this long.
const LONGEST: u64 = 86_400_000_000;

/// Times of a stretch. `None` never comes up: the bounds are ones that the type takes.
#[derive(Debug)]
pub(super) struct PhaseHistogram(Option<Histogram<u64>>);

impl PhaseHistogram {
    fn new() -> Self {
        Self(Histogram::new_with_bounds(1, LONGEST, 3).ok())
    }

    fn record(&mut self, time: Duration) {
        if let Some(times) = &mut self.0 {
            times.saturating_record(u64::try_from(time.as_micros()).unwrap_or(LONGEST).max(1));
        }
    }

    fn some(&self) -> Option<&Histogram<u64>> {
        self.0.as_ref().filter(|times| !times.is_empty())
    }

    pub(super) fn count(&self) -> u64 {
        self.some().map_or(0, Histogram::len)
    }

    /// Time that this share of all does not exceed, ms; `None` without a time.
    pub(super) fn ms(&self, share: f64) -> Option<f64> {
        self.some().map(|times| times.value_at_quantile(share) as f64 / 1000.0)
    }

    pub(super) fn max_ms(&self) -> Option<f64> {
        self.some().map(|times| times.max() as f64 / 1000.0)
    }

    pub(super) fn mean_ms(&self) -> Option<f64> {
        self.some().map(|times| times.mean() / 1000.0)
    }
}

/// Figures of a second.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct Second {
    /// Since the start, s.
    pub(super) at_s: f64,
    pub(super) warm_up: bool,
    pub(super) submitted: u64,
    pub(super) ended: u64,
    pub(super) events: u64,
    pub(super) errors: u64,
    /// Jobs that are submitted or followed.
    pub(super) open: u64,
    pub(super) submit_p50_ms: Option<f64>,
    pub(super) submit_p99_ms: Option<f64>,
    pub(super) end_p50_ms: Option<f64>,
    pub(super) end_p99_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) process: Option<Sample>,
}

/// Counts of one second or of the whole load.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LoadCounts {
    pub(super) submitted: u64,
    pub(super) ended: u64,
    pub(super) events: u64,
    pub(super) errors: u64,
}

/// All of it.
#[derive(Debug)]
pub(super) struct Measured {
    start: Instant,
    window: (Instant, Instant),
    times: [PhaseHistogram; 4],
    /// Of the second in progress: submits and ends.
    now: (LoadCounts, PhaseHistogram, PhaseHistogram),
    /// Within the window.
    pub(super) counts: LoadCounts,
    pub(super) errors: BTreeMap<String, u64>,
    pub(super) kinds: BTreeMap<String, u64>,
    pub(super) open: u64,
    pub(super) seconds: Vec<Second>,
    /// When the last job was done with.
    last: Instant,
}

pub(super) fn lock(measured: &Mutex<Measured>) -> MutexGuard<'_, Measured> {
    measured.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Measured {
    pub(super) fn new(window: (Instant, Instant)) -> Self {
        let start = Instant::now();
        Self {
            start,
            window,
            times: JobPhase::ALL.map(|_| PhaseHistogram::new()),
            now: (LoadCounts::default(), PhaseHistogram::new(), PhaseHistogram::new()),
            counts: LoadCounts::default(),
            errors: BTreeMap::new(),
            kinds: BTreeMap::new(),
            open: 0,
            seconds: Vec::new(),
            last: start,
        }
    }

    fn in_window(&self, at: Instant) -> bool {
        self.window.0 <= at && at < self.window.1
    }

    /// Notes a time of a job that was due then.
    pub(super) fn time(&mut self, stretch: JobPhase, due: Instant, time: Duration) {
        match stretch {
            JobPhase::Submit => self.now.1.record(time),
            JobPhase::End => self.now.2.record(time),
            JobPhase::Queue | JobPhase::FirstEvent => {}
        }
        if self.in_window(due)
            && let Some(times) = self.times.get_mut(stretch as usize)
        {
            times.record(time);
        }
    }

    /// Counts an accepted job.
    pub(super) fn submitted(&mut self, kind: &str) {
        self.count(|counts| counts.submitted += 1);
        if self.in_window(Instant::now()) {
            *self.kinds.entry(kind.to_owned()).or_default() += 1;
        }
    }

    /// Counts the end of a followed job.
    pub(super) fn ended(&mut self) {
        self.count(|counts| counts.ended += 1);
    }

    /// Counts events that have arrived.
    pub(super) fn events(&mut self, events: u64) {
        self.count(|counts| counts.events += events);
    }

    /// Counts an error by its reason.
    pub(super) fn error(&mut self, reason: &str) {
        self.count(|counts| counts.errors += 1);
        if self.in_window(Instant::now()) || reason == UNFINISHED {
            *self.errors.entry(reason.to_owned()).or_default() += 1;
        }
    }

    fn count(&mut self, add: impl Fn(&mut LoadCounts)) {
        let now = Instant::now();
        self.last = now;
        add(&mut self.now.0);
        if self.in_window(now) {
            add(&mut self.counts);
        }
    }

    /// Closes the second that is over.
    pub(super) fn tick(&mut self, now: Instant, process: Option<Sample>) {
        let (counts, submits, ends) =
            std::mem::replace(&mut self.now, (LoadCounts::default(), PhaseHistogram::new(), PhaseHistogram::new()));
        self.seconds.push(Second {
            at_s: now.saturating_duration_since(self.start).as_secs_f64(),
            // Ticks come a little late.
            warm_up: now <= self.window.0 + Duration::from_millis(500),
            submitted: counts.submitted,
            ended: counts.ended,
            events: counts.events,
            errors: counts.errors,
            open: self.open,
            submit_p50_ms: submits.ms(0.5),
            submit_p99_ms: submits.ms(0.99),
            end_p50_ms: ends.ms(0.5),
            end_p99_ms: ends.ms(0.99),
            process,
        });
    }

    pub(super) fn times(&self, stretch: JobPhase) -> Option<&PhaseHistogram> {
        self.times.get(stretch as usize)
    }

    /// Time before the window, s.
    pub(super) fn warm_up_s(&self) -> f64 {
        self.window.0.saturating_duration_since(self.start).as_secs_f64()
    }

    /// Measured time so far, s.
    pub(super) fn seconds_measured(&self) -> f64 {
        let end = self.window.1.min(self.last.max(self.window.0));
        end.saturating_duration_since(self.window.0).as_secs_f64().max(1e-3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_what_was_due_in_the_window() {
        let start = Instant::now();
        let mut measured = Measured::new((start, start + Duration::from_secs(3600)));
        assert_eq!(measured.times(JobPhase::Submit).unwrap().ms(0.99), None);
        for ms in 1..=1000 {
            measured.time(JobPhase::Submit, start + Duration::from_millis(1), Duration::from_millis(ms));
        }
        measured.time(JobPhase::Submit, start - Duration::from_secs(1), Duration::from_secs(50));
        let times = measured.times(JobPhase::Submit).unwrap();
        assert_eq!(times.count(), 1000, "what was due during the warm-up does not count");
        for (share, expected) in [(0.5, 500.0), (0.99, 990.0), (0.999, 999.0)] {
            let ms = times.ms(share).unwrap();
            assert!((ms - expected).abs() <= expected * 0.002, "{share} {ms}");
        }
        measured.tick(start + Duration::from_secs(1), None);
        assert!(measured.seconds[0].submit_p99_ms.unwrap() > 900.0);
        measured.tick(start + Duration::from_secs(2), None);
        assert_eq!(measured.seconds[1].submit_p99_ms, None, "each second begins anew");
    }
}
