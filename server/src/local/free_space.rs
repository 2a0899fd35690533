//! Free bytes on a disk, from a recent reading.
//!
//! Each job needs the number several times. Invariant: a reading is at most [`VALID`] old.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long a reading is valid.
const VALID: Duration = Duration::from_millis(20);

/// The last reading.
#[derive(Debug, Default)]
pub(crate) struct FreeSpace {
    last: Mutex<Option<(Instant, Option<u64>)>>,
}

impl FreeSpace {
    /// The free bytes at this time; `read` asks the system if the last reading is no longer valid.
    pub(crate) fn at(&self, now: Instant, read: impl FnOnce() -> Option<u64>) -> Option<u64> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((at, free)) = *last
            && now.saturating_duration_since(at) < VALID
        {
            return free;
        }
        let free = read();
        *last = Some((now, free));
        free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_is_asked_again_when_the_reading_is_old() {
        let (space, begin) = (FreeSpace::default(), Instant::now());
        assert_eq!(space.at(begin, || Some(5)), Some(5));
        assert_eq!(space.at(begin + VALID / 2, || Some(6)), Some(5));
        assert_eq!(space.at(begin + VALID, || None), None);
        assert_eq!(space.at(begin + VALID * 3 / 2, || Some(7)), None, "no answer is a reading, too");
    }
}
