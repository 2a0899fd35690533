//! A smaller file for the ledger, while the server runs.
//!
//! The writer copies its last state into a new file in `tmp`, gives that file the name of the ledger and opens it.
//! Submits wait meanwhile; readers keep the file that they began with. *Invariant:* the file under the name of the
//! ledger always has every answered operation, so a server that dies at any point starts with the old file or the new
//! one, and each has the same rows.

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

/// Bytes of the pages that a table uses; none if there is no such table.
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

/// Bytes that the rows need, with their pages.
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

/// Makes the file smaller, on the thread of the writer. The ledger may not be writable afterwards: the new file has its
/// name then and could not be opened.
///
/// # Errors
/// The copy cannot be made: nothing has changed.
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
    // Readers that have begun keep the old file until they are done.
    drop(database);
    shared.reopen();
    Ok(Compacted { before, after: path.metadata().at(path)?.len(), time: begin.elapsed() })
}

impl Compacted {
    /// Whether so many free bytes are worth a copy: they are half of the file, too.
    pub(crate) fn worthwhile(file: u64, used: u64, least_free: u64) -> bool {
        let free = file.saturating_sub(used);
        least_free > 0 && free >= least_free && free >= file / 2
    }

    /// Bytes that the file has lost.
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
