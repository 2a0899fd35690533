//! Ended jobs by the digest of the inputs that determine their results.
//!
//! *Invariant:* a row is only a hint. The named job is used only if its own row, which has a checksum, has the same
//! digest. So a wrong or missing row costs a run, but changes no result.

use std::collections::BTreeMap;

use redb::ReadableTable as _;
use redb::{ReadTransaction, WriteTransaction};

use super::tables::{EQUAL, TransactionTables};
use super::{JOB, parse, readable, storage};
use crate::ledger::record::JobRecord;
use crate::reason::Refusal;
use crate::tenant;

/// The key of a job's row; `None` if other jobs may not use its results.
fn key(record: &JobRecord) -> Option<String> {
    let usable = record.state.ended() && !record.reuse.digest.is_empty();
    usable.then(|| tenant::key(&record.tenant, &record.reuse.digest))
}

/// Adds the row of an ended job.
pub(super) fn add(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    if let Some(key) = key(record) {
        tables.equal()?.insert(key.as_str(), record.id.as_str()).map_err(storage)?;
    }
    Ok(())
}

/// Removes the row of a job.
pub(super) fn remove(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    let Some(key) = key(record) else { return Ok(()) };
    let mut table = tables.equal()?;
    let own = table.get(key.as_str()).map_err(storage)?.is_some_and(|id| id.value() == record.id);
    if own {
        table.remove(key.as_str()).map_err(storage)?;
    }
    Ok(())
}

/// The most recently ended job of a tenant with this digest.
pub(super) fn find(txn: &ReadTransaction, tenant: &str, digest: &str) -> Result<Option<JobRecord>, Refusal> {
    let row = tenant::key(tenant, digest);
    let table = txn.open_table(EQUAL).map_err(storage)?;
    let Some(id) = table.get(row.as_str()).map_err(storage)?.map(|id| id.value().to_owned()) else { return Ok(None) };
    let jobs = txn.open_table(JOB).map_err(storage)?;
    let job = jobs.get(id.as_str()).map_err(storage)?;
    let job = job.map(|job| parse::<JobRecord>(JOB, &id, job.value())).transpose()?;
    Ok(job.filter(|job| job.id == id && key(job).as_ref() == Some(&row)))
}

/// Rebuilds the rows of all jobs.
pub(super) fn list_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    txn.open_table(EQUAL).map_err(storage)?.retain(|_, _| false).map_err(storage)?;
    let tables = TransactionTables::of(txn);
    for row in txn.open_table(JOB).map_err(storage)?.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        if let Some(record) = readable::<JobRecord>(JOB, id.value(), row.value()) {
            add(&tables, &record)?;
        }
    }
    Ok(())
}

/// Whether each row names a job that has its digest.
pub(super) fn agree(txn: &ReadTransaction, jobs: &[JobRecord]) -> Result<bool, Refusal> {
    let keys: BTreeMap<&str, String> = jobs.iter().filter_map(|job| Some((job.id.as_str(), key(job)?))).collect();
    for row in txn.open_table(EQUAL).map_err(storage)?.iter().map_err(storage)? {
        let (row, id) = row.map_err(storage)?;
        if keys.get(id.value()).is_none_or(|key| key != row.value()) {
            return Ok(false);
        }
    }
    Ok(true)
}
