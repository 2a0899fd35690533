//! The one thread that writes the ledger, and its behaviour when the disk fails.
//!
//! It applies all operations that wait (up to 256) in one transaction, commits once and then answers them: group
//! commit. A write error closes the database for good, so the file is opened again with growing pauses; meanwhile
//! operations are refused and readers get the last durable state from memory. Invariant: an operation that was
//! answered is on stable storage; one that was not is either wholly there or not at all.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

use redb::Database;
use tokio::sync::{mpsc, oneshot, watch};

use super::file::{Frozen, LedgerFile};
use super::pace::Paces;
use super::tables::TransactionTables;
use super::{compact, storage};
use crate::ledger::Compacted;
use crate::local::contained::contained;
use crate::local::disk::Disk;
use crate::local::named::is_of_host;
use crate::local::store::DataFolder;
use crate::metrics::Metrics;
use crate::reason::Refusal;

const GROUP: usize = 256;
/// Most bytes of the ledger that are kept in memory; the system keeps more of them.
const CACHE: usize = 32 << 20;
/// First and longest pause between attempts to open the file again.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// Between two looks at the queue while the file cannot be written.
const LOOK: Duration = Duration::from_millis(10);

pub(super) type Reply = Box<dyn FnOnce(Result<(), Refusal>) + Send>;
/// Work in a transaction; dropping it answers that the ledger cannot be written.
pub(super) type Work = Box<dyn FnOnce(&TransactionTables<'_>) -> Reply + Send>;

/// The operation to write, and its tenant: a number of its own, 0 for the server itself.
pub(super) struct LedgerOperation {
    pub(super) tenant: u64,
    pub(super) work: Work,
}

/// Where the ledger lies.
#[derive(Debug, Clone)]
pub(super) enum LedgerLocation {
    Memory,
    File(PathBuf, Disk),
}

impl LedgerLocation {
    /// Opens or creates the database.
    ///
    /// # Errors
    /// Damage is lost data; a problem of the host is not.
    pub(super) fn open(&self) -> Result<Database, Refusal> {
        match self {
            Self::Memory => created(Database::builder(), redb::backends::InMemoryBackend::new()),
            Self::File(path, disk) => {
                let mut builder = Database::builder();
                builder.set_cache_size(CACHE);
                created(builder, LedgerFile::open(disk, path)?)
            }
        }
    }

    /// Whether all pages of the file have their checksums; what is wrong, if not. Nothing is written.
    pub(super) fn check(&self) -> Result<(), Refusal> {
        let mut database = self.try_frozen()?;
        let whole = contained(|| database.check_integrity());
        let _ = contained(|| drop(database));
        match whole {
            Ok(Ok(true)) => Ok(()),
            Ok(Ok(false)) => Err(Refusal::DataLoss("its pages do not agree".to_owned())),
            Ok(Err(error)) => Err(unusable(error)),
            Err(_) => Err(Refusal::DataLoss(DAMAGED.to_owned())),
        }
    }

    /// The last durable state, to be read only.
    fn frozen(&self) -> Option<Database> {
        self.try_frozen().ok()
    }

    /// Same, or why it cannot be read.
    pub(super) fn try_frozen(&self) -> Result<Database, Refusal> {
        let Self::File(path, _) = self else { return Err(storage("it is in memory")) };
        created(Database::builder(), Frozen::open(path)?)
    }
}

/// Place of the flags of the database in its file, and three of them: the second state is the current one; the file has
/// not been closed; each commit was two.
const FLAGS: u64 = 9;
const SECOND: u8 = 1;
const UNCLOSED: u8 = 2;
const IN_TWO: u8 = 4;

impl LedgerLocation {
    /// The durable states that the file may hold, to be read only: the last one as it is, the last one with the
    /// database's own tables made anew, and the one before it; with the length that the head of the file tells, and with
    /// that of the file.
    pub(super) fn states(&self) -> Vec<Database> {
        let Self::File(path, _) = self else { return Vec::new() };
        let state = |open: fn(&Path) -> io::Result<Frozen>, change: fn(u8) -> u8| {
            let (file, mut flags) = (open(path).ok()?, [0]);
            redb::StorageBackend::read(&file, FLAGS, &mut flags).ok()?;
            redb::StorageBackend::write(&file, FLAGS, &flags.map(change)).ok()?;
            created(Database::builder(), file).ok()
        };
        let states: [fn(u8) -> u8; 4] = [
            |flags| flags,
            |flags| flags | UNCLOSED,
            |flags| (flags | UNCLOSED) & !IN_TWO,
            |flags| ((flags | UNCLOSED) & !IN_TWO) ^ SECOND,
        ];
        let lengths: [fn(&Path) -> io::Result<Frozen>; 2] = [Frozen::of_its_length, Frozen::open];
        lengths.into_iter().flat_map(|open| states.map(|change| state(open, change))).flatten().collect()
    }
}

/// Of a file whose damage makes the database panic.
const DAMAGED: &str = "its pages are damaged";

fn created(builder: redb::Builder, backend: impl redb::StorageBackend) -> Result<Database, Refusal> {
    let created = contained(|| builder.create_with_backend(backend));
    created.map_err(|_| Refusal::DataLoss(DAMAGED.to_owned()))?.map_err(unusable)
}

/// Of a file that the database does not take: trouble of the host, or damage.
fn unusable(error: redb::DatabaseError) -> Refusal {
    match error {
        redb::DatabaseError::Storage(redb::StorageError::Io(error)) if is_of_host(&error) => error.into(),
        damage => Refusal::DataLoss(damage.to_string()),
    }
}

/// Data that the writer shares with readers.
#[derive(Debug)]
pub(super) struct LedgerDatabase {
    pub(super) place: LedgerLocation,
    pub(super) database: RwLock<Option<Arc<Database>>>,
    /// Whether operations can be done.
    pub(super) writable: watch::Sender<bool>,
    pub(super) metrics: Arc<Metrics>,
    /// Callers that wait for a compaction.
    pub(super) compactions: Mutex<Vec<oneshot::Sender<Result<Compacted, Refusal>>>>,
}

impl LedgerDatabase {
    pub(super) fn current(&self) -> Option<Arc<Database>> {
        self.database.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Asks the writer to compact the file after its next transaction.
    pub(super) fn ask_for_compaction(&self) -> oneshot::Receiver<Result<Compacted, Refusal>> {
        let (answer, answered) = oneshot::channel();
        self.compactions.lock().unwrap_or_else(PoisonError::into_inner).push(answer);
        answered
    }

    /// Closes the database that failed and lets readers see its last durable state.
    fn freeze(&self) {
        self.writable.send_replace(false);
        let mut database = self.database.write().unwrap_or_else(PoisonError::into_inner);
        let before = database.take();
        let _ = contained(|| drop(before));
        *database = self.place.frozen().map(Arc::new);
    }

    /// Opens the file again; readers wait that long.
    pub(super) fn reopen(&self) -> bool {
        let mut database = self.database.write().unwrap_or_else(PoisonError::into_inner);
        let before = database.take();
        let _ = contained(|| drop(before));
        match self.place.open() {
            Ok(opened) => {
                *database = Some(Arc::new(opened));
                self.writable.send_replace(true);
                true
            }
            Err(error) => {
                tracing::warn!(%error, "the ledger cannot be opened again yet");
                *database = self.place.frozen().map(Arc::new);
                false
            }
        }
    }
}

/// Compacts the file for all callers that wait for that; `false` if the ledger cannot be written any more.
fn compact_if_asked(shared: &LedgerDatabase, store: &DataFolder) -> bool {
    let callers = std::mem::take(&mut *shared.compactions.lock().unwrap_or_else(PoisonError::into_inner));
    if callers.is_empty() {
        return true;
    }
    let done = compact::compact(shared, store);
    if let Ok(done) = &done {
        shared.metrics.compacted(done);
    }
    for caller in callers {
        drop(caller.send(done.clone()));
    }
    *shared.writable.borrow()
}

/// Life of the writer thread: ends when all handles are gone.
pub(super) fn write(shared: &LedgerDatabase, store: &DataFolder, mut queue: mpsc::Receiver<LedgerOperation>) {
    let mut pause = FIRST_PAUSE;
    let mut paces = Paces::default();
    // Its timer; without one there are no pauses.
    let timer = tokio::runtime::Builder::new_current_thread().enable_time().build().ok();
    while let Some(first) = queue.blocking_recv() {
        let mut group = Vec::new();
        let mut wait = add(&mut group, first, &mut paces);
        while group.len() < GROUP {
            let next = match (queue.try_recv(), &timer) {
                (Ok(next), _) => next,
                (Err(_), Some(timer)) if wait => {
                    let pause = paces.pause(Instant::now());
                    let next = timer.block_on(async { tokio::time::timeout(pause, queue.recv()).await });
                    let Ok(Some(next)) = next else { break };
                    next
                }
                _ => break,
            };
            wait &= add(&mut group, next, &mut paces);
        }
        let Some(database) = shared.current() else { continue };
        let begin = Instant::now();
        let done = commit(&database, group);
        let took = begin.elapsed();
        shared.metrics.commit(took);
        paces.committed(took, begin + took);
        drop(database);
        if done && compact_if_asked(shared, store) {
            pause = FIRST_PAUSE;
            continue;
        }
        shared.freeze();
        if !wait_for_the_disk(shared, &mut queue, &mut pause) {
            return;
        }
    }
}

/// Adds an operation to a group; returns whether it may wait for others.
fn add(group: &mut Vec<LedgerOperation>, operation: LedgerOperation, paces: &mut Paces) -> bool {
    let tenant = operation.tenant;
    paces.came(tenant, Instant::now());
    group.push(operation);
    paces.busy(tenant)
}

/// Refuses operations until the file can be opened; `false` when all handles are gone.
fn wait_for_the_disk(
    shared: &LedgerDatabase,
    queue: &mut mpsc::Receiver<LedgerOperation>,
    pause: &mut Duration,
) -> bool {
    loop {
        let until = Instant::now() + *pause;
        *pause = (*pause * 2).min(LONGEST_PAUSE);
        while Instant::now() < until {
            match queue.try_recv() {
                Ok(operation) => drop(operation),
                Err(mpsc::error::TryRecvError::Disconnected) => return false,
                Err(mpsc::error::TryRecvError::Empty) => std::thread::sleep(LOOK),
            }
        }
        if shared.reopen() {
            tracing::info!("the ledger is open again");
            return true;
        }
    }
}

/// Does a group; `false` when the database has failed.
fn commit(database: &Database, group: Vec<LedgerOperation>) -> bool {
    let failed = |error: &dyn std::fmt::Display| tracing::error!(%error, "the ledger cannot be written");
    let begun = contained(|| database.begin_write()).and_then(|begun| begun.map_err(storage));
    let txn = match begun {
        Ok(txn) => txn,
        Err(error) => {
            failed(&error);
            return false; // Dropping the operations answers them.
        }
    };
    let mut replies: Vec<Reply> = Vec::with_capacity(group.len());
    let tables = TransactionTables::of(&txn);
    for operation in group {
        match contained(|| (operation.work)(&tables)) {
            Ok(reply) => replies.push(reply),
            Err(error) => {
                failed(&error);
                // Nothing of the group is kept: dropping the replies answers that.
                let _ = contained(|| drop(tables));
                let _ = contained(|| drop(txn));
                return false;
            }
        }
    }
    let committed =
        contained(|| drop(tables)).and_then(|()| contained(|| txn.commit())).and_then(|result| result.map_err(storage));
    let result = committed.map_err(|error| storage(format!("the ledger cannot be written: {error}")));
    if let Err(error) = &result {
        failed(error);
    }
    for reply in replies {
        reply(result.clone());
    }
    result.is_ok()
}
