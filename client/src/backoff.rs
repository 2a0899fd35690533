//! How long to pause before something is tried again.
//!
//! *Invariant:* a pause is at least half and at most the whole of a time that doubles, so clients that failed together
//! do not come back together.

use std::time::Duration;

use tokio::time::Instant;

use crate::error::Error;
use crate::settings::{ClientSettings, Notice};

/// First and longest time that pauses are taken from.
const FIRST: Duration = Duration::from_millis(100);
const LONGEST: Duration = Duration::from_secs(10);

/// Pauses between failures in a row.
#[derive(Debug)]
pub(crate) struct Backoff {
    patience: Duration,
    /// Receives the first of several consecutive failures.
    notice: Option<Notice>,
    failures: u32,
    /// When something last succeeded, or the first failure after that.
    since: Option<Instant>,
}

impl Backoff {
    pub(crate) fn of(settings: &ClientSettings) -> Self {
        Self { notice: settings.notice(), ..Self::new(settings.patience()) }
    }

    fn new(patience: Duration) -> Self {
        Self { patience, notice: None, failures: 0, since: None }
    }

    /// Something succeeded: the next failure is the first one again.
    pub(crate) fn succeeded(&mut self) {
        (self.failures, self.since) = (0, None);
    }

    /// Records a failure. Returns the pause before the next attempt, at least as long as the server asks for, or `None`
    /// if the patience has run out.
    pub(crate) fn failed(&mut self, error: &Error) -> Option<Duration> {
        if let (0, Some(notice)) = (self.failures, self.notice) {
            notice(error, self.patience);
        }
        self.failed_at(Instant::now(), error.pause(), fastrand::f64())
    }

    fn failed_at(&mut self, now: Instant, asked: Option<Duration>, random: f64) -> Option<Duration> {
        let since = *self.since.get_or_insert(now);
        if now.saturating_duration_since(since) > self.patience {
            return None;
        }
        let most = FIRST.saturating_mul(1 << self.failures.min(16)).min(LONGEST);
        self.failures += 1;
        let pause = most.mul_f64(0.5 + random.clamp(0.0, 1.0) / 2.0);
        Some(pause.max(asked.unwrap_or_default()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_to_a_most_and_begin_anew_after_a_success() {
        let now = Instant::now();
        let mut backoff = Backoff::new(Duration::from_secs(60));
        let mut pause = |random| backoff.failed_at(now, None, random).unwrap().as_millis();
        assert_eq!([pause(1.0), pause(1.0), pause(0.0), pause(0.5)], [100, 200, 200, 600]);
        let last = (0..100).map(|_| pause(1.0)).last();
        assert_eq!(last, Some(10_000));
        backoff.succeeded();
        assert_eq!(backoff.failed_at(now, None, 0.0), Some(Duration::from_millis(50)));
        let asked = Some(Duration::from_secs(3));
        assert_eq!(backoff.failed_at(now, asked, 0.0), asked, "what the server asks for is kept");
    }

    #[test]
    fn patience_ends_when_nothing_has_succeeded_for_its_time() {
        let now = Instant::now();
        let mut backoff = Backoff::new(Duration::from_secs(60));
        assert!(backoff.failed_at(now, None, 0.5).is_some());
        assert!(backoff.failed_at(now + Duration::from_secs(60), None, 0.5).is_some());
        assert!(backoff.failed_at(now + Duration::from_secs(61), None, 0.5).is_none());
        backoff.succeeded();
        assert!(backoff.failed_at(now + Duration::from_secs(62), None, 0.5).is_some());
    }
}
