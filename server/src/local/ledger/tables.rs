//! The tables of a transaction, each opened once for all operations of a group.
//!
//! Opening and closing a table costs as much as changing a row. *Invariant:* a table is open here or in the transaction
//! itself, never in both at the same time: [`TransactionTables::alone`] closes all tables first.

use std::cell::{RefCell, RefMut};

use redb::{Key, Table, TableDefinition, Value, WriteTransaction};

use super::{JOB, LOG, REQUEST, storage};
use crate::reason::Refusal;

/// A table, once it has been opened.
type Slot<'t, K, V> = RefCell<Option<Table<'t, K, V>>>;
/// An open table.
type Open<'a, 't, K, V> = Result<RefMut<'a, Table<'t, K, V>>, Refusal>;

/// The transaction of a group, and the tables that it has open.
pub(super) struct TransactionTables<'t> {
    txn: &'t WriteTransaction,
    job: Slot<'t, &'static str, &'static [u8]>,
    work: Slot<'t, &'static str, &'static [u8]>,
    log: Slot<'t, &'static str, &'static [u8]>,
    request: Slot<'t, &'static str, &'static str>,
    equal: Slot<'t, &'static str, &'static str>,
    index: Slot<'t, (&'static str, &'static str), ()>,
    blob: Slot<'t, &'static str, u64>,
    ended: Slot<'t, (i64, &'static str), (u64, &'static str)>,
    usage: Slot<'t, &'static str, (u64, u64, u64)>,
}

fn open<'a, 't, K: Key + 'static, V: Value + 'static>(
    slot: &'a Slot<'t, K, V>,
    txn: &'t WriteTransaction,
    definition: TableDefinition<'_, K, V>,
) -> Open<'a, 't, K, V> {
    let mut slot = slot.try_borrow_mut().map_err(storage)?;
    if slot.is_none() {
        *slot = Some(txn.open_table(definition).map_err(storage)?);
    }
    RefMut::filter_map(slot, Option::as_mut).map_err(|_| storage("a table is not open"))
}

impl<'t> TransactionTables<'t> {
    /// Of a transaction that has no table open.
    pub(super) fn of(txn: &'t WriteTransaction) -> Self {
        Self {
            txn,
            job: Slot::default(),
            work: Slot::default(),
            log: Slot::default(),
            request: Slot::default(),
            equal: Slot::default(),
            index: Slot::default(),
            blob: Slot::default(),
            ended: Slot::default(),
            usage: Slot::default(),
        }
    }

    /// The transaction, with all tables closed.
    pub(super) fn alone(&self) -> &'t WriteTransaction {
        self.job.take();
        self.work.take();
        self.log.take();
        self.request.take();
        self.equal.take();
        self.index.take();
        self.blob.take();
        self.ended.take();
        self.usage.take();
        self.txn
    }

    pub(super) fn job(&self) -> Open<'_, 't, &'static str, &'static [u8]> {
        open(&self.job, self.txn, JOB)
    }

    pub(super) fn work(&self) -> Open<'_, 't, &'static str, &'static [u8]> {
        open(&self.work, self.txn, WORK)
    }

    pub(super) fn log(&self) -> Open<'_, 't, &'static str, &'static [u8]> {
        open(&self.log, self.txn, LOG)
    }

    pub(super) fn request(&self) -> Open<'_, 't, &'static str, &'static str> {
        open(&self.request, self.txn, REQUEST)
    }

    pub(super) fn equal(&self) -> Open<'_, 't, &'static str, &'static str> {
        open(&self.equal, self.txn, EQUAL)
    }

    pub(super) fn index(&self) -> Open<'_, 't, (&'static str, &'static str), ()> {
        open(&self.index, self.txn, INDEX)
    }

    pub(super) fn blob(&self) -> Open<'_, 't, &'static str, u64> {
        open(&self.blob, self.txn, BLOB)
    }

    pub(super) fn ended(&self) -> Open<'_, 't, (i64, &'static str), (u64, &'static str)> {
        open(&self.ended, self.txn, ENDED)
    }

    pub(super) fn usage(&self) -> Open<'_, 't, &'static str, (u64, u64, u64)> {
        open(&self.usage, self.txn, USAGE)
    }
}

/// Identity → work.
pub(super) const WORK: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("work");

/// Tenant and digest → the last job that ended with it.
pub(super) const EQUAL: TableDefinition<'_, &str, &str> = TableDefinition::new("equal_jobs");

/// Term and identity.
pub(super) const INDEX: TableDefinition<'_, (&str, &str), ()> = TableDefinition::new("index");

/// Tenant and digest → rows that need it; never 0.
pub(super) const BLOB: TableDefinition<'_, &str, u64> = TableDefinition::new("blob");

/// Time of the end and identity → bytes of work, log, files and results, and tenant.
pub(super) const ENDED: TableDefinition<'_, (i64, &str), (u64, &str)> = TableDefinition::new("ended_jobs");

/// Tenant → bytes, day, processor time of the jobs that ended on that day in µs.
pub(super) const USAGE: TableDefinition<'_, &str, (u64, u64, u64)> = TableDefinition::new("usage");
