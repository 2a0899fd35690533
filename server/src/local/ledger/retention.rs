//! Ended jobs by the time of their end, and which of them are to go.
//!
//! Invariant: exactly the jobs that have ended are listed; those that wait or run never are.

use std::collections::BTreeSet;

use redb::{ReadTransaction, ReadableTable, ReadableTableMetadata, TableDefinition, WriteTransaction};

use super::{JOB, readable, storage};
use crate::ledger::record::Record;
use crate::ledger::{Ended, Keep};
use crate::local::store::Store;
use crate::reason::Refusal;

/// Time of the end and identity → bytes of log, files and results.
pub(super) const ENDED: TableDefinition<'_, (i64, &str), u64> = TableDefinition::new("ended");

/// Lists a job that has ended; gives the bytes that it was listed with before.
pub(super) fn list(txn: &WriteTransaction, record: &Record) -> Result<Option<u64>, Refusal> {
    let mut table = txn.open_table(ENDED).map_err(storage)?;
    let key = (record.ended_ms, record.id.as_str());
    let before = table.insert(key, record.runs.stored_bytes).map_err(storage)?;
    Ok(before.map(|bytes| bytes.value()))
}

/// Takes a job out of the list; gives its bytes.
pub(super) fn unlist(txn: &WriteTransaction, id: &str, ended_ms: i64) -> Result<u64, Refusal> {
    let mut table = txn.open_table(ENDED).map_err(storage)?;
    let before = table.remove((ended_ms, id)).map_err(storage)?;
    Ok(before.map_or(0, |bytes| bytes.value()))
}

/// All that are listed: time of the end and identity.
pub(super) fn listed(txn: &ReadTransaction) -> Result<BTreeSet<(i64, String)>, Refusal> {
    let mut listed = BTreeSet::new();
    for row in txn.open_table(ENDED).map_err(storage)?.iter().map_err(storage)? {
        let (key, _) = row.map_err(storage)?;
        let (ended_ms, id) = key.value();
        listed.insert((ended_ms, id.to_owned()));
    }
    Ok(listed)
}

/// Lists all jobs that have ended, with the bytes of their folders.
pub(super) fn list_all(txn: &WriteTransaction, store: &Store) -> Result<(), Refusal> {
    let mut ended = txn.open_table(ENDED).map_err(storage)?;
    ended.retain(|_, _| false).map_err(storage)?;
    let jobs = txn.open_table(JOB).map_err(storage)?;
    for row in jobs.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        if let Some(record) = readable::<Record>(id.value(), row.value()).filter(|record| record.state.ended()) {
            ended
                .insert((record.ended_ms, id.value()), store.job_bytes(id.value()).max(record.runs.stored_bytes))
                .map_err(storage)?;
        }
    }
    Ok(())
}

/// Up to `most` ended jobs beyond what is to be kept, oldest first.
pub(super) fn expired(txn: &ReadTransaction, keep: &Keep, now_ms: i64, most: usize) -> Result<Vec<Ended>, Refusal> {
    let table = txn.open_table(ENDED).map_err(storage)?;
    let mut jobs = table.len().map_err(storage)?;
    let mut bytes = 0u64;
    if keep.bytes.is_some() {
        for row in table.iter().map_err(storage)? {
            bytes = bytes.saturating_add(row.map_err(storage)?.1.value());
        }
    }
    let mut found = Vec::new();
    for row in table.iter().map_err(storage)? {
        let (key, size) = row.map_err(storage)?;
        let (ended_ms, id) = key.value();
        let over = keep.age_ms.is_some_and(|age| ended_ms < now_ms.saturating_sub(age))
            || keep.jobs.is_some_and(|most| jobs > most)
            || keep.bytes.is_some_and(|most| bytes > most);
        if !over || found.len() >= most {
            break;
        }
        jobs -= 1;
        bytes = bytes.saturating_sub(size.value());
        found.push(Ended { id: id.to_owned(), ended_ms });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use redb::{Database, ReadableDatabase};

    use super::*;
    use crate::ledger::record::State;
    use crate::ledger::record::tests::record;

    #[test]
    fn the_oldest_go_first_by_age_number_and_bytes() {
        let backend = redb::backends::InMemoryBackend::new();
        let database = Database::builder().create_with_backend(backend).unwrap();
        let txn = database.begin_write().unwrap();
        // Ended in another order than accepted.
        for (id, ended_ms, bytes) in [("a", 300, 10), ("b", 100, 20), ("c", 200, 30), ("d", 400, 40)] {
            let mut ended = Record { state: State::Succeeded, ended_ms, ..record(id) };
            ended.runs.stored_bytes = bytes;
            list(&txn, &ended).unwrap();
        }
        txn.commit().unwrap();
        let expired = |keep: Keep, most| -> String {
            let txn = database.begin_read().unwrap();
            expired(&txn, &keep, 1000, most).unwrap().into_iter().map(|job| job.id).collect()
        };
        let keep = Keep::default;
        assert_eq!(expired(keep(), 9), "");
        assert_eq!(expired(Keep { age_ms: Some(700), ..keep() }, 9), "bc");
        assert_eq!(expired(Keep { jobs: Some(1), ..keep() }, 9), "bca");
        assert_eq!(expired(Keep { jobs: Some(1), ..keep() }, 2), "bc");
        assert_eq!(expired(Keep { jobs: Some(4), ..keep() }, 9), "");
        assert_eq!(expired(Keep { bytes: Some(80), ..keep() }, 9), "b");
        assert_eq!(expired(Keep { bytes: Some(79), ..keep() }, 9), "bc");
        assert_eq!(expired(Keep { bytes: Some(0), age_ms: Some(1), ..keep() }, 9), "bcad");
        assert_eq!(expired(Keep { jobs: Some(3), age_ms: Some(750), bytes: Some(49) }, 9), "bca");
        let txn = database.begin_write().unwrap();
        unlist(&txn, "b", 100).unwrap();
        txn.commit().unwrap();
        assert_eq!(expired(Keep { jobs: Some(2), ..keep() }, 9), "c");
    }
}
