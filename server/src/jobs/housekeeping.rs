//! What the server clears away by itself: folders of jobs that have no row, ended jobs beyond what is to be kept, and
//! blobs that nothing needs.
//!
//! Invariant: what a row of the ledger needs is never removed, nor a job that has not ended or that somebody watches.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Core;
use crate::ledger::Keep;
use crate::ledger::record::now_ms;
use crate::options::Retention;
use crate::reason::Refusal;

/// Between two looks at whether there is anything to do.
const TICK: Duration = Duration::from_secs(1);
/// Longest time between two collections of blobs.
const LONGEST: Duration = Duration::from_secs(600);
/// Most jobs that are removed in one step.
const GROUP: usize = 256;

/// Removes folders of jobs that the ledger does not know: the server died between removing row and folder.
pub(super) fn remove_folders_without_a_row(core: &Core) -> Result<(), Refusal> {
    if core.options.ephemeral {
        return Ok(());
    }
    for id in core.logs.jobs()? {
        if !core.ledger.knows(&id)? {
            tracing::info!(job = id, "removing the folder of a job that the ledger does not know");
            core.logs.remove(&id)?;
        }
    }
    Ok(())
}

/// Starts the thread that clears away; it ends with the core.
pub(super) fn start(core: &Arc<Core>) -> Result<(), Refusal> {
    if core.options.ephemeral {
        return Ok(());
    }
    let keep = keep(&core.options.retention);
    let grace = Duration::from_secs(core.options.retention.blob_grace_s);
    let core = Arc::downgrade(core);
    let work = move || {
        let mut next = Instant::now();
        while let Some(core) = core.upgrade() {
            core.ledger.serve_backups();
            remove_expired(&core, &keep);
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

fn keep(options: &Retention) -> Keep {
    let limit = |value: u64| Some(value).filter(|value| *value > 0);
    let age_ms = limit(options.keep_s).map(|s| i64::try_from(s.saturating_mul(1000)).unwrap_or(i64::MAX));
    Keep { age_ms, jobs: limit(options.keep_jobs), bytes: limit(options.keep_bytes) }
}

/// Removes ended jobs beyond what is to be kept.
fn remove_expired(core: &Core, keep: &Keep) {
    if keep.age_ms.is_none() && keep.jobs.is_none() && keep.bytes.is_none() {
        return;
    }
    let step = || {
        let mut jobs = core.ledger.expired(keep, now_ms(), GROUP)?;
        let all = jobs.len();
        // A job that somebody watches goes the next time.
        jobs.retain(|job| !core.watched(&job.id));
        let records: Vec<_> = jobs.iter().map(|job| core.ledger.job(&job.id).ok().flatten()).collect();
        core.ledger.remove_blocking(jobs.clone())?;
        for (job, record) in jobs.iter().zip(&records) {
            core.forget(&job.id, record.as_ref())?;
        }
        Ok::<_, Refusal>((jobs.len(), all))
    };
    loop {
        match step() {
            Ok((removed, all)) => {
                if removed > 0 {
                    tracing::info!(removed, "ended jobs beyond what is to be kept have been removed");
                }
                if removed < GROUP || all < GROUP {
                    return;
                }
            }
            Err(error) => return tracing::debug!(%error, "the removal of ended jobs is tried again later"),
        }
    }
}

/// Removes blobs that no row needs and nobody has asked for during the grace time.
fn collect_blobs(core: &Core, grace: Duration) {
    let collect = || {
        let mut removed = 0;
        for tenant in core.blobs.tenants()? {
            let own = core.blobs.of(&tenant);
            for group in own.older_than(grace) {
                let blobs = own.clone();
                let remove = Box::new(move |digest: &str| blobs.remove_older(digest, grace));
                removed += core.ledger.collect_blocking(&tenant, group, remove)?;
            }
        }
        Ok::<_, Refusal>(removed)
    };
    match collect() {
        Ok(0) => {}
        Ok(removed) => tracing::info!(removed, "blobs that nothing needs have been removed"),
        Err(error) => tracing::debug!(%error, "the collection of blobs is tried again later"),
    }
}
