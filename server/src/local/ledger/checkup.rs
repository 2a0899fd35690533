//! The ledger without a server: unreadable or inconsistent parts, and their repair.
//!
//! Invariant: a ledger that is only examined is not written; changes that opening it needs stay in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use bytes::Bytes;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition, WriteTransaction};

use super::database::LedgerLocation;
use super::tables::TransactionTables;
use super::{
    JOB, LOG, MACHINE, REQUEST, blob_refs, equal, index, machine_bytes, parse, retention, schema, storage, usage, works,
};
use crate::ledger::record::{JobRecord, JobWork};
use crate::local::store::DataFolder;
use crate::machines::MachineRecord;
use crate::reason::Refusal;

/// A ledger that no server has open.
#[derive(Debug)]
pub(crate) struct Checkup {
    database: Database,
    /// It has the form of an earlier version, without checksums.
    pub(crate) earlier: bool,
}

/// A row that cannot be read.
#[derive(Debug, Clone)]
pub(crate) struct Unreadable {
    /// It is that of a machine, otherwise of a job.
    pub(crate) machine: bool,
    pub(crate) key: String,
}

/// The content of the ledger.
#[derive(Debug, Default)]
pub(crate) struct LedgerContent {
    pub(crate) jobs: Vec<JobRecord>,
    /// Blobs that jobs and machines need: tenant and digest.
    pub(crate) blobs: BTreeSet<(String, String)>,
    pub(crate) unreadable: Vec<Unreadable>,
    /// Request ids whose job is not there.
    pub(crate) requests: Vec<String>,
    /// Logs and work whose job is not there.
    pub(crate) logs: Vec<String>,
    /// The counts of blobs, the lists of jobs or the usage of tenants do not agree with the rows.
    pub(crate) wrong_counts: bool,
}

impl Checkup {
    /// Opens the ledger of a folder, to be written only for a repair.
    pub(crate) fn open(store: &DataFolder, repair: bool) -> Result<Self, Refusal> {
        let place = LedgerLocation::File(store.ledger(), store.disk().clone());
        let database = if repair { place.open() } else { place.try_frozen() }?;
        let txn = database.begin_write().map_err(storage)?;
        let before = schema::migrate(&txn, store)?;
        if repair {
            schema::seal_files(&txn, store)?;
        }
        txn.commit().map_err(storage)?;
        Ok(Self { database, earlier: before.is_some_and(|before| before < schema::SCHEMA) })
    }

    /// Whether all pages of the ledger of a folder have their checksums; what is wrong, if not.
    pub(crate) fn sound(store: &DataFolder) -> Result<(), Refusal> {
        LedgerLocation::File(store.ledger(), store.disk().clone()).check()
    }

    /// Reads all rows.
    pub(crate) fn rows(&self) -> Result<LedgerContent, Refusal> {
        let txn = self.database.begin_read().map_err(storage)?;
        let mut rows = LedgerContent::default();
        let mut known = BTreeSet::new();
        let mut counts: BTreeMap<String, u64> = BTreeMap::new();
        let mut count = |digests: BTreeSet<String>| {
            digests.into_iter().for_each(|digest| *counts.entry(digest).or_default() += 1);
        };
        for row in txn.open_table(JOB).map_err(storage)?.iter().map_err(storage)? {
            let (id, row) = row.map_err(storage)?;
            known.insert(id.value().to_owned());
            match (parse::<JobRecord>(JOB, id.value(), row.value()), works::read(&txn, id.value())) {
                (Ok(record), Ok(Some(work))) => {
                    count(blob_refs::of_job(&record.tenant, &work));
                    rows.need(&record.tenant, &work);
                    rows.jobs.push(record);
                }
                _ => rows.unreadable.push(Unreadable { machine: false, key: id.value().to_owned() }),
            }
        }
        for row in txn.open_table(MACHINE).map_err(storage)?.iter().map_err(storage)? {
            let (name, row) = row.map_err(storage)?;
            match parse::<MachineRecord>(MACHINE, name.value(), row.value()) {
                Ok(definition) if name.value().contains('@') => {
                    count(blob_refs::of_machine(&definition));
                    rows.need_files(&definition);
                }
                Ok(_) => {}
                Err(_) => rows.unreadable.push(Unreadable { machine: true, key: name.value().to_owned() }),
            }
        }
        for row in txn.open_table(REQUEST).map_err(storage)?.iter().map_err(storage)? {
            let (request, id) = row.map_err(storage)?;
            if !known.contains(id.value()) {
                rows.requests.push(request.value().to_owned());
            }
        }
        for row in txn.open_table(LOG).map_err(storage)?.iter().map_err(storage)? {
            let (id, _) = row.map_err(storage)?;
            if !known.contains(id.value()) {
                rows.logs.push(id.value().to_owned());
            }
        }
        rows.logs.extend(works::listed(&txn)?.difference(&known).cloned());
        let mut stored = BTreeMap::new();
        for row in txn.open_table(super::tables::BLOB).map_err(storage)?.iter().map_err(storage)? {
            let (digest, count) = row.map_err(storage)?;
            stored.insert(digest.value().to_owned(), count.value());
        }
        let ended = rows.jobs.iter().filter(|record| record.state.ended());
        let ended: BTreeSet<_> = ended.map(|record| (record.ages_from(), record.id.clone())).collect();
        rows.wrong_counts = stored != counts
            || retention::listed(&txn)? != ended
            || index::listed(&txn)? != index::expected(rows.jobs.iter())
            || !equal::agree(&txn, &rows.jobs)?
            || !usage::agree(&txn, &rows.jobs)?
            || !machine_bytes::agree(&txn)?;
        Ok(rows)
    }

    /// The log of a job, if it is a row.
    pub(crate) fn log(&self, id: &str) -> Result<Option<Bytes>, Refusal> {
        let table = self.database.begin_read().map_err(storage)?.open_table(LOG).map_err(storage)?;
        let row = table.get(id).map_err(storage)?;
        row.map(|row| super::logged(id, row.value())).transpose()
    }

    /// Removes ended jobs.
    pub(crate) fn remove(&self, jobs: &[&JobRecord]) -> Result<(), Refusal> {
        let txn = self.database.begin_write().map_err(storage)?;
        let tables = TransactionTables::of(&txn);
        jobs.iter().try_for_each(|job| super::take_out(&tables, &job.id, job.ages_from()).map(drop))?;
        drop(tables);
        txn.commit().map_err(storage)
    }

    /// Removes rows that cannot be read or belong to nothing, and counts again.
    pub(crate) fn repair(&self, rows: &LedgerContent, store: &DataFolder) -> Result<(), Refusal> {
        let txn = self.database.begin_write().map_err(storage)?;
        for row in &rows.unreadable {
            let table = if row.machine { MACHINE } else { JOB };
            txn.open_table(table).map_err(storage)?.remove(row.key.as_str()).map_err(storage)?;
            txn.open_table(LOG).map_err(storage)?.remove(row.key.as_str()).map_err(storage)?;
            if !row.machine {
                works::remove(&TransactionTables::of(&txn), &row.key)?;
            }
        }
        let gone = |id: &str| rows.unreadable.iter().any(|row| !row.machine && row.key == id);
        txn.open_table(REQUEST)
            .map_err(storage)?
            .retain(|request, id| !gone(id) && !rows.requests.iter().any(|stray| stray == request))
            .map_err(storage)?;
        for id in &rows.logs {
            txn.open_table(LOG).map_err(storage)?.remove(id.as_str()).map_err(storage)?;
            works::remove(&TransactionTables::of(&txn), id)?;
        }
        blob_refs::count_all(&txn)?;
        retention::list_all(&txn, store)?;
        index::list_all(&txn)?;
        equal::list_all(&txn)?;
        usage::count_all(&txn)?;
        machine_bytes::count_all(&txn)?;
        txn.commit().map_err(storage)
    }
}

impl LedgerContent {
    /// Notes the blobs that a job needs.
    fn need(&mut self, tenant: &str, work: &JobWork) {
        self.blobs.extend(work.files.iter().map(|(_, digest)| (tenant.to_owned(), digest.clone())));
        self.need_files(&work.machine);
    }

    /// Notes the blobs that a machine needs.
    fn need_files(&mut self, machine: &MachineRecord) {
        self.blobs.extend(machine.files.values().map(|digest| (machine.tenant.clone(), digest.clone())));
    }
}

/// Copies the ledger of a folder that no server uses; none if there is none.
pub(crate) fn copy_ledger(store: &DataFolder, to: &Path) -> Result<(), Refusal> {
    super::not_lost(store)?;
    let place = LedgerLocation::File(store.ledger(), store.disk().clone());
    copy(&place.try_frozen()?.begin_read().map_err(storage)?, to, store)
}

/// Copies the state that a reader sees into a new file.
pub(super) fn copy(from: &ReadTransaction, to: &Path, store: &DataFolder) -> Result<(), Refusal> {
    let database = LedgerLocation::File(to.to_owned(), store.disk().clone()).open()?;
    let txn = database.begin_write().map_err(storage)?;
    copy_table(from, &txn, schema::META)?;
    copy_table(from, &txn, JOB)?;
    copy_table(from, &txn, super::tables::WORK)?;
    copy_table(from, &txn, REQUEST)?;
    copy_table(from, &txn, MACHINE)?;
    // A ledger of an early schema does not have these.
    copy_table(from, &txn, LOG)?;
    copy_table(from, &txn, super::tables::BLOB)?;
    copy_table(from, &txn, super::tables::ENDED)?;
    copy_table(from, &txn, super::tables::INDEX)?;
    copy_table(from, &txn, super::tables::EQUAL)?;
    copy_table(from, &txn, super::tables::USAGE)?;
    copy_table(from, &txn, machine_bytes::MACHINE_BYTES)?;
    txn.commit().map_err(storage)
}

fn copy_table<K: redb::Key + 'static, V: redb::Value + 'static>(
    from: &ReadTransaction,
    to: &WriteTransaction,
    table: TableDefinition<'_, K, V>,
) -> Result<(), Refusal> {
    let rows = match from.open_table(table) {
        Err(redb::TableError::TableDoesNotExist(_)) => return Ok(()),
        other => other.map_err(storage)?,
    };
    let mut copied = to.open_table(table).map_err(storage)?;
    for row in rows.iter().map_err(storage)? {
        let (key, value) = row.map_err(storage)?;
        copied.insert(key.value(), value.value()).map_err(storage)?;
    }
    Ok(())
}
