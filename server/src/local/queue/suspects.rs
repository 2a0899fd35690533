//! Suspects: jobs that were running when the previous server died.
//!
//! One after another, they run alone before other jobs run: any other runs are suspended meanwhile. A suspect is
//! cleared when its time alone is over, or when it stands and cannot harm the server. It then continues beside other
//! jobs. *Invariant:* suspects delay other jobs by at most the sum of their times alone.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::LocalQueue;
use crate::queue::Look;

/// A suspect that waits.
#[derive(Debug)]
pub(super) struct Suspect {
    pub(super) id: String,
    pub(super) tenant: Arc<str>,
    /// Time for which it runs alone.
    pub(super) alone: Duration,
}

/// The suspect that runs alone.
#[derive(Debug)]
pub(super) struct Alone {
    pub(super) id: String,
    until: Option<Instant>,
}

impl LocalQueue {
    /// Clears the suspect that runs alone if it may have company now; returns the next suspect, if it starts.
    pub(super) fn next_suspect(&mut self, look: &Look<'_>) -> Option<String> {
        let running = &self.running;
        self.alone.take_if(|alone| {
            let stands = running.iter().any(|run| run.id == alone.id && run.stands);
            stands || alone.until.is_some_and(|until| look.now >= until)
        });
        let mut started = None;
        if self.alone.is_none() && look.starts {
            let Suspect { id, tenant, alone } = self.suspects.pop_front()?;
            self.alone = Some(Alone { id: id.clone(), until: look.now.checked_add(alone) });
            started = Some(self.begin(id, tenant, look.now));
        }
        let alone = self.alone.as_ref()?;
        for run in self.running.iter_mut().filter(|run| run.id != alone.id && !run.stands) {
            run.suspended = true;
        }
        started
    }
}
