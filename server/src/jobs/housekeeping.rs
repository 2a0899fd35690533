//! What the server clears away by itself: folders of jobs that have no row, and blobs that nothing needs.
//!
//! Invariant: what a row of the ledger needs is never removed.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Core;
use crate::reason::Refusal;

/// Between two looks at whether there is anything to do.
const TICK: Duration = Duration::from_secs(1);
/// Longest time between two collections of blobs.
const LONGEST: Duration = Duration::from_secs(600);

/// Removes folders of jobs that the ledger does not know: the server died between removing row and folder.
pub(super) fn remove_folders_without_a_row(core: &Core) -> Result<(), Refusal> {
    if core.options.ephemeral {
        return Ok(());
    }
    for id in core.store.jobs()? {
        if !core.ledger.knows(&id)? {
            tracing::info!(job = id, "removing the folder of a job that the ledger does not know");
            core.store.remove_job(&id)?;
        }
    }
    Ok(())
}

/// Starts the thread that clears away; it ends with the core.
pub(super) fn start(core: &Arc<Core>) -> Result<(), Refusal> {
    if core.options.ephemeral {
        return Ok(());
    }
    let grace = Duration::from_secs(core.options.retention.blob_grace_s);
    let core = Arc::downgrade(core);
    let work = move || {
        let mut next = Instant::now();
        while let Some(core) = core.upgrade() {
            if next <= Instant::now() {
                collect_blobs(&core, grace);
                next = Instant::now() + (grace / 10).clamp(TICK, LONGEST);
            }
            drop(core);
            std::thread::sleep(TICK);
        }
    };
    std::thread::Builder::new().name("housekeeping".to_owned()).spawn(work)?;
    Ok(())
}

/// Removes blobs that no row needs and nobody has asked for during the grace time.
fn collect_blobs(core: &Core, grace: Duration) {
    let mut removed = 0;
    for group in core.blobs.older_than(grace) {
        let blobs = core.blobs.clone();
        match core.ledger.collect_blocking(group, move |digest| blobs.remove_older(digest, grace)) {
            Ok(count) => removed += count,
            Err(error) => {
                tracing::debug!(%error, "the collection of blobs is tried again later");
                return;
            }
        }
    }
    if removed > 0 {
        tracing::info!(removed, "blobs that nothing needs have been removed");
    }
}
