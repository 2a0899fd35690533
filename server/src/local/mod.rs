//! The parts of a server that needs no other machine: everything lies in one data folder.
//!
//! Each implements a seam that the rest of the server uses without knowing the implementation. Invariant: every byte
//! that the server writes passes [`disk::Disk`], so a test can let any write fail.

pub(crate) mod blobs;
pub(crate) mod claim;
pub(crate) mod contained;
pub mod disk;
pub(crate) mod folder_lock;
mod free_space;
pub(crate) mod ledger;
mod logs;
mod marks;
pub(crate) mod named;
pub(crate) mod owner;
pub(crate) mod queue;
mod shared;
mod sizes;
mod spare;
pub(crate) mod store;

use std::sync::Arc;

use crate::blobs::Blobs;
use crate::jobs::Seams;
use crate::metrics::Metrics;
use crate::options::ServerOptions;
use crate::reason::Refusal;
use blobs::LocalBlobs;
use disk::Disk;
use ledger::LocalLedger;
use queue::LocalQueue;
use store::DataFolder;

/// Takes the data folder and opens its contents.
pub(crate) fn open(options: &ServerOptions, disk: Disk, metrics: &Arc<Metrics>) -> Result<Seams, Refusal> {
    let disk = disk.counting(&metrics.storage.syncs);
    let store = DataFolder::open(options.data.clone(), !options.embedded.ephemeral, disk)?;
    let blobs: Arc<dyn Blobs> = match options.embedded.ephemeral {
        true => Arc::new(LocalBlobs::in_memory(options.maxima.max_blob_bytes)),
        false => Arc::new(LocalBlobs::new(store.clone(), options.maxima.max_blob_bytes)),
    };
    Ok(Seams {
        ledger: Arc::new(LocalLedger::open(&store, metrics.clone())?),
        queue: Box::new(LocalQueue::default()),
        logs: Arc::new(store.clone()),
        blobs,
        host: Arc::new(store),
    })
}
