//! How many rows of the ledger need each blob.
//!
//! A job needs its files and those of its machine, a revision of a machine needs its own. Invariant: the counts change
//! in the transaction that adds or removes the row, so a blob without a count is needed by nothing.

use std::collections::BTreeSet;

use redb::{ReadableTable, WriteTransaction};

use super::tables::{BLOB, TransactionTables};
use super::{JOB, MACHINE, readable, storage, works};
use crate::ledger::record::{JobRecord, JobWork};
use crate::machines::MachineRecord;
use crate::reason::Refusal;
use crate::tenant;

/// Keys of the blobs that a job needs.
pub(super) fn of_job(tenant: &str, work: &JobWork) -> BTreeSet<String> {
    let own = work.files.iter().map(|(_, digest)| tenant::key(tenant, digest));
    own.chain(of_machine(&work.machine)).collect()
}

/// Keys of the blobs that a revision of a machine needs.
pub(super) fn of_machine(definition: &MachineRecord) -> BTreeSet<String> {
    definition.files.values().map(|digest| tenant::key(&definition.tenant, digest)).collect()
}

/// One more row needs these.
pub(super) fn add(tables: &TransactionTables<'_>, digests: &BTreeSet<String>) -> Result<(), Refusal> {
    let mut table = tables.blob()?;
    for digest in digests {
        let count = table.get(digest.as_str()).map_err(storage)?.map_or(0, |count| count.value());
        table.insert(digest.as_str(), count.saturating_add(1)).map_err(storage)?;
    }
    Ok(())
}

/// One row less needs these.
pub(super) fn subtract(tables: &TransactionTables<'_>, digests: &BTreeSet<String>) -> Result<(), Refusal> {
    let mut table = tables.blob()?;
    for digest in digests {
        let count = table.get(digest.as_str()).map_err(storage)?.map_or(0, |count| count.value());
        match count {
            0 => {}
            1 => drop(table.remove(digest.as_str()).map_err(storage)?),
            count => drop(table.insert(digest.as_str(), count - 1).map_err(storage)?),
        }
    }
    Ok(())
}

/// Counts the blobs that all rows need.
pub(super) fn count_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    txn.open_table(BLOB).map_err(storage)?.retain(|_, _| false).map_err(storage)?;
    let (tables, jobs) = (TransactionTables::of(txn), txn.open_table(JOB).map_err(storage)?);
    for row in jobs.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        let Some(record) = readable::<JobRecord>(JOB, id.value(), row.value()) else { continue };
        if let Some(work) = works::anywhere(txn, id.value(), row.value())? {
            add(&tables, &of_job(&record.tenant, &work))?;
        }
    }
    let machines = txn.open_table(MACHINE).map_err(storage)?;
    for row in machines.iter().map_err(storage)? {
        let (name, row) = row.map_err(storage)?;
        // The row without a revision holds the same definition as that of its newest one.
        if let Some(definition) =
            readable::<MachineRecord>(MACHINE, name.value(), row.value()).filter(|_| name.value().contains('@'))
        {
            add(&tables, &of_machine(&definition))?;
        }
    }
    Ok(())
}
