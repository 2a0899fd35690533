//! Compaction of the ledger file while the server runs.
//!
//! The writer copies its last state into a new file in `tmp`, renames that file to the ledger and opens it. Submits
//! wait meanwhile; open readers keep the old file. *Invariant:* the file with the name of the ledger always contains
//! every answered operation. A server that dies at any point starts with the old or the new file, which have the same
//! rows.

use std::io;
use std::time::Instant;

use redb::ReadableDatabase as _;
use redb::ReadableTableMetadata as _;
use redb::{Key, ReadTransaction, TableDefinition, Value};

use super::database::{LedgerDatabase, LedgerLocation};
use super::{JOB, LOG, MACHINE, REQUEST, checkup, machine_bytes, schema, storage};
use crate::ledger::Compacted;
use crate::local::contained::contained;
use crate::local::disk::DiskOperation;
use crate::local::named::PathContext as _;
use crate::local::store::DataFolder;
use crate::reason::Refusal;

/// Bytes of the pages that a table uses; 0 if the table does not exist.
fn used<K: Key + 'static, V: Value + 'static>(
    txn: &ReadTransaction,
    table: TableDefinition<'_, K, V>,
) -> Result<u64, Refusal> {
    let rows = match txn.open_table(table) {
        Err(redb::TableError::TableDoesNotExist(_)) => return Ok(0),
        other => other.map_err(storage)?,
    };
    let stats = rows.stats().map_err(storage)?;
    Ok(stats.stored_bytes() + stats.metadata_bytes() + stats.fragmented_bytes())
}

/// Bytes that the rows of all tables need, including page overhead.
pub(super) fn used_bytes(txn: &ReadTransaction) -> Result<u64, Refusal> {
    Ok(used(txn, schema::META)?
        + used(txn, JOB)?
        + used(txn, super::tables::WORK)?
        + used(txn, REQUEST)?
        + used(txn, MACHINE)?
        + used(txn, LOG)?
        + used(txn, super::tables::BLOB)?
        + used(txn, super::tables::ENDED)?
        + used(txn, super::tables::INDEX)?
        + used(txn, super::tables::EQUAL)?
        + used(txn, super::tables::USAGE)?
        + used(txn, machine_bytes::MACHINE_BYTES)?)
}

/// Compacts the file on the writer thread. The ledger is no longer writable if the new file cannot be opened after the
/// rename.
///
/// # Errors
/// The copy cannot be made; the ledger is unchanged.
pub(super) fn compact(shared: &LedgerDatabase, store: &DataFolder) -> Result<Compacted, Refusal> {
    let LedgerLocation::File(path, disk) = &shared.place else { return Ok(Compacted::default()) };
    let begin = Instant::now();
    let before = path.metadata().at(path)?.len();
    let copy = store.tmp().join("ledger.compact");
    match std::fs::remove_file(&copy) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
        _ => {}
    }
    let database = shared.current().ok_or_else(Refusal::unwritable_ledger)?;
    let copied = contained(|| checkup::copy(&database.begin_read().map_err(storage)?, &copy, store));
    let placed = copied.and_then(|copied| copied).and_then(|()| {
        if copy.metadata().at(&copy)?.len() >= before {
            // A small file has no less than its first pages.
            return Ok(std::fs::remove_file(&copy).at(&copy).map(|()| false)?);
        }
        disk.step(DiskOperation::Place, path).at(path)?;
        Ok(std::fs::rename(&copy, path).at(path).map(|()| true)?)
    });
    match placed {
        Ok(true) => {}
        Ok(false) => return Ok(Compacted { before, after: before, time: begin.elapsed() }),
        Err(error) => {
            let _ = std::fs::remove_file(&copy);
            return Err(error);
        }
    }
    // Open readers keep the old file until they finish.
    drop(database);
    shared.reopen();
    Ok(Compacted { before, after: path.metadata().at(path)?.len(), time: begin.elapsed() })
}

/// File size below which a copy is hardly smaller: a new file has one mebibyte.
const SMALL: u64 = 2 << 20;

impl Compacted {
    /// Whether a copy is worthwhile: the file is not small, and at least `least_free` bytes and half of it are free.
    pub(crate) fn worthwhile(file: u64, used: u64, least_free: u64) -> bool {
        let free = file.saturating_sub(used);
        file >= SMALL && least_free > 0 && free >= least_free && free >= file / 2
    }

    /// Bytes by which the file has shrunk.
    pub(crate) fn reclaimed(&self) -> u64 {
        self.before.saturating_sub(self.after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_file_must_be_free_and_as_much_as_configured() {
        let file = 10 * SMALL;
        assert!(Compacted::worthwhile(file, file - 6 * SMALL, 6 * SMALL));
        assert!(!Compacted::worthwhile(file, file - 6 * SMALL, 6 * SMALL + 1));
        assert!(!Compacted::worthwhile(file, 5 * SMALL + 1, 1), "less than half");
        assert!(!Compacted::worthwhile(file, 0, 0), "0 = only on command");
        assert!(!Compacted::worthwhile(SMALL - 1, 0, 1), "a copy is hardly smaller");
    }
}
