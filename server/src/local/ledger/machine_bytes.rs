//! Bytes of the rows of the machines of each tenant.
//!
//! Invariant: the bytes change in the transaction that adds or removes the row.

use std::collections::BTreeMap;

use redb::{ReadTransaction, ReadableTable, TableDefinition, WriteTransaction};

use super::{MACHINE, storage};
use crate::reason::Refusal;
use crate::tenant;

/// Tenant → bytes.
pub(super) const MACHINE_BYTES: TableDefinition<'_, &str, u64> = TableDefinition::new("machine_bytes");

/// Tenant in the key of the row of a machine.
pub(super) fn tenant_of(key: &str) -> &str {
    key.split_once('/').map_or(tenant::DEFAULT, |(tenant, _)| tenant)
}

/// Rows of a tenant have come and gone.
pub(super) fn changed(txn: &WriteTransaction, tenant: &str, more: u64, less: u64) -> Result<(), Refusal> {
    let mut table = txn.open_table(MACHINE_BYTES).map_err(storage)?;
    let before = table.get(tenant).map_err(storage)?.map_or(0, |row| row.value());
    table.insert(tenant, before.saturating_add(more).saturating_sub(less)).map_err(storage)?;
    Ok(())
}

/// Bytes of a tenant.
pub(super) fn of(txn: &ReadTransaction, tenant: &str) -> Result<u64, Refusal> {
    let row = txn.open_table(MACHINE_BYTES).map_err(storage)?.get(tenant).map_err(storage)?.map(|row| row.value());
    Ok(row.unwrap_or(0))
}

/// Bytes by tenant as the rows have them.
fn counted(machines: &impl ReadableTable<&'static str, &'static [u8]>) -> Result<BTreeMap<String, u64>, Refusal> {
    let mut bytes = BTreeMap::new();
    for row in machines.iter().map_err(storage)? {
        let (key, row) = row.map_err(storage)?;
        *bytes.entry(tenant_of(key.value()).to_owned()).or_default() += row.value().len() as u64;
    }
    Ok(bytes)
}

/// Counts the rows of all machines anew.
pub(super) fn count_all(txn: &WriteTransaction) -> Result<(), Refusal> {
    let counted = counted(&txn.open_table(MACHINE).map_err(storage)?)?;
    let mut table = txn.open_table(MACHINE_BYTES).map_err(storage)?;
    table.retain(|_, _| false).map_err(storage)?;
    for (tenant, bytes) in counted {
        table.insert(tenant.as_str(), bytes).map_err(storage)?;
    }
    Ok(())
}

/// Bytes of each tenant that has any.
pub(super) fn all(txn: &ReadTransaction) -> Result<BTreeMap<String, u64>, Refusal> {
    let mut stored = BTreeMap::new();
    for row in txn.open_table(MACHINE_BYTES).map_err(storage)?.iter().map_err(storage)? {
        let (tenant, bytes) = row.map_err(storage)?;
        stored.insert(tenant.value().to_owned(), bytes.value());
    }
    stored.retain(|_, bytes| *bytes > 0);
    Ok(stored)
}

/// Whether the bytes agree with the rows.
pub(super) fn agree(txn: &ReadTransaction) -> Result<bool, Refusal> {
    Ok(all(txn)? == counted(&txn.open_table(MACHINE).map_err(storage)?)?)
}
