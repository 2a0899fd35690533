//! The requirements of the server to its host.
//!
//! Invariant: [`ServerHost`] is about this machine alone; data that other machines need are in ledger, queue, logs and blobs.

use std::fmt::Debug;
use std::io;
use std::path::PathBuf;

/// Mark of a run, read by the next server after a crash.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct RunMark {
    pub(crate) id: String,
    /// Number of the run.
    pub(crate) attempt: u32,
    /// Whether the run uses processor time; an idle run cannot crash the server.
    pub(crate) works: bool,
}

/// The machine.
pub(crate) trait ServerHost: Send + Sync + Debug {
    /// Free bytes for the server's storage; `None` if the system does not report them.
    fn free(&self) -> Option<u64>;

    /// Marks a job as running and replaces its earlier mark. The mark is not made durable: it is needed after a crash,
    /// but not after a power loss, which no job has caused.
    fn mark(&self, mark: &RunMark) -> io::Result<()>;

    /// Removes the mark of a job. If the removal fails, the next server may run the job alone.
    fn unmark(&self, id: &str);

    /// Marks that the previous server left when it died.
    fn marks(&self) -> io::Result<Vec<RunMark>>;

    /// Folder for files that are not needed after a restart.
    fn scratch(&self) -> PathBuf;

    /// Lets another server have everything.
    fn release(&self);
}
