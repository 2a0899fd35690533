//! The requirements of the server to its host.
//!
//! Invariant: [`Host`] is about this machine alone; data that other machines need are in ledger, queue, logs and blobs.

use std::fmt::Debug;
use std::io;
use std::path::PathBuf;

/// The machine.
pub(crate) trait Host: Send + Sync + Debug {
    /// Free bytes for the server's storage; `None` if the system does not report them.
    fn free(&self) -> Option<u64>;

    /// Marks a job as running, with the number of its run. The mark is not made durable: it is for the server after one
    /// that died, not for one after a power loss, which no job has caused.
    fn mark(&self, id: &str, attempt: u32) -> io::Result<()>;

    /// Removes the mark of a job. One that stays makes the next server run the job alone.
    fn unmark(&self, id: &str);

    /// Jobs that were running when the server before this one died, with the numbers of their runs.
    fn marks(&self) -> io::Result<Vec<(String, u32)>>;

    /// Folder for files that are not needed after a restart.
    fn scratch(&self) -> PathBuf;

    /// Lets another server have everything.
    fn release(&self);
}
