//! What is whole in a ledger with damaged pages, and a new ledger of it.
//!
//! Each table is read from both ends up to the damage, and each job that anything else names is looked up. *Invariant:*
//! a row is saved only with its checksum; lists, counts and request ids are made anew from the rows.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableHandle as _};

use super::writer::Place;
use super::{
    JOB, LOG, MACHINE, REQUEST, Rows, blob_refs, index, machine_bytes, retention, rows, schema, seal, storage, usage,
    works,
};
use crate::ledger::record::Record;
use crate::local::contained::{contained, damaged};
use crate::local::store::Store;
use crate::reason::Refusal;
use crate::tenant;

/// Number of openings of a ledger that does not tell it any more.
const EPOCH: u64 = 1 << 20;

type Contents = BTreeMap<String, Vec<u8>>;

/// The rows that are whole.
#[derive(Debug, Default)]
pub(crate) struct Saved {
    jobs: Contents,
    works: Contents,
    logs: Contents,
    machines: Contents,
    epoch: Option<u64>,
    files: bool,
}

/// Tries to read; damage counts as nothing.
fn attempt<T>(work: impl FnOnce() -> Result<T, Refusal>) -> Option<T> {
    contained(work).ok().and_then(Result::ok)
}

/// Rows of a table from both ends up to the damage.
fn from_both_ends(txn: &ReadTransaction, table: Rows<'_>, saved: &mut Contents) {
    for backwards in [false, true] {
        let Some(rows) = attempt(|| txn.open_table(table).map_err(storage)) else { return };
        let Some(mut iter) = attempt(|| rows.iter().map_err(storage)) else { continue };
        loop {
            let next = attempt(|| {
                let row = if backwards { iter.next_back() } else { iter.next() };
                let row = row.transpose().map_err(storage)?;
                Ok(row.map(|(key, row)| (key.value().to_owned(), row.value().to_vec())))
            });
            match next.flatten() {
                Some((key, row)) => {
                    if seal::content(table.name(), &key, &row).is_some() {
                        saved.insert(key, row);
                    }
                }
                None => break,
            }
        }
        let _ = contained(|| drop(iter));
    }
}

/// Rows of jobs by their identities.
fn by_identity(txn: &ReadTransaction, table: Rows<'_>, ids: &BTreeSet<String>, saved: &mut Contents) {
    for id in ids.iter().filter(|id| !saved.contains_key(*id)).cloned().collect::<Vec<_>>() {
        let row = attempt(|| {
            let rows = txn.open_table(table).map_err(storage)?;
            let row = rows.get(id.as_str()).map_err(storage)?;
            Ok(row.map(|row| row.value().to_vec()))
        });
        if let Some(row) = row.flatten().filter(|row| seal::content(table.name(), &id, row).is_some()) {
            saved.insert(id, row);
        }
    }
}

impl Saved {
    /// Reads what is whole in the ledger of a folder; nothing is written.
    ///
    /// # Errors
    /// When nothing can be read.
    pub(crate) fn read(store: &Store) -> Result<Self, Refusal> {
        let place = Place::File(store.ledger(), store.disk().clone());
        let mut best: Option<Self> = None;
        for database in place.states() {
            let mut saved = Self::default();
            if let Some(txn) = attempt(|| database.begin_read().map_err(storage)) {
                saved.collect(&txn, store);
                let _ = contained(|| drop(txn));
            }
            let _ = contained(|| drop(database));
            if best.as_ref().is_none_or(|best| saved.rows() > best.rows()) {
                best = Some(saved);
            }
        }
        best.filter(|saved| saved.rows() > 0).ok_or_else(damaged)
    }

    fn collect(&mut self, txn: &ReadTransaction, store: &Store) {
        let number = |key: &str| {
            let read =
                || Ok(txn.open_table(schema::META).map_err(storage)?.get(key).map_err(storage)?.map(|row| row.value()));
            attempt(read).flatten()
        };
        (self.epoch, self.files) = (number("epoch"), number("files").is_some());
        from_both_ends(txn, JOB, &mut self.jobs);
        from_both_ends(txn, works::WORK, &mut self.works);
        from_both_ends(txn, LOG, &mut self.logs);
        from_both_ends(txn, MACHINE, &mut self.machines);
        let mut ids: BTreeSet<String> = store.jobs().unwrap_or_default().into_iter().collect();
        ids.extend([&self.jobs, &self.works, &self.logs].into_iter().flat_map(Contents::keys).cloned());
        ids.extend(
            attempt(|| {
                let requests = txn.open_table(REQUEST).map_err(storage)?;
                Ok(requests
                    .iter()
                    .map_err(storage)?
                    .map_while(Result::ok)
                    .map(|(_, id)| id.value().to_owned())
                    .collect())
            })
            .unwrap_or_else(Vec::new),
        );
        by_identity(txn, JOB, &ids, &mut self.jobs);
        by_identity(txn, works::WORK, &ids, &mut self.works);
        by_identity(txn, LOG, &ids, &mut self.logs);
    }

    fn rows(&self) -> usize {
        self.jobs.len() + self.works.len() + self.logs.len() + self.machines.len()
    }

    /// Numbers of jobs and rows of machines.
    pub(crate) fn counts(&self) -> (usize, usize) {
        (self.jobs.len(), self.machines.len())
    }

    /// Puts a new ledger of these rows in the place of the damaged one, which is kept beside it.
    pub(crate) fn replace(&self, store: &Store) -> Result<(), Refusal> {
        let (old, new) = (store.ledger(), store.ledger().with_extension("redb.new"));
        match fs::remove_file(&new) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
        let place = Place::File(new.clone(), store.disk().clone());
        let database = place.open().map_err(storage)?;
        self.write(&database, store)?;
        drop(database);
        fs::rename(&old, old.with_extension("redb.damaged"))?;
        fs::rename(&new, &old)?;
        Ok(store.sync_root()?)
    }

    fn write(&self, database: &Database, store: &Store) -> Result<(), Refusal> {
        let txn = database.begin_write().map_err(storage)?;
        schema::migrate(&txn, store)?;
        for (table, saved) in
            [(JOB, &self.jobs), (works::WORK, &self.works), (LOG, &self.logs), (MACHINE, &self.machines)]
        {
            let mut rows = txn.open_table(table).map_err(storage)?;
            for (key, row) in saved {
                let plain = seal::is_plain(row).then(|| seal::bytes(table.name(), key, row));
                rows.insert(key.as_str(), plain.as_ref().unwrap_or(row).as_slice()).map_err(storage)?;
            }
        }
        works::split_all(&txn)?;
        {
            let mut requests = txn.open_table(REQUEST).map_err(storage)?;
            for (id, row) in &self.jobs {
                if let Some(record) = rows::readable::<Record>(JOB, id, row) {
                    let request = tenant::key(&record.tenant, &record.request_id);
                    requests.insert(request.as_str(), id.as_str()).map_err(storage)?;
                }
            }
            let mut meta = txn.open_table(schema::META).map_err(storage)?;
            meta.insert("epoch", self.epoch.unwrap_or(EPOCH)).map_err(storage)?;
            if self.files {
                meta.insert("files", 1).map_err(storage)?;
            }
        }
        blob_refs::count_all(&txn)?;
        retention::list_all(&txn, store)?;
        index::list_all(&txn)?;
        usage::count_all(&txn)?;
        machine_bytes::count_all(&txn)?;
        txn.commit().map_err(storage)
    }
}
