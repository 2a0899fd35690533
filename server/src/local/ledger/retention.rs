//! Ended jobs by the time of their end, and which of them are to go.
//!
//! Invariant: exactly the jobs that have ended are listed; those that wait or run never are.

use std::collections::{BTreeMap, BTreeSet};

use redb::{ReadTransaction, ReadableTable, ReadableTableMetadata, TableDefinition, WriteTransaction};

use super::tables::{ENDED, TransactionTables};
use super::{JOB, readable, storage, works};
use crate::ledger::record::JobRecord;
use crate::ledger::{EndedJob, Keep, TenantRetention};
use crate::local::store::DataFolder;
use crate::reason::Refusal;

/// The same without tenants, as ledgers before schema 7 have it.
const EARLIER: TableDefinition<'_, (i64, &str), u64> = TableDefinition::new("ended");

/// Lists a job that has ended, with its bytes; returns those that it was listed with before.
pub(super) fn list(tables: &TransactionTables<'_>, record: &JobRecord, bytes: u64) -> Result<Option<u64>, Refusal> {
    let mut table = tables.ended()?;
    let key = (record.ages_from(), record.id.as_str());
    let before = table.insert(key, (bytes, record.tenant.as_str())).map_err(storage)?;
    Ok(before.map(|row| row.value().0))
}

/// Takes a job out of the list; returns its bytes.
pub(super) fn unlist(tables: &TransactionTables<'_>, id: &str, ended_ms: i64) -> Result<u64, Refusal> {
    let mut table = tables.ended()?;
    let before = table.remove((ended_ms, id)).map_err(storage)?;
    Ok(before.map_or(0, |row| row.value().0))
}

/// All that are listed: time of the end and identity.
pub(super) fn listed(txn: &ReadTransaction) -> Result<BTreeSet<(i64, String)>, Refusal> {
    let mut listed = BTreeSet::new();
    for row in txn.open_table(ENDED).map_err(storage)?.iter().map_err(storage)? {
        let (key, _) = row.map_err(storage)?;
        let (ended_ms, id) = key.value();
        listed.insert((ended_ms, id.to_owned()));
    }
    Ok(listed)
}

/// Lists all jobs that have ended, with the bytes of their folders.
pub(super) fn list_all(txn: &WriteTransaction, store: &DataFolder) -> Result<(), Refusal> {
    let mut ended = txn.open_table(ENDED).map_err(storage)?;
    ended.retain(|_, _| false).map_err(storage)?;
    let (tables, jobs) = (TransactionTables::of(txn), txn.open_table(JOB).map_err(storage)?);
    for row in jobs.iter().map_err(storage)? {
        let (id, row) = row.map_err(storage)?;
        if let Some(record) = readable::<JobRecord>(JOB, id.value(), row.value()).filter(|record| record.state.ended())
        {
            let bytes = store.job_bytes(id.value()).max(record.runs.stored_bytes);
            let bytes = bytes.saturating_add(works::bytes(&tables, id.value())?);
            ended.insert((record.ages_from(), id.value()), (bytes, record.tenant.as_str())).map_err(storage)?;
        }
    }
    Ok(())
}

/// Lists the jobs of an earlier list with their tenants; those whose rows are gone or cannot be read are left out.
pub(super) fn with_tenants(txn: &WriteTransaction) -> Result<(), Refusal> {
    {
        let (earlier, jobs) = (txn.open_table(EARLIER).map_err(storage)?, txn.open_table(JOB).map_err(storage)?);
        let mut ended = txn.open_table(ENDED).map_err(storage)?;
        for row in earlier.iter().map_err(storage)? {
            let (key, bytes) = row.map_err(storage)?;
            let row = jobs.get(key.value().1).map_err(storage)?;
            if let Some(record) = row.and_then(|row| readable::<JobRecord>(JOB, key.value().1, row.value())) {
                ended.insert(key.value(), (bytes.value(), record.tenant.as_str())).map_err(storage)?;
            }
        }
    }
    txn.delete_table(EARLIER).map(drop).map_err(storage)
}

/// Jobs and their bytes.
#[derive(Default)]
struct JobTotals {
    jobs: u64,
    bytes: u64,
}

impl JobTotals {
    fn add(&mut self, bytes: u64) {
        (self.jobs, self.bytes) = (self.jobs + 1, self.bytes.saturating_add(bytes));
    }

    fn subtract(&mut self, bytes: u64) {
        (self.jobs, self.bytes) = (self.jobs.saturating_sub(1), self.bytes.saturating_sub(bytes));
    }

    fn over(&self, jobs: Option<u64>, bytes: Option<u64>) -> bool {
        jobs.is_some_and(|most| self.jobs > most) || bytes.is_some_and(|most| self.bytes > most)
    }
}

/// Up to `most` ended jobs beyond the retention limits, oldest first.
pub(super) fn expired(txn: &ReadTransaction, keep: &Keep, now_ms: i64, most: usize) -> Result<Vec<EndedJob>, Refusal> {
    let table = txn.open_table(ENDED).map_err(storage)?;
    let mut all = JobTotals { jobs: table.len().map_err(storage)?, bytes: 0 };
    let mut tenants: BTreeMap<String, JobTotals> = BTreeMap::new();
    let counts = |kept: &TenantRetention| kept.jobs.is_some() || kept.bytes.is_some();
    let by_tenant = counts(&keep.of("")) || keep.own.values().any(counts);
    let crowds = |tenant: &str, own: &JobTotals| {
        let kept = keep.of(tenant);
        own.over(kept.jobs, kept.bytes)
    };
    let old = |ended_ms: i64, age: Option<i64>| age.is_some_and(|age| ended_ms < now_ms.saturating_sub(age));
    let shortest = keep.own.values().map(|own| own.age_ms).chain([keep.age_ms]).flatten().min();
    if keep.bytes.is_some() || by_tenant {
        for row in table.iter().map_err(storage)? {
            let row = row.map_err(storage)?.1;
            let (bytes, tenant) = row.value();
            all.bytes = all.bytes.saturating_add(bytes);
            match tenants.get_mut(tenant) {
                Some(own) => own.add(bytes),
                None if by_tenant => drop(tenants.insert(tenant.to_owned(), JobTotals { jobs: 1, bytes })),
                None => {}
            }
        }
    }
    let mut crowded = tenants.iter().filter(|(tenant, own)| crowds(tenant, own)).count();
    let mut found = Vec::new();
    for row in table.iter().map_err(storage)? {
        let (key, row) = row.map_err(storage)?;
        let ((ended_ms, id), (bytes, tenant)) = (key.value(), row.value());
        let too_many = all.over(keep.jobs, keep.bytes);
        if found.len() >= most || !too_many && crowded == 0 && !old(ended_ms, shortest) {
            break;
        }
        let over = too_many || old(ended_ms, keep.of(tenant).age_ms);
        let own = tenants.get_mut(tenant);
        let own_over = own.as_ref().is_some_and(|own| crowds(tenant, own));
        if !over && !own_over {
            continue;
        }
        all.subtract(bytes);
        if let Some(own) = own {
            own.subtract(bytes);
            crowded -= usize::from(own_over && !crowds(tenant, own));
        }
        found.push(EndedJob { id: id.to_owned(), ended_ms });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use redb::{Database, ReadableDatabase};

    use super::*;
    use crate::ledger::record::JobState;
    use crate::ledger::record::tests::record;

    #[test]
    fn the_oldest_go_first_by_age_number_and_bytes() {
        let backend = redb::backends::InMemoryBackend::new();
        let database = Database::builder().create_with_backend(backend).unwrap();
        let txn = database.begin_write().unwrap();
        // Ended in another order than accepted.
        for (id, ended_ms, bytes) in [("a", 300, 10), ("b", 100, 20), ("c", 200, 30), ("d", 400, 40)] {
            let ended = JobRecord { state: JobState::Succeeded, ended_ms, ..record(id) };
            list(&TransactionTables::of(&txn), &ended, bytes).unwrap();
        }
        txn.commit().unwrap();
        let expired = |keep: Keep, most| -> String {
            let txn = database.begin_read().unwrap();
            expired(&txn, &keep, 1000, most).unwrap().into_iter().map(|job| job.id).collect()
        };
        let keep = Keep::default;
        assert_eq!(expired(keep(), 9), "");
        assert_eq!(expired(Keep { age_ms: Some(700), ..keep() }, 9), "bc");
        assert_eq!(expired(Keep { jobs: Some(1), ..keep() }, 9), "bca");
        assert_eq!(expired(Keep { jobs: Some(1), ..keep() }, 2), "bc");
        assert_eq!(expired(Keep { jobs: Some(4), ..keep() }, 9), "");
        assert_eq!(expired(Keep { bytes: Some(80), ..keep() }, 9), "b");
        assert_eq!(expired(Keep { bytes: Some(79), ..keep() }, 9), "bc");
        assert_eq!(expired(Keep { bytes: Some(0), age_ms: Some(1), ..keep() }, 9), "bcad");
        assert_eq!(expired(Keep { jobs: Some(3), age_ms: Some(750), bytes: Some(49), ..keep() }, 9), "bca");
        let txn = database.begin_write().unwrap();
        unlist(&TransactionTables::of(&txn), "b", 100).unwrap();
        txn.commit().unwrap();
        assert_eq!(expired(Keep { jobs: Some(2), ..keep() }, 9), "c");
    }

    #[test]
    fn each_tenant_loses_its_own_oldest_jobs_and_no_other() {
        let backend = redb::backends::InMemoryBackend::new();
        let database = Database::builder().create_with_backend(backend).unwrap();
        let txn = database.begin_write().unwrap();
        for (id, tenant, ended_ms, bytes) in [
            ("a", "one", 100, 10),
            ("b", "two", 200, 10),
            ("c", "one", 300, 10),
            ("d", "one", 400, 70),
            ("e", "two", 500, 20),
        ] {
            let ended = JobRecord { state: JobState::Succeeded, ended_ms, tenant: tenant.to_owned(), ..record(id) };
            list(&TransactionTables::of(&txn), &ended, bytes).unwrap();
        }
        txn.commit().unwrap();
        let expired = |keep: Keep, most| -> String {
            let txn = database.begin_read().unwrap();
            expired(&txn, &keep, 1000, most).unwrap().into_iter().map(|job| job.id).collect()
        };
        let keep = Keep::default;
        assert_eq!(expired(Keep { tenant_jobs: Some(2), ..keep() }, 9), "a");
        assert_eq!(expired(Keep { tenant_jobs: Some(1), ..keep() }, 9), "abc");
        assert_eq!(expired(Keep { tenant_jobs: Some(1), ..keep() }, 2), "ab");
        assert_eq!(expired(Keep { tenant_jobs: Some(3), ..keep() }, 9), "");
        assert_eq!(expired(Keep { tenant_bytes: Some(85), ..keep() }, 9), "a");
        assert_eq!(expired(Keep { tenant_bytes: Some(30), ..keep() }, 9), "acd");
        assert_eq!(expired(Keep { tenant_jobs: Some(2), jobs: Some(3), ..keep() }, 9), "ab", "what goes counts once");
        assert_eq!(expired(Keep { tenant_bytes: Some(75), age_ms: Some(750), ..keep() }, 9), "abc");
        let own = |kept| BTreeMap::from([("one".to_owned(), kept)]);
        let kept = TenantRetention::default;
        assert_eq!(expired(Keep { own: own(TenantRetention { jobs: Some(1), ..kept() }), ..keep() }, 9), "ac");
        assert_eq!(expired(Keep { own: own(TenantRetention { age_ms: Some(650), ..kept() }), ..keep() }, 9), "ac");
        assert_eq!(expired(Keep { own: own(kept()), tenant_jobs: Some(1), age_ms: Some(750), ..keep() }, 9), "b");
        assert_eq!(
            expired(
                Keep { own: own(TenantRetention { bytes: Some(75), ..kept() }), tenant_jobs: Some(1), ..keep() },
                9
            ),
            "abc"
        );
        assert_eq!(expired(Keep { own: own(kept()), bytes: Some(105), ..keep() }, 9), "ab", "all count for the whole");
    }
}
