//! The work of each job, in a table of its own: a change of state does not write it again, and a list does not read it.
//!
//! Invariant: from schema 8 on every job has a row here; before, its work is in the row of the job itself.

use std::collections::BTreeSet;

use redb::TableHandle as _;
use redb::{ReadTransaction, ReadableTable, WriteTransaction};

use super::tables::{TransactionTables, WORK};
use super::{JOB, parse, readable, seal, storage};
use crate::ledger::record::{JobRecord, JobWork};
use crate::reason::Refusal;

/// Stores the work of a job.
pub(super) fn put(tables: &TransactionTables<'_>, id: &str, work: &JobWork) -> Result<(), Refusal> {
    let bytes = seal::json(WORK.name(), id, work)?;
    tables.work()?.insert(id, bytes.as_slice()).map_err(storage)?;
    Ok(())
}

/// The work of a job, if there is one.
pub(super) fn get(tables: &TransactionTables<'_>, id: &str) -> Result<Option<JobWork>, Refusal> {
    let table = tables.work()?;
    let row = table.get(id).map_err(storage)?;
    row.map(|row| parse(WORK, id, row.value())).transpose()
}

/// The work of a job as a reader sees it.
pub(super) fn read(txn: &ReadTransaction, id: &str) -> Result<Option<JobWork>, Refusal> {
    let table = txn.open_table(WORK).map_err(storage)?;
    let row = table.get(id).map_err(storage)?;
    row.map(|row| parse(WORK, id, row.value())).transpose()
}

/// Bytes of the work of a job.
pub(super) fn bytes(tables: &TransactionTables<'_>, id: &str) -> Result<u64, Refusal> {
    let table = tables.work()?;
    Ok(table.get(id).map_err(storage)?.map_or(0, |row| row.value().len() as u64))
}

/// Removes the work of a job and returns it, if it can be read.
pub(super) fn remove(tables: &TransactionTables<'_>, id: &str) -> Result<Option<JobWork>, Refusal> {
    let mut table = tables.work()?;
    let row = table.remove(id).map_err(storage)?;
    Ok(row.and_then(|row| readable(WORK, id, row.value())))
}

/// The work of a job wherever a ledger of any schema has it; `row` is the row of the job.
pub(super) fn anywhere(txn: &WriteTransaction, id: &str, row: &[u8]) -> Result<Option<JobWork>, Refusal> {
    match txn.open_table(WORK).map_err(storage)?.get(id).map_err(storage)? {
        Some(work) => Ok(readable(WORK, id, work.value())),
        None => Ok(readable(JOB, id, row)),
    }
}

/// Identities of all jobs whose work is here.
pub(super) fn listed(txn: &ReadTransaction) -> Result<BTreeSet<String>, Refusal> {
    let mut listed = BTreeSet::new();
    for row in txn.open_table(WORK).map_err(storage)?.iter().map_err(storage)? {
        listed.insert(row.map_err(storage)?.0.value().to_owned());
    }
    Ok(listed)
}

/// Takes the work of all jobs out of their rows. A row that cannot be read stays as it is.
pub(super) fn split_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    let mut jobs = txn.open_table(JOB).map_err(storage)?;
    let mut ids = Vec::new();
    {
        let works = txn.open_table(WORK).map_err(storage)?;
        for row in jobs.iter().map_err(storage)? {
            let (id, _) = row.map_err(storage)?;
            if works.get(id.value()).map_err(storage)?.is_none() {
                ids.push(id.value().to_owned());
            }
        }
    }
    for id in ids {
        let Some(row) = jobs.get(id.as_str()).map_err(storage)?.map(|row| row.value().to_vec()) else { continue };
        let (Some(record), Some(work)) = (readable::<JobRecord>(JOB, &id, &row), readable::<JobWork>(JOB, &id, &row))
        else {
            continue;
        };
        put(&TransactionTables::of(txn), &id, &work)?;
        let (attended, stepped) = (work.options.attended, work.options.stepped);
        let bytes = seal::json(JOB.name(), &id, &JobRecord { attended, stepped, ..record })?;
        jobs.insert(id.as_str(), bytes.as_slice()).map_err(storage)?;
    }
    Ok(())
}
