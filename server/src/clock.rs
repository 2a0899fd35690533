//! The time by which ended jobs age and are ordered.
//!
//! *Invariant:* this time never goes back, even after a restart, since the ledger stores it, and it never stands still.
//! If the computer's clock shows less, this time advances with the monotonic clock. A clock that jumps ahead is trusted
//! only after it has stayed there for an hour, so a wrong clock removes no jobs. Times of a status, deadlines and days
//! follow the computer's clock as it is.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Milliseconds since 1970 by the clock of the computer.
pub(crate) fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |d| i64::try_from(d.as_millis()).unwrap_or(i64::MAX))
}

/// Time that may have passed between two servers, ms. More than that must be confirmed.
const MOST_BETWEEN_SERVERS_MS: i64 = 86_400_000;
/// Time that the clock of the computer may be ahead while the server runs, ms.
const MOST_AHEAD_MS: i64 = 60_000;
/// A clock that has been ahead for this long is right.
const CONFIRMED: Duration = Duration::from_secs(3600);

/// A jump of the clock of the computer that is not confirmed.
#[derive(Debug, Clone, Copy)]
struct ClockJump {
    since: Instant,
    by_ms: i64,
}

/// The state: a time, and when it was read.
#[derive(Debug)]
struct ClockReading {
    time_ms: i64,
    at: Instant,
    jump: Option<ClockJump>,
}

impl ClockReading {
    /// The time when the monotonic clock has reached `at` and the clock of the computer shows `shown_ms`.
    fn read(&mut self, shown_ms: i64, at: Instant, most_ahead_ms: i64) -> i64 {
        let passed = at.saturating_duration_since(self.at);
        let passed = i64::try_from(passed.as_millis()).unwrap_or(i64::MAX);
        let counted = self.time_ms.saturating_add(passed);
        let by_ms = shown_ms.saturating_sub(counted);
        // The rest of a millisecond counts at the next reading.
        let at_counted = self.at + Duration::from_millis(u64::try_from(passed).unwrap_or(0));
        let believed = by_ms <= most_ahead_ms || self.confirmed(by_ms, at);
        (self.time_ms, self.at) = if believed && by_ms > 0 { (shown_ms, at) } else { (counted, at_counted) };
        if believed {
            self.jump = None;
        }
        self.time_ms
    }

    /// Whether the clock of the computer has been ahead by this for long enough; notes a new jump.
    fn confirmed(&mut self, by_ms: i64, at: Instant) -> bool {
        match self.jump {
            Some(jump) if by_ms.abs_diff(jump.by_ms) <= MOST_AHEAD_MS.unsigned_abs() => {
                let confirmed = at.saturating_duration_since(jump.since) >= CONFIRMED;
                if confirmed {
                    tracing::warn!(ahead_s = by_ms / 1000, "the clock has stayed ahead: jobs age by it again");
                }
                confirmed
            }
            _ => {
                self.jump = Some(ClockJump { since: at, by_ms });
                tracing::warn!(
                    ahead_s = by_ms / 1000,
                    "the clock of this computer has jumped ahead: no job is removed because of it within an hour; set \
                     the clock if it is wrong"
                );
                false
            }
        }
    }
}

/// The time, never before an earlier one.
#[derive(Debug)]
pub(crate) struct Clock(Mutex<ClockReading>);

impl Clock {
    /// A clock that has shown this before, ms since 1970; 0 = none has.
    pub(crate) fn from(highest_ms: i64) -> Self {
        Self::at(highest_ms, now_ms(), Instant::now())
    }

    fn at(highest_ms: i64, shown_ms: i64, at: Instant) -> Self {
        let mut reading = ClockReading { time_ms: if highest_ms > 0 { highest_ms } else { shown_ms }, at, jump: None };
        reading.read(shown_ms, at, MOST_BETWEEN_SERVERS_MS);
        Self(Mutex::new(reading))
    }

    /// The time.
    pub(crate) fn now_ms(&self) -> i64 {
        self.reading(|reading| reading.read(now_ms(), Instant::now(), MOST_AHEAD_MS))
    }

    /// Milliseconds that the clock of the computer is ahead without being confirmed.
    pub(crate) fn ahead_ms(&self) -> i64 {
        self.now_ms();
        self.reading(|reading| reading.jump.map_or(0, |jump| jump.by_ms))
    }

    fn reading<T>(&self, look: impl FnOnce(&mut ClockReading) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR_MS: i64 = 3_600_000;
    const SECOND: Duration = Duration::from_secs(1);

    /// A clock of the computer and a monotonic one under the control of a test.
    struct Fake {
        clock: Clock,
        begin: Instant,
    }

    impl Fake {
        fn new(highest_ms: i64, shown_ms: i64) -> Self {
            let begin = Instant::now();
            Self { clock: Clock::at(highest_ms, shown_ms, begin), begin }
        }

        /// The time after `passed` when the computer shows `shown_ms`.
        fn read(&self, passed: Duration, shown_ms: i64) -> i64 {
            self.clock.reading(|reading| reading.read(shown_ms, self.begin + passed, MOST_AHEAD_MS))
        }

        fn jump(&self) -> Option<i64> {
            self.clock.reading(|reading| reading.jump.map(|jump| jump.by_ms))
        }
    }

    #[test]
    fn it_goes_on_after_the_clock_was_set_back() {
        let highest = 40 * 365 * 24 * HOUR_MS;
        let fake = Fake::new(highest, HOUR_MS);
        let times = [1, 2, 7].map(|s| fake.read(s * SECOND, HOUR_MS + 1000 * i64::from(s)));
        assert_eq!(times, [1, 2, 7].map(|s| highest + 1000 * s), "an hour after an earlier time in 2009");
        assert_eq!(fake.jump(), None);
    }

    #[test]
    fn parts_of_milliseconds_add_up() {
        let fake = Fake::new(HOUR_MS, 0);
        let time = (1..=4000).map(|step| fake.read(step * Duration::from_micros(250), 0)).last();
        assert_eq!(time, Some(HOUR_MS + 1000));
    }

    #[test]
    fn a_clock_that_jumps_ahead_is_believed_after_an_hour() {
        let fake = Fake::new(0, HOUR_MS);
        let shown = |s: i64| 100 * HOUR_MS + 1000 * s;
        assert_eq!(fake.read(SECOND, shown(1)), HOUR_MS + 1000);
        assert_eq!(fake.jump(), Some(99 * HOUR_MS));
        assert_eq!(fake.read(3600 * SECOND, shown(3600)), HOUR_MS + 3_600_000, "an hour less a second");
        assert_eq!(fake.read(3601 * SECOND, shown(3601)), shown(3601));
        assert_eq!(fake.jump(), None);
    }

    #[test]
    fn a_jump_that_is_taken_back_or_followed_by_another_is_not_believed() {
        let fake = Fake::new(0, 0);
        fake.read(SECOND, 50 * HOUR_MS);
        assert_eq!(fake.read(2 * SECOND, 2000), 2000, "taken back");
        assert_eq!(fake.jump(), None);
        fake.read(3 * SECOND, 50 * HOUR_MS);
        fake.read(1800 * SECOND, 500 * HOUR_MS);
        assert_eq!(fake.read(3700 * SECOND, 500 * HOUR_MS + 1_900_000), 3_700_000, "the second jump is young");
    }

    #[test]
    fn a_server_that_was_off_for_hours_believes_the_clock_and_for_weeks_waits() {
        let off = Fake::new(HOUR_MS, 9 * HOUR_MS);
        assert_eq!((off.read(SECOND, 9 * HOUR_MS + 1000), off.jump()), (9 * HOUR_MS + 1000, None));
        let weeks = Fake::new(HOUR_MS, 500 * HOUR_MS);
        assert_eq!((weeks.read(SECOND, 500 * HOUR_MS + 1000), weeks.jump()), (HOUR_MS + 1000, Some(499 * HOUR_MS)));
        let new = Fake::new(0, 500 * HOUR_MS);
        assert_eq!((new.read(SECOND, 500 * HOUR_MS + 1000), new.jump()), (500 * HOUR_MS + 1000, None));
    }
}
