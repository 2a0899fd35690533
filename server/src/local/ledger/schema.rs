//! The form of the ledger: its number, and the path to it from every earlier one.
//!
//! A ledger of an earlier form is brought to this one when it is opened, in one transaction. Invariant: the file holds
//! the old form or the new one, never a mixture; a ledger of a later form is not touched.

use redb::TableHandle as _;
use redb::{ReadableTable, TableDefinition, WriteTransaction};

use super::{JOB, LOG, MACHINE, REQUEST, blob_refs, index, machine_bytes, retention, seal, storage, usage, works};
use crate::ledger::record::now_ms;
use crate::local::store::DataFolder;
use crate::reason::Refusal;

pub(super) const META: TableDefinition<'_, &str, u64> = TableDefinition::new("meta");

/// A step from one form to the next.
type Step = fn(&WriteTransaction, &DataFolder) -> Result<(), Refusal>;

/// The steps: the first leads from form 1 to form 2, and so on.
const STEPS: &[Step] =
    &[small_logs, blob_counts, ended_jobs, tenants, terms_and_usage, ended_of_tenants, works_of_jobs, all_bytes, seals];

/// The form that this server writes.
pub(super) const SCHEMA: u64 = 1 + STEPS.len() as u64;

/// Brings a ledger to the form of this server, or creates its tables. Returns the form that it had, if it had one.
pub(super) fn migrate(txn: &WriteTransaction, store: &DataFolder) -> Result<Option<u64>, Refusal> {
    let before = txn.open_table(META).map_err(storage)?.get("schema").map_err(storage)?.map(|row| row.value());
    if let Some(later) = before.filter(|before| *before > SCHEMA) {
        return Err(Refusal::DataLoss(format!(
            "has schema {later}, written by a later version; this version reads schema 1 to {SCHEMA}: start the later \
             version, or restore a backup made before the ledger was opened by it"
        )));
    }
    txn.open_table(JOB).map_err(storage)?;
    txn.open_table(REQUEST).map_err(storage)?;
    txn.open_table(MACHINE).map_err(storage)?;
    // A version without this table may leave rows that name deleted jobs.
    txn.open_table(super::tables::EQUAL).map_err(storage)?;
    let done = before.unwrap_or(1).saturating_sub(1);
    for step in STEPS.iter().skip(usize::try_from(done).unwrap_or(usize::MAX)) {
        step(txn, store)?;
    }
    txn.open_table(META).map_err(storage)?.insert("schema", SCHEMA).map_err(storage)?;
    Ok(before)
}

/// 1 → 2: logs of at most 16 KiB are rows of the ledger. Those of earlier jobs stay in their files.
fn small_logs(txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    txn.open_table(LOG).map(drop).map_err(storage)
}

/// 2 → 3: rows that need each blob are counted.
fn blob_counts(txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    blob_refs::count_all(txn)
}

/// 3 → 4: ended jobs are listed by the time of their end, with their bytes.
fn ended_jobs(txn: &WriteTransaction, store: &DataFolder) -> Result<(), Refusal> {
    retention::list_all(txn, store)
}

/// 4 → 5: rows belong to tenants; earlier ones to the tenant `default`, which changes nothing in them.
fn tenants(_txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    Ok(())
}

/// 5 → 6: jobs are listed by state, machine and label, and the usage of tenants is counted.
fn terms_and_usage(txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    index::list_all(txn)?;
    usage::count_all(txn)
}

/// 6 → 7: ended jobs are listed with their tenants, and the time that tenants have used is processor time in µs. The
/// time by the clock of the last day counts as such.
fn ended_of_tenants(txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    retention::with_tenants(txn)?;
    usage::count_all(txn)?;
    usage::in_micros(txn)
}

/// 7 → 8: the work of a job is a row of its own.
fn works_of_jobs(txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    works::split_all(txn)
}

/// 8 → 9: the bytes of requests and machines count.
fn all_bytes(txn: &WriteTransaction, store: &DataFolder) -> Result<(), Refusal> {
    retention::list_all(txn, store)?;
    usage::count_all(txn)?;
    machine_bytes::count_all(txn)
}

/// 9 → 10: every row of a job, a machine, a log and a work has a checksum.
fn seals(txn: &WriteTransaction, _store: &DataFolder) -> Result<(), Refusal> {
    for table in [JOB, super::tables::WORK, MACHINE, LOG] {
        let mut rows = txn.open_table(table).map_err(storage)?;
        let mut plain = Vec::new();
        for row in rows.iter().map_err(storage)? {
            let (key, row) = row.map_err(storage)?;
            if seal::is_plain(row.value()) {
                plain.push(key.value().to_owned());
            }
        }
        for key in plain {
            let content = rows.get(key.as_str()).map_err(storage)?.map(|row| row.value().to_vec()).unwrap_or_default();
            rows.insert(key.as_str(), seal::bytes(table.name(), &key, &content).as_slice()).map_err(storage)?;
        }
    }
    machine_bytes::count_all(txn)
}

/// Gives the files of macros of earlier versions their checksums, once.
pub(super) fn seal_files(txn: &WriteTransaction, store: &DataFolder) -> Result<(), Refusal> {
    let mut table = txn.open_table(META).map_err(storage)?;
    if table.get("files").map_err(storage)?.is_none() {
        if store.durable() {
            store.seal_files()?;
        }
        table.insert("files", 1).map_err(storage)?;
    }
    Ok(())
}

/// Stores the time by which jobs age.
pub(super) fn keep_highest(txn: &WriteTransaction, ms: i64) -> Result<(), Refusal> {
    let ms = u64::try_from(ms).unwrap_or(0);
    txn.open_table(META).map_err(storage)?.insert("clock_ms", ms).map_err(storage)?;
    Ok(())
}

/// The highest time by which jobs aged: as it was stored, or the end of the last job. 0: an early version has stored
/// none, and no job has ended later than now.
pub(super) fn highest(txn: &WriteTransaction) -> Result<i64, Refusal> {
    let stored = txn.open_table(META).map_err(storage)?.get("clock_ms").map_err(storage)?.map(|row| row.value());
    let ended = txn.open_table(super::tables::ENDED).map_err(storage)?;
    let last = ended.last().map_err(storage)?.map_or(0, |(key, _)| key.value().0);
    Ok(match stored {
        None if last <= now_ms() => 0,
        stored => i64::try_from(stored.unwrap_or(0)).unwrap_or(0).max(last),
    })
}

/// 2026-01-01, ms since 1970.
const FIRST_EPOCH_MS: i64 = 1_767_225_600_000;

/// The number of this opening: the milliseconds since 2026, or the number after the last one. A ledger and the one that
/// was restored from its backup both continue, and no number of one of them may be that of the other.
pub(super) fn next_epoch(txn: &WriteTransaction) -> Result<u64, Refusal> {
    let mut table = txn.open_table(META).map_err(storage)?;
    let since = u64::try_from(now_ms() - FIRST_EPOCH_MS).unwrap_or(0);
    let epoch = table.get("epoch").map_err(storage)?.map_or(0, |row| row.value()).saturating_add(1).max(since);
    table.insert("epoch", epoch).map_err(storage)?;
    Ok(epoch)
}
