//! What is whole in a ledger with damaged pages, and a new ledger of it.
//!
//! Each table is read from both ends up to the damage, and each job that anything else names is looked up. Rows that
//! the damage hides from their table are looked for in all pages. *Invariant:* a row is saved only with its checksum;
//! lists, counts and request ids are made anew from the rows.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use redb::TableHandle as _;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable};

use super::database::LedgerLocation;
use super::{
    JOB, LOG, MACHINE, REQUEST, Rows, blob_refs, equal, index, leaves, machine_bytes, parse, retention, rows, schema,
    seal, storage, usage, works,
};
use crate::ledger::record::{JobRecord, JobWork};
use crate::local::contained::{contained, damaged};
use crate::local::named::PathContext as _;
use crate::local::named::named;
use crate::local::store::DataFolder;
use crate::machines::MachineRecord;
use crate::reason::Refusal;
use crate::tenant;

type Contents = BTreeMap<String, Vec<u8>>;

/// The rows that are whole.
#[derive(Debug, Default)]
pub(crate) struct Saved {
    jobs: Contents,
    works: Contents,
    logs: Contents,
    machines: Contents,
    /// Keys of requests by the identities of their jobs.
    requests: BTreeMap<String, String>,
    /// Jobs of which only another row was found, or their request.
    lost: BTreeSet<String>,
    /// Jobs of rows that no table and no request names.
    doubtful: BTreeSet<String>,
    epoch: Option<u64>,
    files: bool,
    /// Tables that were read to their ends.
    whole: usize,
}

/// Tables with rows.
const TABLES: [Rows<'_>; 4] = [JOB, super::tables::WORK, LOG, MACHINE];

/// Tries to read; damage counts as nothing.
fn attempt<T>(work: impl FnOnce() -> Result<T, Refusal>) -> Option<T> {
    contained(work).ok().and_then(Result::ok)
}

/// Rows of a table from both ends up to the damage; whether all of them are whole.
fn from_both_ends(txn: &ReadTransaction, table: Rows<'_>, saved: &mut Contents) -> bool {
    let mut whole = false;
    for backwards in [false, true] {
        let Some(rows) = attempt(|| txn.open_table(table).map_err(storage)) else { return false };
        let Some(mut iter) = attempt(|| rows.iter().map_err(storage)) else { continue };
        let mut good = true;
        let ended = loop {
            let next = attempt(|| {
                let row = if backwards { iter.next_back() } else { iter.next() };
                let row = row.transpose().map_err(storage)?;
                Ok(row.map(|(key, row)| (key.value().to_owned(), row.value().to_vec())))
            });
            match next {
                Some(Some((key, row))) => match seal::content(table.name(), &key, &row) {
                    Some(_) => drop(saved.insert(key, row)),
                    None => good = false,
                },
                end => break end.is_some(),
            }
        };
        let _ = contained(|| drop(iter));
        if ended {
            whole = good;
            break;
        }
    }
    whole
}

/// Which of two rows under one key is the later one: of a job the one that has ended, of other rows the longer one.
fn later(table: usize, key: &str, one: &[u8], other: &[u8]) -> bool {
    if table == 0 {
        let ended = |row: &[u8]| rows::readable::<JobRecord>(JOB, key, row).is_some_and(|record| record.state.ended());
        return ended(one) && !ended(other);
    }
    one.len() > other.len()
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
    pub(crate) fn read(store: &DataFolder) -> Result<Self, Refusal> {
        let place = LedgerLocation::File(store.ledger(), store.disk().clone());
        let mut best: Option<Self> = None;
        let mut requests = BTreeMap::new();
        for mut database in place.states() {
            let mut saved = Self::default();
            // A tree with a wrong page may look whole.
            let sound = matches!(contained(|| database.check_integrity()), Ok(Ok(true)));
            if let Some(txn) = attempt(|| database.begin_read().map_err(storage)) {
                saved.collect(&txn, store);
                saved.whole = if sound { saved.whole } else { 0 };
                let _ = contained(|| drop(txn));
            }
            let _ = contained(|| drop(database));
            requests.extend(saved.requests.clone());
            if best.as_ref().is_none_or(|best| (saved.whole, saved.rows()) > (best.whole, best.rows())) {
                best = Some(saved);
            }
        }
        let mut best = best.unwrap_or_default();
        if !best.is_whole() {
            // Any state may name them; none is needed to be right.
            best.requests = requests;
            best.hidden(store)?;
            best.lost();
        }
        if best.rows() > 0 { Ok(best) } else { Err(damaged()) }
    }

    /// Whether no row is lost.
    pub(crate) fn is_whole(&self) -> bool {
        self.whole == TABLES.len()
    }

    /// Adds rows that the damage hides from their tables. A machine of which there are several definitions is left out:
    /// it is not known which of them counts.
    fn hidden(&mut self, store: &DataFolder) -> Result<(), Refusal> {
        let mut found: [Contents; 4] = Default::default();
        let mut unsure = BTreeSet::new();
        leaves::rows(&store.ledger(), &TABLES.each_ref().map(|table| table.name()), |table, key, row| {
            let Some(of_table) = found.get_mut(table) else { return };
            match of_table.get(key) {
                Some(known) if known == row => {}
                Some(_) if table == 3 => drop(unsure.insert(key.to_owned())),
                Some(known) if !later(table, key, row, known) => {}
                _ => drop(of_table.insert(key.to_owned(), row.to_vec())),
            }
        })?;
        let [.., machines] = &mut found;
        machines.retain(|key, _| !unsure.contains(key));
        let [jobs, ..] = &found;
        let unknown = |id: &&String| !self.jobs.contains_key(*id) && !self.requests.contains_key(*id);
        self.doubtful = jobs.keys().filter(unknown).cloned().collect();
        let saved = [&mut self.jobs, &mut self.works, &mut self.logs, &mut self.machines];
        for (saved, found) in saved.into_iter().zip(found) {
            for (key, row) in found {
                saved.entry(key).or_insert(row);
            }
        }
        Ok(())
    }

    /// Notes the jobs whose rows are not there, and leaves out what belongs to them: they are lost, or were removed
    /// before.
    fn lost(&mut self) {
        let named = self.requests.keys().chain(self.works.keys()).chain(self.logs.keys());
        self.lost = named.filter(|id| !self.jobs.contains_key(*id)).cloned().collect();
        self.works.retain(|id, _| self.jobs.contains_key(id));
        self.logs.retain(|id, _| self.jobs.contains_key(id));
    }

    /// Jobs that are lost, each with its request if that is known.
    pub(crate) fn lost_jobs(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        self.lost.iter().map(|id| (id.as_str(), self.requests.get(id).map(String::as_str)))
    }

    /// Jobs that may have been deleted before.
    pub(crate) fn doubtful_jobs(&self) -> impl Iterator<Item = &str> {
        self.doubtful.iter().map(String::as_str)
    }

    fn collect(&mut self, txn: &ReadTransaction, store: &DataFolder) {
        let number = |key: &str| {
            let read =
                || Ok(txn.open_table(schema::META).map_err(storage)?.get(key).map_err(storage)?.map(|row| row.value()));
            attempt(read).flatten()
        };
        (self.epoch, self.files) = (number("epoch"), number("files").is_some());
        let saved = [&mut self.jobs, &mut self.works, &mut self.logs, &mut self.machines];
        let whole =
            TABLES.into_iter().zip(saved).filter_map(|(table, saved)| from_both_ends(txn, table, saved).then_some(()));
        self.whole = whole.count();
        let mut ids: BTreeSet<String> = store.jobs().unwrap_or_default().into_iter().collect();
        ids.extend([&self.jobs, &self.works, &self.logs].into_iter().flat_map(Contents::keys).cloned());
        self.requests = attempt(|| {
            let requests = txn.open_table(REQUEST).map_err(storage)?;
            let rows = requests.iter().map_err(storage)?.map_while(Result::ok);
            Ok(rows.map(|(request, id)| (id.value().to_owned(), request.value().to_owned())).collect())
        })
        .unwrap_or_default();
        ids.extend(self.requests.keys().cloned());
        by_identity(txn, JOB, &ids, &mut self.jobs);
        by_identity(txn, super::tables::WORK, &ids, &mut self.works);
        by_identity(txn, LOG, &ids, &mut self.logs);
    }

    fn rows(&self) -> usize {
        self.jobs.len() + self.works.len() + self.logs.len() + self.machines.len()
    }

    /// Numbers of jobs and rows of machines that can be read. A repair removes the others from the new ledger.
    pub(crate) fn counts(&self) -> (usize, usize) {
        let jobs = self.jobs.iter().filter(|(id, row)| self.is_job(id, row)).count();
        let is_machine = |(key, row): &(&String, &Vec<u8>)| parse::<MachineRecord>(MACHINE, key, row).is_ok();
        (jobs, self.machines.iter().filter(is_machine).count())
    }

    /// Number of saved rows of jobs and machines that cannot be read, or whose work cannot.
    pub(crate) fn unreadable(&self) -> usize {
        let (jobs, machines) = self.counts();
        self.jobs.len() - jobs + self.machines.len() - machines
    }

    /// Whether a row of a job and its work can be read. In early ledgers the row itself has the work.
    fn is_job(&self, id: &str, row: &[u8]) -> bool {
        let has_work = match self.works.get(id) {
            Some(work) => parse::<JobWork>(super::tables::WORK, id, work).is_ok(),
            None => parse::<JobWork>(JOB, id, row).is_ok(),
        };
        has_work && parse::<JobRecord>(JOB, id, row).is_ok()
    }

    /// The place of the damaged ledger beside the new one; those of earlier repairs stay.
    pub(crate) fn kept(store: &DataFolder) -> PathBuf {
        let names = (2..).map(|number| format!("redb.damaged.{number}"));
        let names =
            std::iter::once("redb.damaged".to_owned()).chain(names).map(|name| store.ledger().with_extension(name));
        names.into_iter().find(|path| !path.exists()).unwrap_or_default()
    }

    /// Puts a new ledger of these rows in the place of the damaged one, which is kept beside it.
    pub(crate) fn replace(&self, store: &DataFolder) -> Result<(), Refusal> {
        let (old, new) = (store.ledger(), store.ledger().with_extension("redb.new"));
        match fs::remove_file(&new) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(named(&new, error).into()),
            _ => {}
        }
        let place = LedgerLocation::File(new.clone(), store.disk().clone());
        let written = place.open().and_then(|database| self.write(&database, store));
        if let Err(error) = written {
            let _ = fs::remove_file(&new);
            return Err(error);
        }
        let kept = Self::kept(store);
        fs::rename(&old, &kept).at(&kept)?;
        fs::rename(&new, &old).at(&old)?;
        Ok(store.sync_root()?)
    }

    fn write(&self, database: &Database, store: &DataFolder) -> Result<(), Refusal> {
        let txn = database.begin_write().map_err(storage)?;
        schema::migrate(&txn, store)?;
        for (table, saved) in
            [(JOB, &self.jobs), (super::tables::WORK, &self.works), (LOG, &self.logs), (MACHINE, &self.machines)]
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
                if let Some(record) = rows::readable::<JobRecord>(JOB, id, row) {
                    let request = tenant::key(&record.tenant, &record.request_id);
                    requests.insert(request.as_str(), id.as_str()).map_err(storage)?;
                }
            }
            let mut meta = txn.open_table(schema::META).map_err(storage)?;
            meta.insert("epoch", self.epoch.unwrap_or_default()).map_err(storage)?;
            if self.files {
                meta.insert("files", 1).map_err(storage)?;
            }
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
