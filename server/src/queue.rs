//! The queue: which job runs next, and how many are before a given one.
//!
//! [`Queue`] is the seam; the one in memory is in `local`. Jobs run in the order of submission, but for two kinds:
//! those whose run the host failed wait for their time and go first then, and after an unclean stop the jobs that were
//! running go first and one at a time. Invariant: a job is waiting, running or being stored, and never two of these.

use std::fmt::Debug;
use std::time::Instant;

/// Why a job is put into the queue, and with that where.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Entry {
    /// It was accepted: at the end.
    Accepted,
    /// It was running when the server before this one died: first and alone.
    Suspect,
    /// It waits for another run until then, and goes first.
    Again(Instant),
}

/// Jobs that wait, and who has a place. Calls do not block.
pub(crate) trait Queue: Send + Debug {
    /// Jobs that wait.
    fn len(&self) -> usize;

    /// Lets a job wait.
    fn push(&mut self, id: &str, entry: Entry);

    /// Takes the next job if one of the `slots` workers is free for it.
    fn next(&mut self, slots: usize, now: Instant) -> Option<String>;

    /// A run is over: its job gives its worker free before its end is stored, unless too many do that already.
    fn store(&mut self, id: &str);

    /// A job is neither running nor being stored any more.
    fn free(&mut self, id: &str);

    /// Takes a job out; `false` if it does not wait.
    fn remove(&mut self, id: &str) -> bool;

    /// Jobs before this one; 0 if it does not wait.
    fn before(&self, id: &str) -> usize;

    /// Jobs on workers.
    fn running(&self) -> &[String];

    /// Jobs that run or are being stored.
    fn busy(&self) -> usize;
}
