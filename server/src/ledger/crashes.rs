//! Server crashes, counted for each job, and the number after which a job is given up.
//!
//! *Invariant:* a crash counts only for jobs that were working.

use serde::{Deserialize, Serialize};

/// Server crashes while a job was working: its run was not suspended and did not wait for a client.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Crashes {
    /// Number of crashes at which only this job was working.
    #[serde(rename = "crashes")]
    pub alone: u32,
    /// Number of all crashes at which this job was working.
    #[serde(rename = "crashes_at_work")]
    pub at_work: u32,
}

impl Crashes {
    /// Counts a crash.
    pub(crate) fn count(&mut self, alone: bool) {
        self.at_work = self.at_work.saturating_add(1);
        self.alone = self.alone.saturating_add(u32::from(alone));
    }

    /// The reason for giving up a job, if its crashes reach a limit: `attempts` crashes while it was alone, or three
    /// times as many in total. In the second case another job may be the cause, but repeated crashes help no job.
    pub(crate) fn poison(self, attempts: u32) -> Option<String> {
        let (attempts, Self { alone, at_work }) = (attempts.max(1), self);
        if alone >= attempts {
            Some(format!("poison: the server died {alone} times while this job ran alone"))
        } else if at_work >= attempts.saturating_mul(3) {
            Some(format!("poison: the server died {at_work} times while this job ran, alone or beside other jobs"))
        } else {
            None
        }
    }
}
