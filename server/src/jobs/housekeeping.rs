//! Automatic removal: folders of jobs without a row, ended jobs beyond the retention limits, and unneeded blobs.
//!
//! Invariant: data that a row of the ledger needs are never removed, nor a job that has not ended or that is watched.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Core;
use crate::ledger::{Compacted, Keep, TenantRetention};
use crate::options::Tenant;
use crate::reason::Refusal;

/// Between two looks at whether there is anything to do.
const TICK: Duration = Duration::from_secs(1);
/// Longest time between two collections of blobs.
const LONGEST: Duration = Duration::from_secs(600);
/// Time after which the clock is stored again, ms.
const STORE_CLOCK_MS: i64 = 60_000;
/// Most jobs that are removed in one step.
const GROUP: usize = 256;

/// Removes folders of jobs that the ledger does not know: the server died between removing row and folder.
pub(super) fn remove_folders_without_a_row(core: &Core) -> Result<(), Refusal> {
    if core.options.embedded.ephemeral {
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
    if core.options.embedded.ephemeral {
        return Ok(());
    }
    let grace = Duration::from_secs(core.options.retention.blob_grace_s);
    let core = Arc::downgrade(core);
    let work = move || {
        let mut next = Instant::now();
        let mut stored_ms = core.upgrade().map_or(0, |core| core.board.clock.now_ms());
        while let Some(core) = core.upgrade() {
            core.ledger.serve_backups();
            note("ended jobs beyond what is to be kept", remove_expired(&core, &keep(&core)));
            let now_ms = core.board.clock.now_ms();
            if now_ms >= stored_ms.saturating_add(STORE_CLOCK_MS) && core.ledger.keep_highest(now_ms).is_ok() {
                stored_ms = now_ms;
            }
            if next <= Instant::now() {
                note("blobs that nothing needs", collect_blobs(&core, grace));
                compact_if_worthwhile(&core);
                next = Instant::now() + (grace / 10).clamp(TICK, LONGEST);
            }
            drop(core);
            std::thread::sleep(TICK);
        }
    };
    std::thread::Builder::new().name("housekeeping".to_owned()).spawn(work)?;
    Ok(())
}

fn keep(core: &Core) -> Keep {
    let options = &core.options;
    let limit = |value: u64| Some(value).filter(|value| *value > 0);
    let age = |s: u64| limit(s).map(|s| i64::try_from(s.saturating_mul(1000)).unwrap_or(i64::MAX));
    let own = |own: &Tenant| TenantRetention {
        age_ms: age(own.keep_s.unwrap_or(options.retention.keep_s)),
        jobs: limit(own.keep_jobs.unwrap_or(options.retention.tenant_keep_jobs)),
        bytes: limit(own.keep_bytes.unwrap_or(options.retention.tenant_keep_bytes)),
    };
    let own = core.tenants().iter().map(|(name, tenant)| (name.clone(), own(tenant))).collect();
    let options = &options.retention;
    Keep {
        own,
        age_ms: age(options.keep_s),
        jobs: limit(options.keep_jobs),
        bytes: limit(options.keep_bytes),
        tenant_jobs: limit(options.tenant_keep_jobs),
        tenant_bytes: limit(options.tenant_keep_bytes),
    }
}

impl Core {
    /// Stores the time by which jobs age, for the next server.
    pub(crate) fn keep_time(&self) {
        if self.options.embedded.ephemeral {
            return;
        }
        if let Err(error) = self.ledger.keep_highest(self.board.clock.now_ms()) {
            tracing::debug!(%error, "the next server takes the time that was stored before");
        }
    }

    /// Removes them now; returns the numbers of removed jobs and blobs.
    pub(crate) fn collect(&self) -> Result<(u64, u64), Refusal> {
        let jobs = remove_expired(self, &keep(self))?;
        let blobs = collect_blobs(self, Duration::from_secs(self.options.retention.blob_grace_s))?;
        Ok((jobs, blobs))
    }

    /// Compacts the ledger if the disk has room for a copy of its rows, and for new work beside it.
    pub(crate) fn compact(&self) -> Result<Compacted, Refusal> {
        let least = self.options.min_free_bytes.saturating_add(self.ledger.used_bytes()?);
        if self.host.free().is_some_and(|free| free < least) && !self.options.embedded.ephemeral {
            return Err(Refusal::DiskFull(least));
        }
        let done = self.ledger.compact_blocking()?;
        let Compacted { before, after, time } = done;
        match after < before {
            true => tracing::info!(before, after, ?time, "the ledger has been compacted"),
            false => tracing::info!(bytes = before, ?time, "the ledger stays as it is: a copy would not be smaller"),
        }
        Ok(done)
    }
}

/// Removes ended jobs beyond the retention limits; returns their number.
fn remove_expired(core: &Core, keep: &Keep) -> Result<u64, Refusal> {
    let mut removed = 0;
    if keep.everything() {
        return Ok(removed);
    }
    loop {
        let mut jobs = core.ledger.expired(keep, core.board.clock.now_ms(), GROUP)?;
        let all = jobs.len();
        // A watched job is removed the next time.
        jobs.retain(|job| !core.watched(&job.id));
        let records: Vec<_> = jobs.iter().map(|job| core.ledger.job(&job.id).ok().flatten()).collect();
        let gone_now = core.ledger.remove_blocking(jobs.clone())?;
        // A client may have deleted one meanwhile; then its call does the rest.
        for ((job, record), _) in jobs.iter().zip(&records).zip(gone_now).filter(|(_, gone_now)| *gone_now) {
            core.forget(&job.id, record.as_ref())?;
            removed += 1;
        }
        if jobs.len() < GROUP || all < GROUP {
            return Ok(removed);
        }
    }
}

/// Removes blobs that no row needs and no client has requested during the grace time; returns their number.
fn collect_blobs(core: &Core, grace: Duration) -> Result<u64, Refusal> {
    let mut removed = 0;
    for tenant in core.blobs.tenants()? {
        let own = core.blobs.of(&tenant);
        for group in own.older_than(grace) {
            let blobs = own.clone();
            let remove = Box::new(move |digest: &str| blobs.remove_older(digest, grace));
            removed += core.ledger.collect_blocking(&tenant, group, remove)? as u64;
        }
    }
    Ok(removed)
}

/// Compacts the ledger if that is worthwhile.
fn compact_if_worthwhile(core: &Core) {
    let least_free = core.options.retention.compact_bytes;
    let file = core.ledger.file_bytes();
    // A small file needs no look at its pages.
    if least_free == 0 || file < least_free {
        return;
    }
    if core.ledger.used_bytes().is_ok_and(|used| Compacted::worthwhile(file, used, least_free))
        && let Err(error) = core.compact()
    {
        tracing::warn!(%error, "the ledger is not compacted yet");
    }
}

/// Logs the removed items, or that removal will be tried again.
fn note(what: &str, removed: Result<u64, Refusal>) {
    match removed {
        Ok(0) => {}
        Ok(removed) => tracing::info!(removed, "{what} have been removed"),
        Err(error) => tracing::debug!(%error, "the removal of {what} is tried again later"),
    }
}
