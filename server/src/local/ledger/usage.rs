//! Usage of each tenant: its stored bytes, and the processor time of its jobs on the last day that one of them ended.
//!
//! Invariant: the bytes are those of the tenant's jobs in the list of ended ones; they change in the same transaction.

use std::collections::BTreeMap;

use redb::{ReadTransaction, ReadableTable, WriteTransaction};

use super::tables::{TransactionTables, USAGE};
use super::{JOB, readable, storage};
use crate::ledger::record::JobRecord;
use crate::ledger::{Usage, day};
use crate::reason::Refusal;

fn usage((bytes, day, cpu_us): (u64, u64, u64)) -> Usage {
    Usage { bytes, day, cpu_us, machines: 0 }
}

/// The use of a tenant.
pub(super) fn of(txn: &ReadTransaction, tenant: &str) -> Result<Usage, Refusal> {
    let row = txn.open_table(USAGE).map_err(storage)?.get(tenant).map_err(storage)?.map(|row| usage(row.value()));
    Ok(row.unwrap_or_default())
}

/// The use of each tenant.
pub(super) fn all(txn: &ReadTransaction) -> Result<Vec<(String, Usage)>, Refusal> {
    let table = txn.open_table(USAGE).map_err(storage)?;
    let rows = table.iter().map_err(storage)?.map(|row| {
        let (tenant, row) = row.map_err(storage)?;
        Ok((tenant.value().to_owned(), usage(row.value())))
    });
    rows.collect()
}

fn change(tables: &TransactionTables<'_>, tenant: &str, change: impl FnOnce(&mut Usage)) -> Result<(), Refusal> {
    let mut table = tables.usage()?;
    let mut now = table.get(tenant).map_err(storage)?.map(|row| usage(row.value())).unwrap_or_default();
    change(&mut now);
    table.insert(tenant, (now.bytes, now.day, now.cpu_us)).map_err(storage)?;
    Ok(())
}

/// A job has ended that takes this many bytes, and took so many in the list before if it was there.
pub(super) fn ended(
    tables: &TransactionTables<'_>,
    record: &JobRecord,
    bytes: u64,
    before: Option<u64>,
) -> Result<(), Refusal> {
    change(tables, &record.tenant, |usage| {
        usage.bytes = usage.bytes.saturating_sub(before.unwrap_or(0)).saturating_add(bytes);
        if before.is_none() {
            let day = day(record.ended_ms);
            usage.cpu_us = usage.cpu_us_on(day).saturating_add(record.runs.cpu_us);
            usage.day = day;
        }
    })
}

/// A job that took this many bytes is removed.
pub(super) fn removed(tables: &TransactionTables<'_>, tenant: &str, bytes: u64) -> Result<(), Refusal> {
    change(tables, tenant, |usage| usage.bytes = usage.bytes.saturating_sub(bytes))
}

/// Bytes by tenant, as the list of ended jobs has them.
fn counted(jobs: impl Iterator<Item = (String, String)>, listed: &BTreeMap<String, u64>) -> BTreeMap<String, u64> {
    let mut bytes = BTreeMap::new();
    for (id, tenant) in jobs {
        if let Some(own) = listed.get(&id) {
            *bytes.entry(tenant).or_default() += own;
        }
    }
    bytes
}

/// Counts the bytes of all tenants anew.
pub(super) fn count_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    let mut listed = BTreeMap::new();
    for row in txn.open_table(super::tables::ENDED).map_err(storage)?.iter().map_err(storage)? {
        let (key, row) = row.map_err(storage)?;
        listed.insert(key.value().1.to_owned(), row.value().0);
    }
    let mut jobs = Vec::new();
    for row in txn.open_table(JOB).map_err(storage)?.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        jobs.extend(readable::<JobRecord>(JOB, id.value(), row.value()).map(|record| (record.id, record.tenant)));
    }
    let bytes = counted(jobs.into_iter(), &listed);
    let mut table = txn.open_table(USAGE).map_err(storage)?;
    let mut all: BTreeMap<String, (u64, u64, u64)> = BTreeMap::new();
    for row in table.iter().map_err(storage)? {
        let (tenant, row) = row.map_err(storage)?;
        let (_, day, cpu_us) = row.value();
        all.insert(tenant.value().to_owned(), (0, day, cpu_us));
    }
    for (tenant, bytes) in bytes {
        all.entry(tenant).or_default().0 = bytes;
    }
    for (tenant, row) in all {
        table.insert(tenant.as_str(), row).map_err(storage)?;
    }
    Ok(())
}

/// Earlier ledgers have the time in ms.
pub(super) fn in_micros(txn: &WriteTransaction) -> Result<(), Refusal> {
    let mut table = txn.open_table(USAGE).map_err(storage)?;
    let mut rows = Vec::new();
    for row in table.iter().map_err(storage)? {
        let (tenant, row) = row.map_err(storage)?;
        rows.push((tenant.value().to_owned(), row.value()));
    }
    for (tenant, (bytes, day, ms)) in rows {
        table.insert(tenant.as_str(), (bytes, day, ms.saturating_mul(1000))).map_err(storage)?;
    }
    Ok(())
}

/// Whether the bytes agree with the list of ended jobs.
pub(super) fn agree(txn: &ReadTransaction, jobs: &[JobRecord]) -> Result<bool, Refusal> {
    let mut listed = BTreeMap::new();
    for row in txn.open_table(super::tables::ENDED).map_err(storage)?.iter().map_err(storage)? {
        let (key, row) = row.map_err(storage)?;
        listed.insert(key.value().1.to_owned(), row.value().0);
    }
    let mut stored = BTreeMap::new();
    for row in txn.open_table(USAGE).map_err(storage)?.iter().map_err(storage)? {
        let (tenant, row) = row.map_err(storage)?;
        stored.insert(tenant.value().to_owned(), row.value().0);
    }
    let counted = counted(jobs.iter().map(|job| (job.id.clone(), job.tenant.clone())), &listed);
    let nonzero = |bytes: BTreeMap<String, u64>| bytes.into_iter().filter(|(_, bytes)| *bytes > 0).collect::<Vec<_>>();
    Ok(nonzero(stored) == nonzero(counted))
}
