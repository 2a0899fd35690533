//! The ledger: every accepted job and every machine put there, in one transactional file.
//!
//! One writer thread takes operations from a bounded queue, applies all that wait (up to 256) in one transaction,
//! commits once and then answers them: group commit. Readers use snapshots. Invariant: an operation that was
//! answered is on stable storage; one that was not is either wholly there or not at all.

pub(crate) mod record;

use std::sync::{Arc, PoisonError, RwLock};
use std::thread::JoinHandle;

use counterpoint_kernel::dialog::answers::Answer;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition, WriteTransaction};
use tokio::sync::{mpsc, oneshot};

use crate::machines::Definition;
use crate::reason::Refusal;
use crate::store::Store;
use record::{Record, State};

const JOB: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("job");
const REQUEST: TableDefinition<'_, &str, &str> = TableDefinition::new("request_id");
const MACHINE: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("machine");
const META: TableDefinition<'_, &str, u64> = TableDefinition::new("meta");
const SCHEMA: u64 = 1;
const GROUP: usize = 256;

type Reply = Box<dyn FnOnce(Result<(), Refusal>) + Send>;
type Operation = Box<dyn FnOnce(&WriteTransaction) -> Reply + Send>;

/// Handle on the ledger.
#[derive(Debug)]
pub(crate) struct Ledger(RwLock<Option<Open>>);

/// What an open ledger has.
#[derive(Debug)]
struct Open {
    database: Arc<Database>,
    operations: mpsc::Sender<Operation>,
    writer: JoinHandle<()>,
}

/// Answer to a submit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Submitted {
    /// Accepted now.
    New,
    /// Accepted earlier under this id.
    Known(Box<Record>),
}

fn storage(error: impl std::fmt::Display) -> Refusal {
    Refusal::Storage(error.to_string())
}

fn parse<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> Result<T, Refusal> {
    serde_json::from_slice(bytes).map_err(storage)
}

fn put(txn: &WriteTransaction, record: &Record) -> Result<(), Refusal> {
    let bytes = serde_json::to_vec(record).map_err(storage)?;
    txn.open_table(JOB).map_err(storage)?.insert(record.id.as_str(), bytes.as_slice()).map_err(storage)?;
    Ok(())
}

fn get(txn: &WriteTransaction, id: &str) -> Result<Option<Record>, Refusal> {
    let table = txn.open_table(JOB).map_err(storage)?;
    let row = table.get(id).map_err(storage)?;
    row.map(|row| parse(row.value())).transpose()
}

impl Ledger {
    /// Opens or creates the ledger.
    pub(crate) fn open(store: &Store) -> Result<Self, Refusal> {
        let database = if store.durable() {
            Database::create(store.ledger()).map_err(storage)?
        } else {
            Database::builder().create_with_backend(redb::backends::InMemoryBackend::new()).map_err(storage)?
        };
        let txn = database.begin_write().map_err(storage)?;
        {
            txn.open_table(JOB).map_err(storage)?;
            txn.open_table(REQUEST).map_err(storage)?;
            txn.open_table(MACHINE).map_err(storage)?;
            let mut meta = txn.open_table(META).map_err(storage)?;
            let schema = meta.get("schema").map_err(storage)?.map(|v| v.value());
            match schema {
                None => drop(meta.insert("schema", SCHEMA).map_err(storage)?),
                Some(SCHEMA) => {}
                Some(other) => return Err(storage(format!("the ledger has form {other}, this server reads {SCHEMA}"))),
            }
        }
        txn.commit().map_err(storage)?;
        let database = Arc::new(database);
        let (operations, queue) = mpsc::channel(1024);
        let shared = database.clone();
        let writer = std::thread::Builder::new().name("ledger".to_owned()).spawn(move || write(&shared, queue))?;
        Ok(Self(RwLock::new(Some(Open { database, operations, writer }))))
    }

    /// Does what was asked so far and gives the file free; everything asked later is refused.
    pub(crate) fn close(&self) {
        let open = self.0.write().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(Open { operations, writer, .. }) = open {
            drop(operations);
            let _ = writer.join();
        }
    }

    fn open_part<T>(&self, part: impl FnOnce(&Open) -> T) -> Result<T, Refusal> {
        let open = self.0.read().unwrap_or_else(PoisonError::into_inner);
        open.as_ref().map(part).ok_or_else(|| storage("the ledger is closed"))
    }

    fn operations(&self) -> Result<mpsc::Sender<Operation>, Refusal> {
        self.open_part(|open| open.operations.clone())
    }

    fn snapshot(&self) -> Result<ReadTransaction, Refusal> {
        self.open_part(|open| open.database.begin_read())?.map_err(storage)
    }

    fn operation<R: Send + 'static>(
        work: impl FnOnce(&WriteTransaction) -> Result<R, Refusal> + Send + 'static,
    ) -> (Operation, oneshot::Receiver<Result<R, Refusal>>) {
        let (answer, answered) = oneshot::channel();
        let operation: Operation = Box::new(move |txn| {
            let result = work(txn);
            Box::new(move |committed| drop(answer.send(committed.and(result))))
        });
        (operation, answered)
    }

    /// Does `work` in a transaction; answers after the commit. `work` must decide before it writes.
    async fn write<R: Send + 'static>(
        &self,
        work: impl FnOnce(&WriteTransaction) -> Result<R, Refusal> + Send + 'static,
    ) -> Result<R, Refusal> {
        let (operation, answered) = Self::operation(work);
        self.operations()?.send(operation).await.map_err(|_| storage("closed"))?;
        answered.await.map_err(|_| storage("closed"))?
    }

    /// Accepts a job, or finds the one accepted under the same request id.
    pub(crate) async fn submit(&self, record: Record) -> Result<Submitted, Refusal> {
        self.write(move |txn| {
            let mut requests = txn.open_table(REQUEST).map_err(storage)?;
            let known = requests.get(record.request_id.as_str()).map_err(storage)?.map(|id| id.value().to_owned());
            if let Some(known) = known.map(|id| get(txn, &id)).transpose()?.flatten() {
                return same(known, &record);
            }
            put(txn, &record)?;
            requests.insert(record.request_id.as_str(), record.id.as_str()).map_err(storage)?;
            Ok(Submitted::New)
        })
        .await
    }

    /// Stores a new state of a job.
    pub(crate) async fn update(&self, record: Record) -> Result<(), Refusal> {
        self.write(move |txn| put(txn, &record)).await
    }

    /// Notes that a job is to be cancelled, unless it has ended.
    pub(crate) async fn flag_cancel(&self, id: String) -> Result<(), Refusal> {
        self.write(move |txn| match get(txn, &id)? {
            Some(record) if !record.state.ended() => put(txn, &Record { cancel: true, ..record }),
            _ => Ok(()),
        })
        .await
    }

    /// Keeps what the operator said, unless the job has ended.
    pub(crate) async fn answered(&self, id: String, channel: u16, answer: Option<Answer>) -> Result<(), Refusal> {
        self.write(move |txn| match get(txn, &id)? {
            Some(mut record) if !record.state.ended() => {
                record.answers.push((channel, answer));
                put(txn, &record)
            }
            _ => Ok(()),
        })
        .await
    }

    /// Same as [`update`](Self::update) from a thread that may block.
    pub(crate) fn update_blocking(&self, record: Record) -> Result<(), Refusal> {
        let (operation, answered) = Self::operation(move |txn| put(txn, &record));
        self.operations()?.blocking_send(operation).map_err(|_| storage("closed"))?;
        answered.blocking_recv().map_err(|_| storage("closed"))?
    }

    /// Counts a run of a job, from a thread that may block; the record as it is kept then.
    pub(crate) fn begin_blocking(&self, id: String, now_ms: i64) -> Result<Record, Refusal> {
        let (operation, begun) = Self::operation(move |txn| {
            let mut record = get(txn, &id)?.ok_or_else(|| storage("a job that runs is not kept"))?;
            record.state = State::Running;
            record.attempt += 1;
            record.started_ms = now_ms;
            put(txn, &record)?;
            Ok(record)
        });
        self.operations()?.blocking_send(operation).map_err(|_| storage("closed"))?;
        begun.blocking_recv().map_err(|_| storage("closed"))?
    }

    /// Removes a job and its request id.
    pub(crate) async fn remove(&self, record: Record) -> Result<(), Refusal> {
        self.write(move |txn| {
            txn.open_table(JOB).map_err(storage)?.remove(record.id.as_str()).map_err(storage)?;
            txn.open_table(REQUEST).map_err(storage)?.remove(record.request_id.as_str()).map_err(storage)?;
            Ok(())
        })
        .await
    }

    /// One job.
    pub(crate) fn job(&self, id: &str) -> Result<Option<Record>, Refusal> {
        let table = self.snapshot()?.open_table(JOB).map_err(storage)?;
        let row = table.get(id).map_err(storage)?;
        row.map(|row| parse(row.value())).transpose()
    }

    /// The job accepted under a request id.
    pub(crate) fn by_request(&self, request_id: &str) -> Result<Option<Record>, Refusal> {
        let table = self.snapshot()?.open_table(REQUEST).map_err(storage)?;
        let id = table.get(request_id).map_err(storage)?.map(|id| id.value().to_owned());
        id.map_or(Ok(None), |id| self.job(&id))
    }

    /// Up to `count` jobs behind `after` that `wanted` takes.
    pub(crate) fn jobs(
        &self,
        after: &str,
        count: usize,
        wanted: impl Fn(&Record) -> bool,
    ) -> Result<Vec<Record>, Refusal> {
        let table = self.snapshot()?.open_table(JOB).map_err(storage)?;
        let mut found = Vec::new();
        for row in
            table.range::<&str>((std::ops::Bound::Excluded(after), std::ops::Bound::Unbounded)).map_err(storage)?
        {
            if found.len() >= count {
                break;
            }
            let record: Record = parse(row.map_err(storage)?.1.value())?;
            if wanted(&record) {
                found.push(record);
            }
        }
        Ok(found)
    }

    /// Stores a machine under its name and its revision.
    pub(crate) async fn put_machine(&self, definition: Definition) -> Result<(), Refusal> {
        self.write(move |txn| {
            let bytes = serde_json::to_vec(&definition).map_err(storage)?;
            let pinned = format!("{}@{}", definition.name, definition.revision());
            let mut table = txn.open_table(MACHINE).map_err(storage)?;
            table.insert(definition.name.as_str(), bytes.as_slice()).map_err(storage)?;
            table.insert(pinned.as_str(), bytes.as_slice()).map_err(storage)?;
            Ok(())
        })
        .await
    }

    /// A machine by `name` or `name@revision`.
    pub(crate) fn machine(&self, name: &str) -> Result<Option<Definition>, Refusal> {
        let table = self.snapshot()?.open_table(MACHINE).map_err(storage)?;
        let row = table.get(name).map_err(storage)?;
        row.map(|row| parse(row.value())).transpose()
    }

    /// All machines put there, newest revision each, by name.
    pub(crate) fn machines(&self) -> Result<Vec<Definition>, Refusal> {
        let table = self.snapshot()?.open_table(MACHINE).map_err(storage)?;
        let mut found = Vec::new();
        for row in table.iter().map_err(storage)? {
            let (name, bytes) = row.map_err(storage)?;
            if !name.value().contains('@') {
                found.push(parse(bytes.value())?);
            }
        }
        Ok(found)
    }

    /// Jobs that had not ended when the server went down, in order of submission.
    pub(crate) fn unfinished(&self) -> Result<Vec<Record>, Refusal> {
        self.jobs("", usize::MAX, |record| !record.state.ended())
    }
}

impl Drop for Ledger {
    fn drop(&mut self) {
        self.close();
    }
}

fn same(known: Record, asked: &Record) -> Result<Submitted, Refusal> {
    if known.content == asked.content {
        Ok(Submitted::Known(Box::new(known)))
    } else {
        Err(Refusal::RequestIdReused(asked.request_id.clone()))
    }
}

/// Life of the writer thread: ends when all handles are gone.
fn write(database: &Database, mut queue: mpsc::Receiver<Operation>) {
    while let Some(first) = queue.blocking_recv() {
        let mut group = vec![first];
        while group.len() < GROUP {
            let Ok(next) = queue.try_recv() else { break };
            group.push(next);
        }
        commit(database, group);
    }
}

fn commit(database: &Database, group: Vec<Operation>) {
    let txn = match database.begin_write() {
        Ok(txn) => txn,
        Err(error) => {
            tracing::error!(%error, "the ledger cannot be written");
            return; // Dropping the operations answers them with an error.
        }
    };
    let replies: Vec<Reply> = group.into_iter().map(|operation| operation(&txn)).collect();
    let result = txn.commit().map_err(storage);
    if let Err(error) = &result {
        tracing::error!(%error, "the ledger cannot be written");
    }
    for reply in replies {
        reply(result.clone());
    }
}

/// State a job is put back to when the server starts.
pub(crate) fn recovered(mut record: Record, attempts: u32) -> Record {
    if record.cancel {
        record.state = State::Cancelled;
        record.ended_ms = record::now_ms();
    } else if record.attempt >= attempts {
        record.state = State::Failed;
        record.ended_ms = record::now_ms();
        record.error = format!("poison: given up after {} runs that did not end", record.attempt);
    } else {
        record.state = State::Queued;
    }
    record
}
