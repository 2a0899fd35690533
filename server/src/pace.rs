//! Lines of the log that would come with every job.
//!
//! Invariant: no more than [`MOST`] lines of a kind are written in a second; the next one says how many were left out.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most lines in a second.
const MOST: u32 = 10;

/// The pace of a kind of line.
#[derive(Debug)]
pub(crate) struct LogRateLimit(Mutex<LogRateState>);

#[derive(Debug)]
struct LogRateState {
    since: Option<Instant>,
    lines: u32,
    left_out: u64,
}

impl LogRateLimit {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(LogRateState { since: None, lines: 0, left_out: 0 }))
    }

    /// The number of lines left out before this one if a line may be written now; otherwise `None`.
    pub(crate) fn pass(&self) -> Option<u64> {
        self.pass_at(Instant::now())
    }

    fn pass_at(&self, now: Instant) -> Option<u64> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if state.since.is_none_or(|since| now.saturating_duration_since(since) >= Duration::from_secs(1)) {
            (state.since, state.lines) = (Some(now), 0);
        }
        if state.lines >= MOST {
            state.left_out += 1;
            return None;
        }
        state.lines += 1;
        Some(std::mem::take(&mut state.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_lines_a_second_pass_and_the_next_says_what_was_left_out() {
        let pace = LogRateLimit::new();
        let begin = Instant::now();
        let passed = (0..50).filter(|_| pace.pass_at(begin) == Some(0)).count();
        assert_eq!(passed, 10);
        let later = begin + Duration::from_secs(1);
        assert_eq!((pace.pass_at(later), pace.pass_at(later)), (Some(40), Some(0)));
    }
}
