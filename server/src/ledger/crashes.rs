//! Crashes of servers, counted for each job, and the number after which a job is given up.
//!
//! *Invariant:* a crash counts only for jobs that were at work.

use serde::{Deserialize, Serialize};

/// Crashes of servers while a job was at work: its run was not suspended and did not wait for a client.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Crashes {
    /// Number of crashes at which only this job was at work.
    #[serde(rename = "crashes")]
    pub alone: u32,
    /// Number of all such crashes.
    #[serde(rename = "crashes_at_work")]
    pub at_work: u32,
}

impl Crashes {
    /// Counts a crash.
    pub(crate) fn count(&mut self, alone: bool) {
        self.at_work = self.at_work.saturating_add(1);
        self.alone = self.alone.saturating_add(u32::from(alone));
    }

    /// Why a job is given up after these crashes, if it is: after as many as `attempts` alone, or three times as many
    /// in all. The cause of the latter may be another job, but a server that dies again and again helps no job.
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
