//! What the server keeps on the disk of its own machine: the one seam for file writes, the ledger's file, and the lock
//! of the data folder.
//!
//! Invariant: every byte that the server writes passes [`disk::Disk`], so a test can let any write fail.

pub mod disk;
pub(crate) mod folder_lock;
pub(crate) mod ledger_file;
