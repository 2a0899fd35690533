//! Compaction of the ledger file while the server runs.
//!
//! The writer copies its last state into a new file in `tmp`, renames that file to the ledger and opens it. Submits
//! wait meanwhile; open readers keep the old file. *Invariant:* the file with the name of the ledger always contains
//! every answered operation. A server that dies at any point starts with the old or the new file, which have the same
//! rows.

use std::io;
use std::time::Instant;

use redb::{Key, ReadTransaction, ReadableDatabase as _, ReadableTableMetadata as _, TableDefinition, Value};

use super::writer::{Place, Shared};
use super::{
    JOB, LOG, MACHINE, REQUEST, blob_refs, checkup, index, machine_bytes, retention, schema, storage, usage, works,
};
use crate::ledger::Compacted;
use crate::local::contained::contained;
use crate::local::disk::Step;
use crate::local::named::Named as _;
use crate::local::store::Store;
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
        + used(txn, works::WORK)?
        + used(txn, REQUEST)?
        + used(txn, MACHINE)?
        + used(txn, LOG)?
        + used(txn, blob_refs::BLOB)?
        + used(txn, retention::ENDED)?
        + used(txn, index::INDEX)?
        + used(txn, usage::USAGE)?
        + used(txn, machine_bytes::MACHINE_BYTES)?)
}

/// Compacts the file on the writer thread. The ledger is no longer writable if the new file cannot be opened after the
/// rename.
///
/// # Errors
/// The copy cannot be made; the ledger is unchanged.
pub(super) fn compact(shared: &Shared, store: &Store) -> Result<Compacted, Refusal> {
    let Place::File(path, disk) = &shared.place else { return Ok(Compacted::default()) };
    let begin = Instant::now();
    let before = path.metadata().at(path)?.len();
    let copy = store.tmp().join("ledger.compact");
    match std::fs::remove_file(&copy) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
        _ => {}
    }
    let database = shared.current().ok_or_else(super::closed)?;
    let copied = contained(|| checkup::copy(&database.begin_read().map_err(storage)?, &copy, store));
    let placed = copied.and_then(|copied| copied).and_then(|()| {
        disk.step(Step::Place, path).at(path)?;
        Ok(std::fs::rename(&copy, path).at(path)?)
    });
    if let Err(error) = placed {
        let _ = std::fs::remove_file(&copy);
        return Err(error);
    }
    // Open readers keep the old file until they finish.
    drop(database);
    shared.reopen();
    Ok(Compacted { before, after: path.metadata().at(path)?.len(), time: begin.elapsed() })
}

impl Compacted {
    /// Whether a copy is worthwhile: at least `least_free` bytes and half of the file are free.
    pub(crate) fn worthwhile(file: u64, used: u64, least_free: u64) -> bool {
        let free = file.saturating_sub(used);
        least_free > 0 && free >= least_free && free >= file / 2
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
        assert!(Compacted::worthwhile(1000, 400, 600));
        assert!(!Compacted::worthwhile(1000, 400, 601));
        assert!(!Compacted::worthwhile(1000, 501, 1), "less than half");
        assert!(!Compacted::worthwhile(1000, 0, 0), "0 = only on command");
    }
}
