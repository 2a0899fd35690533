//! The time by which ends are ordered and ended jobs grow old: the highest that the clock has shown.
//!
//! *Invariant:* it never goes back, also not over a restart, since the ledger stores it. Deadlines and days count by the
//! clock as it is.

use std::sync::atomic::{AtomicI64, Ordering};

use crate::ledger::record::{Record, now_ms};

/// The highest time seen, ms since 1970.
#[derive(Debug)]
pub(crate) struct Clock(AtomicI64);

impl Clock {
    /// A clock that has shown this before.
    pub(crate) fn from(highest_ms: i64) -> Self {
        Self(AtomicI64::new(highest_ms))
    }

    /// The time, never before an earlier one.
    pub(crate) fn now_ms(&self) -> i64 {
        let now = now_ms();
        self.0.fetch_max(now, Ordering::Relaxed).max(now)
    }

    /// The time of an end of a job: never before its submit and its start.
    pub(crate) fn end_of(&self, record: &Record) -> i64 {
        self.now_ms().max(record.submitted_ms).max(record.runs.started_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ledger::record::tests::record;

    #[test]
    fn it_never_goes_back_and_no_job_ends_before_it_was_submitted() {
        let ahead = now_ms() + 3_600_000;
        let clock = Clock::from(ahead);
        assert_eq!((clock.now_ms(), clock.now_ms()), (ahead, ahead), "the clock was set back by an hour");
        let clock = Clock::from(0);
        let first = clock.now_ms();
        assert!(clock.now_ms() >= first && first >= now_ms() - 1000);
        let later = Record { submitted_ms: ahead, ..record("a") };
        assert_eq!(clock.end_of(&later), ahead);
    }
}
