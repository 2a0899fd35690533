//! Ended jobs that stay in memory with their results.
//!
//! Invariant: there are few, and their results have few bytes; of a server that stores nothing the newest stays.

use std::collections::VecDeque;

/// Most jobs.
const MOST: usize = 64;
/// Most bytes of their results.
const MOST_BYTES: u64 = 32 << 20;

/// Identities of the jobs, oldest first, with the bytes of their results.
#[derive(Debug, Default)]
pub(super) struct Recent {
    jobs: VecDeque<(String, u64)>,
    bytes: u64,
}

impl Recent {
    /// Adds a job and takes out those beyond the bounds. `newest_stays`: its results are nowhere else.
    pub(super) fn push(&mut self, id: String, bytes: u64, newest_stays: bool) -> Vec<String> {
        self.jobs.push_back((id, bytes));
        self.bytes += bytes;
        let mut gone = Vec::new();
        while self.jobs.len() > MOST || self.bytes > MOST_BYTES && self.jobs.len() > usize::from(newest_stays) {
            let Some((id, bytes)) = self.jobs.pop_front() else { break };
            self.bytes -= bytes;
            gone.push(id);
        }
        gone
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_leave_by_number_and_by_bytes() {
        let mut recent = Recent::default();
        for id in 0..MOST {
            assert!(recent.push(id.to_string(), 1, false).is_empty());
        }
        assert_eq!(recent.push("more".into(), 1, false), ["0"]);
        assert_eq!(recent.push("large".into(), MOST_BYTES, false).len(), MOST, "all but the large one");
        assert_eq!(recent.push("too large".into(), MOST_BYTES + 1, false), ["large", "too large"]);
        assert_eq!(recent.push("only".into(), MOST_BYTES + 1, true), [""; 0]);
        assert_eq!(recent.push("next".into(), 1, true), ["only"]);
        assert_eq!(recent.bytes, 1);
    }
}
