//! The ledger in one transactional file of the data folder.
//!
//! One writer thread ([`writer`]) takes operations from a bounded queue and commits them in groups. Readers use
//! snapshots. Invariant: the ledger is written by that thread only.

pub(crate) mod backups;
mod blob_refs;
pub(crate) mod checkup;
mod compact;
mod database;
mod equal;
mod file;
mod index;
mod leaves;
mod lost;
mod machine_bytes;
mod machines;
mod pace;
pub(crate) mod retention;
mod rows;
pub(crate) mod salvage;
mod schema;
mod seal;
mod tables;
mod usage;
mod works;
mod writer;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::thread::JoinHandle;

use bytes::Bytes;
use database::{LedgerDatabase, LedgerLocation};
use redb::TableHandle as _;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition};
use rows::{clear, flag_cancel, get, next_job, parse, put, readable, renew, same, take_out};
use tables::TransactionTables;
use tokio::sync::{mpsc, oneshot, watch};
use uuid::{NoContext, Timestamp, Uuid};
use writer::LedgerOperation;

use super::contained::contained;
use super::store::DataFolder;
use crate::ledger::record::{JobRecord, JobWork};
use crate::ledger::settled::Settled;
use crate::ledger::{
    Accepted, Check, Compacted, EndedJob, Keep, Ledger, NewJob, Page, Query, SubmitOutcome, Then, Usage,
};
use crate::log::damage::{damage, of_job};
use crate::machines::MachineRecord;
use crate::metrics::Metrics;
use crate::reason::Refusal;
use crate::tenant;

pub(crate) use lost::{damaged_by, lost, lost_for_good, not_lost, unopened_by};

const JOB: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("job");
const REQUEST: TableDefinition<'_, &str, &str> = TableDefinition::new("request_id");
const MACHINE: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("machine");
const LOG: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("log");

/// A table whose rows have a checksum.
type Rows<'a> = TableDefinition<'a, &'static str, &'static [u8]>;

/// Handle on the ledger.
#[derive(Debug)]
pub(crate) struct LocalLedger {
    store: DataFolder,
    shared: Arc<LedgerDatabase>,
    epoch: u64,
    highest_ms: i64,
    operations: RwLock<Option<mpsc::Sender<LedgerOperation>>>,
    writer: Mutex<Option<JoinHandle<()>>>,
}

fn storage(error: impl std::fmt::Display) -> Refusal {
    Refusal::Storage(error.to_string())
}

/// The log in a row.
fn logged(id: &str, row: &[u8]) -> Result<Bytes, Refusal> {
    let content = seal::content(LOG.name(), id, row);
    content
        .map(Bytes::copy_from_slice)
        .ok_or_else(|| of_job(damage("its row in the ledger has a wrong checksum"), id).into())
}

/// A number for a tenant; 0 for the server itself, whose name is empty.
fn number(tenant: &str) -> u64 {
    if tenant.is_empty() { 0 } else { u64::from(crc32fast::hash(tenant.as_bytes())) + 1 }
}

/// An answer that is given in any case.
struct Reply(Option<Then>);

impl Reply {
    fn give(mut self, result: Result<(), Refusal>) {
        if let Some(then) = self.0.take() {
            then(result);
        }
    }
}

impl Drop for Reply {
    fn drop(&mut self) {
        if let Some(then) = self.0.take() {
            then(Err(Refusal::unwritable_ledger()));
        }
    }
}

/// Marks the ledger as not writable when its writer ends for any reason.
struct WriterEnd(Arc<LedgerDatabase>);

impl Drop for WriterEnd {
    fn drop(&mut self) {
        self.0.writable.send_replace(false);
    }
}

impl LocalLedger {
    /// Opens or creates the ledger.
    pub(crate) fn open(store: &DataFolder, metrics: Arc<Metrics>) -> Result<Self, Refusal> {
        let place = if store.durable() {
            LedgerLocation::File(store.ledger(), store.disk().clone())
        } else {
            LedgerLocation::Memory
        };
        not_lost(store)?;
        if store.ledger().metadata().is_ok_and(|meta| meta.len() > 0) {
            place.check().map_err(|why| damaged_by(store, why))?;
        }
        let database = place.open().map_err(|why| unopened_by(store, why))?;
        store.sync_root()?;
        let txn = database.begin_write().map_err(storage)?;
        let before = schema::migrate(&txn, store).map_err(|refusal| match refusal {
            Refusal::DataLoss(text) => Refusal::DataLoss(format!("{} {text}", store.ledger().display())),
            other => other,
        })?;
        schema::seal_files(&txn, store)?;
        let (epoch, highest_ms) = (schema::next_epoch(&txn)?, schema::highest(&txn)?);
        txn.commit().map_err(storage)?;
        if let Some(before) = before.filter(|before| *before < schema::SCHEMA) {
            tracing::info!(before, now = schema::SCHEMA, "the ledger has been brought to the schema of this version");
        }
        let database = RwLock::new(Some(Arc::new(database)));
        let writable = watch::Sender::new(true);
        let shared = Arc::new(LedgerDatabase { place, database, writable, metrics, compactions: Mutex::default() });
        let (operations, queue) = mpsc::channel(1024);
        let (own, folder) = (shared.clone(), store.clone());
        let work = move || {
            let _closes = WriterEnd(own.clone());
            writer::write(&own, &folder, queue);
        };
        let writer = std::thread::Builder::new().name("ledger".to_owned()).spawn(work)?;
        Ok(Self {
            store: store.clone(),
            shared,
            epoch,
            highest_ms,
            operations: RwLock::new(Some(operations)),
            writer: Mutex::new(Some(writer)),
        })
    }

    fn operations(&self) -> Result<mpsc::Sender<LedgerOperation>, Refusal> {
        self.operations.read().unwrap_or_else(PoisonError::into_inner).clone().ok_or_else(Refusal::unwritable_ledger)
    }

    /// A reader, and its database: it closes its file when it is dropped, also under readers.
    fn snapshot(&self) -> Result<(Arc<Database>, ReadTransaction), Refusal> {
        let database = self.shared.current().ok_or_else(Refusal::unwritable_ledger)?;
        let txn = database.begin_read().map_err(storage)?;
        Ok((database, txn))
    }

    /// Reads; damage that the database meets is an error.
    fn read<T>(&self, work: impl FnOnce(&ReadTransaction) -> Result<T, Refusal>) -> Result<T, Refusal> {
        let (database, txn) = contained(|| self.snapshot())??;
        let done = contained(|| work(&txn));
        contained(|| drop((txn, database)))?;
        done?
    }

    fn operation<R: Send + 'static>(
        tenant: &str,
        work: impl FnOnce(&TransactionTables<'_>) -> Result<R, Refusal> + Send + 'static,
        then: impl FnOnce(&R) + Send + 'static,
    ) -> (LedgerOperation, oneshot::Receiver<Result<R, Refusal>>) {
        let (answer, answered) = oneshot::channel();
        let work: writer::Work = Box::new(move |tables| {
            let result = work(tables);
            Box::new(move |committed| {
                let result = committed.and(result);
                if let Ok(done) = &result {
                    then(done);
                }
                drop(answer.send(result));
            })
        });
        (LedgerOperation { tenant: number(tenant), work }, answered)
    }

    /// Does `work` in a transaction; answers after the commit. `work` must decide before it writes.
    async fn write<R: Send + 'static>(
        &self,
        work: impl FnOnce(&TransactionTables<'_>) -> Result<R, Refusal> + Send + 'static,
    ) -> Result<R, Refusal> {
        let (operation, answered) = Self::operation("", work, |_| ());
        self.operations()?.send(operation).await.map_err(|_| Refusal::unwritable_ledger())?;
        answered.await.map_err(|_| Refusal::unwritable_ledger())?
    }

    /// Same as [`write`](Self::write) from a thread that may block.
    fn write_blocking<R: Send + 'static>(
        &self,
        work: impl FnOnce(&TransactionTables<'_>) -> Result<R, Refusal> + Send + 'static,
    ) -> Result<R, Refusal> {
        let (operation, answered) = Self::operation("", work, |_| ());
        self.operations()?.blocking_send(operation).map_err(|_| Refusal::unwritable_ledger())?;
        answered.blocking_recv().map_err(|_| Refusal::unwritable_ledger())?
    }
}

#[tonic::async_trait]
impl Ledger for LocalLedger {
    fn close(&self) {
        drop(self.operations.write().unwrap_or_else(PoisonError::into_inner).take());
        let writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner).take();
        // The writer itself may drop the last handle.
        if let Some(writer) = writer.filter(|writer| writer.thread().id() != std::thread::current().id()) {
            let _ = writer.join();
        }
        self.shared.writable.send_replace(false);
        *self.shared.database.write().unwrap_or_else(PoisonError::into_inner) = None;
    }

    fn writable(&self) -> watch::Receiver<bool> {
        self.shared.writable.subscribe()
    }

    async fn submit(
        &self,
        job: Box<NewJob>,
        check: Check<JobWork>,
        accepted: Accepted,
    ) -> Result<SubmitOutcome, Refusal> {
        let tenant = job.record.tenant.clone();
        let submit = move |tables: &TransactionTables<'_>| {
            let NewJob { mut record, work } = *job;
            let mut requests = tables.request()?;
            let request = tenant::key(&record.tenant, &record.request_id);
            let known = requests.get(request.as_str()).map_err(storage)?.map(|id| id.value().to_owned());
            if let Some(known) = known.map(|id| get(tables, &id)).transpose()?.flatten() {
                return same(tables, known, &record, &work);
            }
            check(&work)?;
            // `Uuid::now_v7` would keep the time of a clock that was ahead once.
            let now = Uuid::new_v7(Timestamp::now(NoContext));
            (record.id, record.submitted_ms) = next_job(tables, now)?;
            put(tables, &record)?;
            works::put(tables, &record.id, &work)?;
            index::add(tables, &record)?;
            blob_refs::add(tables, &blob_refs::of_job(&record.tenant, &work))?;
            requests.insert(request.as_str(), record.id.as_str()).map_err(storage)?;
            Ok(SubmitOutcome::New(Box::new(record)))
        };
        let (operation, answered) = Self::operation(&tenant, submit, |submitted| {
            if let SubmitOutcome::New(record) = submitted {
                accepted(record);
            }
        });
        self.operations()?.send(operation).await.map_err(|_| Refusal::unwritable_ledger())?;
        answered.await.map_err(|_| Refusal::unwritable_ledger())?
    }

    async fn update(&self, record: JobRecord) -> Result<(), Refusal> {
        self.write(move |tables| renew(tables, record)).await
    }

    async fn flag_cancel(&self, id: String) -> Result<(), Refusal> {
        self.write(move |tables| flag_cancel(tables, &id)).await
    }

    async fn flag_paused(&self, id: String, paused: bool) -> Result<(), Refusal> {
        self.write(move |tables| match get(tables, &id)? {
            Some(record) if !record.state.ended() => put(tables, &JobRecord { paused, ..record }),
            _ => Ok(()),
        })
        .await
    }

    fn clear_blocking(&self, ids: Vec<String>) -> Result<(), Refusal> {
        self.write_blocking(move |tables| clear(tables, &ids))
    }

    async fn answered(&self, id: String, settled: Settled) -> Result<(), Refusal> {
        self.write(move |tables| rows::settle(tables, &id, settled)).await
    }

    fn answered_blocking(&self, id: String, settled: Settled) -> Result<(), Refusal> {
        self.write_blocking(move |tables| rows::settle(tables, &id, settled))
    }

    fn update_blocking(&self, records: Vec<JobRecord>) -> Result<(), Refusal> {
        self.write_blocking(move |tables| records.into_iter().try_for_each(|record| renew(tables, record)))
    }

    fn end(&self, record: JobRecord, log: Option<Bytes>, then: Then) {
        let then = Reply(Some(then));
        let tenant = number(&record.tenant);
        let work: writer::Work = Box::new(move |tables| {
            let keep = || {
                if let Some(log) = log {
                    let row = seal::bytes(LOG.name(), &record.id, &log);
                    tables.log()?.insert(record.id.as_str(), row.as_slice()).map_err(storage)?;
                }
                renew(tables, record)
            };
            let kept = keep();
            Box::new(move |committed| then.give(committed.and(kept)))
        });
        // An operation that is not done answers when it is dropped.
        if let Ok(operations) = self.operations() {
            let _ = operations.blocking_send(LedgerOperation { tenant, work });
        }
    }

    fn log(&self, id: &str) -> Result<Option<Bytes>, Refusal> {
        self.read(|txn| {
            let table = txn.open_table(LOG).map_err(storage)?;
            let row = table.get(id).map_err(storage)?;
            row.map(|row| logged(id, row.value())).transpose()
        })
    }

    async fn remove(&self, record: JobRecord) -> Result<bool, Refusal> {
        self.write(move |tables| take_out(tables, &record.id, record.ages_from())).await
    }

    fn expired(&self, keep: &Keep, now_ms: i64, most: usize) -> Result<Vec<EndedJob>, Refusal> {
        self.read(|txn| retention::expired(txn, keep, now_ms, most))
    }

    fn remove_blocking(&self, jobs: Vec<EndedJob>) -> Result<Vec<bool>, Refusal> {
        self.write_blocking(move |tables| jobs.iter().map(|job| take_out(tables, &job.id, job.ended_ms)).collect())
    }

    fn job(&self, id: &str) -> Result<Option<JobRecord>, Refusal> {
        self.read(|txn| {
            let table = txn.open_table(JOB).map_err(storage)?;
            let row = table.get(id).map_err(storage)?;
            row.map(|row| parse(JOB, id, row.value())).transpose()
        })
    }

    fn work(&self, id: &str) -> Result<Option<JobWork>, Refusal> {
        self.read(|txn| works::read(txn, id))
    }

    fn by_request(&self, tenant: &str, request_id: &str) -> Result<Option<JobRecord>, Refusal> {
        let id = self.read(|txn| {
            let table = txn.open_table(REQUEST).map_err(storage)?;
            let id = table.get(tenant::key(tenant, request_id).as_str()).map_err(storage)?;
            Ok(id.map(|id| id.value().to_owned()))
        })?;
        id.map_or(Ok(None), |id| self.job(&id))
    }

    fn equal(&self, tenant: &str, digest: &str) -> Result<Option<JobRecord>, Refusal> {
        self.read(|txn| equal::find(txn, tenant, digest))
    }

    fn jobs(&self, query: &Query) -> Result<Page, Refusal> {
        self.read(|txn| index::page(txn, query))
    }

    fn unfinished(&self) -> Result<Vec<JobRecord>, Refusal> {
        self.read(index::unfinished)
    }

    fn usages(&self) -> Result<Vec<(String, Usage)>, Refusal> {
        self.read(|txn| {
            let mut usages: BTreeMap<String, Usage> = usage::all(txn)?.into_iter().collect();
            for (tenant, bytes) in machine_bytes::all(txn)? {
                usages.entry(tenant).or_default().machines = bytes;
            }
            Ok(usages.into_iter().collect())
        })
    }

    fn usage(&self, tenant: &str) -> Result<Usage, Refusal> {
        self.read(|txn| Ok(Usage { machines: machine_bytes::of(txn, tenant)?, ..usage::of(txn, tenant)? }))
    }

    fn highest_ms(&self) -> i64 {
        self.highest_ms
    }

    fn keep_highest(&self, ms: i64) -> Result<(), Refusal> {
        self.write_blocking(move |tables| schema::keep_highest(tables.alone(), ms))
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }

    async fn put_machine(&self, definition: MachineRecord, check: Check<MachineRecord>) -> Result<(), Refusal> {
        self.write(move |tables| machines::put(tables, &definition, check)).await
    }

    async fn remove_machine(&self, tenant: String, name: String, trusted: bool) -> Result<bool, Refusal> {
        self.write(move |tables| machines::remove(tables, &tenant, &name, trusted)).await
    }

    fn collect_blocking(
        &self,
        tenant: &str,
        digests: Vec<String>,
        remove: Box<dyn Fn(&str) -> bool + Send>,
    ) -> Result<usize, Refusal> {
        let (shared, tenant) = (self.shared.clone(), tenant.to_owned());
        self.write_blocking(move |tables| {
            // A row that goes in this very transaction is still there when the transaction fails.
            let durable = shared.current().ok_or_else(Refusal::unwritable_ledger)?.begin_read().map_err(storage)?;
            let durable = durable.open_table(tables::BLOB).map_err(storage)?;
            let table = tables.blob()?;
            let mut removed = 0;
            for digest in &digests {
                let key = tenant::key(&tenant, digest);
                let needed = durable.get(key.as_str()).map_err(storage)?.is_some()
                    || table.get(key.as_str()).map_err(storage)?.is_some();
                removed += usize::from(!needed && remove(digest));
            }
            Ok(removed)
        })
    }

    fn knows(&self, id: &str) -> Result<bool, Refusal> {
        self.read(|txn| Ok(txn.open_table(JOB).map_err(storage)?.get(id).map_err(storage)?.is_some()))
    }

    fn machine(&self, tenant: &str, name: &str) -> Result<Option<MachineRecord>, Refusal> {
        let key = tenant::key(tenant, name);
        self.read(|txn| {
            let table = txn.open_table(MACHINE).map_err(storage)?;
            let row = table.get(key.as_str()).map_err(storage)?;
            row.map(|row| parse(MACHINE, &key, row.value())).transpose()
        })
    }

    fn machines(&self, tenant: &str) -> Result<Vec<MachineRecord>, Refusal> {
        self.read(|txn| machines::all(txn, tenant))
    }

    fn serve_backups(&self) {
        backups::serve(&self.store, |copy| self.read(|from| checkup::copy(from, copy, &self.store)));
    }

    fn compact_blocking(&self) -> Result<Compacted, Refusal> {
        let answered = self.shared.ask_for_compaction();
        // The writer compacts after the transaction of this operation, which changes nothing.
        self.write_blocking(|_| Ok(()))?;
        answered.blocking_recv().map_err(|_| Refusal::unwritable_ledger())?
    }

    fn file_bytes(&self) -> u64 {
        if self.store.durable() { self.store.ledger().metadata().map_or(0, |meta| meta.len()) } else { 0 }
    }

    fn used_bytes(&self) -> Result<u64, Refusal> {
        self.read(compact::used_bytes)
    }
}

impl Drop for LocalLedger {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod flags_tests;
#[cfg(test)]
mod model_tests;
