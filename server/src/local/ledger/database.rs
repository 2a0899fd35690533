//! The database of the ledger: where it is, how it is opened, and who may write.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use redb::Database;
use tokio::sync::{oneshot, watch};

use super::file::{Frozen, LedgerFile};
use super::storage;
use crate::ledger::Compacted;
use crate::local::contained::contained;
use crate::local::disk::Disk;
use crate::local::named::is_of_host;
use crate::metrics::Metrics;
use crate::reason::Refusal;

/// Most bytes of the ledger that are kept in memory; the system keeps more of them.
const CACHE: usize = 32 << 20;

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
    pub(super) fn freeze(&self) {
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
