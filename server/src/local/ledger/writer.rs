//! The one thread that writes the ledger, and its behaviour when the disk fails.
//!
//! It applies all operations that wait (up to 256) in one transaction, commits once and then answers them: group
//! commit. A write error closes the database for good, so the file is opened again with growing pauses; meanwhile
//! operations are refused and readers get the last durable state from memory. Invariant: an operation that was
//! answered is on stable storage; one that was not is either wholly there or not at all.

use std::sync::PoisonError;
use std::time::{Duration, Instant};

use redb::Database;
use tokio::sync::mpsc;

use super::database::LedgerDatabase;
use super::pace::Paces;
use super::tables::TransactionTables;
use super::{compact, storage};
use crate::local::contained::contained;
use crate::local::store::DataFolder;
use crate::reason::Refusal;

const GROUP: usize = 256;
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
