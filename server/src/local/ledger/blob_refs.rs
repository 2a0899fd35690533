//! How many rows of the ledger need each blob.
//!
//! A job needs its files and those of its machine, a revision of a machine needs its own. Invariant: the counts change
//! in the transaction that adds or removes the row, so a blob without a count is needed by nothing.

use std::collections::BTreeSet;

use redb::{ReadableTable, TableDefinition, WriteTransaction};

use super::{JOB, MACHINE, readable, storage};
use crate::ledger::record::Record;
use crate::machines::Definition;
use crate::reason::Refusal;

/// Digest → rows that need it; never 0.
pub(super) const BLOB: TableDefinition<'_, &str, u64> = TableDefinition::new("blob");

/// Digests that a job needs.
pub(super) fn of_job(record: &Record) -> BTreeSet<&str> {
    record.files.iter().map(|(_, digest)| digest.as_str()).chain(of_machine(&record.machine)).collect()
}

/// Digests that a revision of a machine needs.
pub(super) fn of_machine(definition: &Definition) -> BTreeSet<&str> {
    definition.files.values().map(String::as_str).collect()
}

/// One more row needs these.
pub(super) fn add(txn: &WriteTransaction, digests: &BTreeSet<&str>) -> Result<(), Refusal> {
    let mut table = txn.open_table(BLOB).map_err(storage)?;
    for digest in digests {
        let count = table.get(digest).map_err(storage)?.map_or(0, |count| count.value());
        table.insert(digest, count.saturating_add(1)).map_err(storage)?;
    }
    Ok(())
}

/// One row less needs these.
pub(super) fn subtract(txn: &WriteTransaction, digests: &BTreeSet<&str>) -> Result<(), Refusal> {
    let mut table = txn.open_table(BLOB).map_err(storage)?;
    for digest in digests {
        let count = table.get(digest).map_err(storage)?.map_or(0, |count| count.value());
        match count {
            0 => {}
            1 => drop(table.remove(digest).map_err(storage)?),
            count => drop(table.insert(digest, count - 1).map_err(storage)?),
        }
    }
    Ok(())
}

/// Counts what all rows need.
pub(super) fn count_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    txn.open_table(BLOB).map_err(storage)?.retain(|_, _| false).map_err(storage)?;
    let jobs = txn.open_table(JOB).map_err(storage)?;
    for row in jobs.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        if let Some(record) = readable::<Record>(id.value(), row.value()) {
            add(txn, &of_job(&record))?;
        }
    }
    let machines = txn.open_table(MACHINE).map_err(storage)?;
    for row in machines.iter().map_err(storage)? {
        let (name, row) = row.map_err(storage)?;
        // The row without a revision holds the same definition as that of its newest one.
        if let Some(definition) =
            readable::<Definition>(name.value(), row.value()).filter(|_| name.value().contains('@'))
        {
            add(txn, &of_machine(&definition))?;
        }
    }
    Ok(())
}
