//! Machines that were put there, by tenant and name, and by revision.
//!
//! Invariant: a machine has a row under its name, with its newest revision, and one for each revision under
//! `name@revision`; blobs are counted by the latter.

use redb::{ReadTransaction, ReadableTable, TableHandle as _};

use super::tables::TransactionTables;
use super::{MACHINE, blob_refs, machine_bytes, readable, seal, storage};
use crate::ledger::Check;
use crate::machines::MachineRecord;
use crate::reason::Refusal;
use crate::tenant;

fn of_an_administrator(name: &str) -> Refusal {
    Refusal::PermissionDenied(format!("the machine '{name}' was put by an administrator"))
}

/// Stores a machine.
pub(super) fn put(
    tables: &TransactionTables<'_>,
    definition: &MachineRecord,
    check: Check<MachineRecord>,
) -> Result<(), Refusal> {
    check(definition)?;
    let name = tenant::key(&definition.tenant, &definition.name);
    let pinned = format!("{name}@{}", definition.revision());
    let (newest, revision) =
        (seal::json(MACHINE.name(), &name, definition)?, seal::json(MACHINE.name(), &pinned, definition)?);
    let mut table = tables.alone().open_table(MACHINE).map_err(storage)?;
    // One that cannot be read may be that of an administrator.
    let trusted = |row: redb::AccessGuard<'_, &[u8]>| {
        readable::<MachineRecord>(MACHINE, &name, row.value()).is_none_or(|before| before.trusted)
    };
    if !definition.trusted && table.get(name.as_str()).map_err(storage)?.is_some_and(trusted) {
        return Err(of_an_administrator(&definition.name));
    }
    let length = |row: redb::AccessGuard<'_, &[u8]>| row.value().len() as u64;
    let earlier = table.insert(name.as_str(), newest.as_slice()).map_err(storage)?.map(length);
    let same = table.insert(pinned.as_str(), revision.as_slice()).map_err(storage)?.map(length);
    let known = same.is_some();
    drop(table);
    let gone = earlier.unwrap_or(0) + same.unwrap_or(0);
    machine_bytes::changed(tables.alone(), &definition.tenant, (newest.len() + revision.len()) as u64, gone)?;
    if known { Ok(()) } else { blob_refs::add(tables, &blob_refs::of_machine(definition)) }
}

/// Removes a machine with all its revisions.
pub(super) fn remove(tables: &TransactionTables<'_>, tenant: &str, name: &str, trusted: bool) -> Result<bool, Refusal> {
    let key = tenant::key(tenant, name);
    let mut table = tables.alone().open_table(MACHINE).map_err(storage)?;
    let newest = match table.get(key.as_str()).map_err(storage)? {
        None => return Ok(false),
        Some(row) => readable::<MachineRecord>(MACHINE, &key, row.value()),
    };
    if !trusted && newest.is_none_or(|newest| newest.trusted) {
        return Err(of_an_administrator(name));
    }
    let (mut rows, mut bytes) = (Vec::new(), 0);
    let (first, end) = (format!("{key}@"), format!("{key}A"));
    for row in table.range(first.as_str()..end.as_str()).map_err(storage)? {
        let (name, row) = row.map_err(storage)?;
        bytes += row.value().len() as u64;
        rows.push((name.value().to_owned(), readable::<MachineRecord>(MACHINE, name.value(), row.value())));
    }
    bytes += table.remove(key.as_str()).map_err(storage)?.map_or(0, |row| row.value().len() as u64);
    for (name, _) in &rows {
        table.remove(name.as_str()).map_err(storage)?;
    }
    drop(table);
    machine_bytes::changed(tables.alone(), tenant, 0, bytes)?;
    rows.iter()
        .filter_map(|(_, definition)| definition.as_ref())
        .try_for_each(|definition| blob_refs::subtract(tables, &blob_refs::of_machine(definition)))?;
    Ok(true)
}

/// All machines of a tenant, newest revision each, by name.
pub(super) fn all(txn: &ReadTransaction, tenant: &str) -> Result<Vec<MachineRecord>, Refusal> {
    let table = txn.open_table(MACHINE).map_err(storage)?;
    let mut found = Vec::new();
    for row in table.iter().map_err(storage)? {
        let (name, bytes) = row.map_err(storage)?;
        if name.value().contains('@') || machine_bytes::tenant_of(name.value()) != tenant {
            continue;
        }
        found.extend(readable::<MachineRecord>(MACHINE, name.value(), bytes.value()));
    }
    Ok(found)
}
