//! Rows of jobs: read, stored and removed with all that belongs to them.
//!
//! Invariant: a row and its lists, counts and work change in the same transaction.

use redb::ReadableTable;
use redb::TableHandle as _;
use serde::Deserialize;
use uuid::Uuid;

use super::tables::TransactionTables;
use super::{JOB, Rows, blob_refs, equal, index, retention, seal, storage, usage, works};
use crate::ledger::record::{JobRecord, JobWork};
use crate::ledger::settled::Settled;
use crate::ledger::{SubmitOutcome, time_of};
use crate::reason::Refusal;
use crate::tenant;

/// The value of a row of a table, which names the job or machine that it belongs to.
pub(super) fn parse<T: serde::de::DeserializeOwned>(table: Rows<'_>, key: &str, row: &[u8]) -> Result<T, Refusal> {
    let lost = |error: &dyn std::fmt::Display| {
        Refusal::DataLoss(format!("the row '{key}' of the ledger cannot be read ({error}); submit its job again"))
    };
    let content = seal::content(table.name(), key, row).ok_or_else(|| lost(&"its checksum is wrong"))?;
    serde_json::from_slice(content).map_err(|error| lost(&error))
}

/// Same, without a row that cannot be read.
pub(super) fn readable<T: serde::de::DeserializeOwned>(table: Rows<'_>, key: &str, row: &[u8]) -> Option<T> {
    parse(table, key, row).inspect_err(|error| tracing::error!(%error, "a row of the ledger is left out")).ok()
}

/// Maximum step back of the clock that the times of submits hide, ms.
const MOST_BACK_MS: i64 = 60_000;

/// The next identity, ascending in order of acceptance, and the time of the submit, ms since 1970. `now` contains the
/// time of the clock, which may have been set back.
pub(super) fn next_job(tables: &TransactionTables<'_>, now: Uuid) -> Result<(String, i64), Refusal> {
    let table = tables.job()?;
    let last = table.last().map_err(storage)?.and_then(|(id, _)| Uuid::parse_str(id.value()).ok());
    Ok((after(last, now).to_string(), submitted_ms(last.map_or(0, time_of), time_of(now))))
}

/// Time of a submit when the clock shows `now_ms` and the last identity has `last_ms`: at least `last_ms`, unless the
/// clock was so far ahead that the times of all later jobs would be wrong.
fn submitted_ms(last_ms: i64, now_ms: i64) -> i64 {
    if last_ms.saturating_sub(now_ms) <= MOST_BACK_MS { now_ms.max(last_ms) } else { now_ms }
}

/// `new`, or the smallest identity after `last` if `new` is not after it.
fn after(last: Option<Uuid>, new: Uuid) -> Uuid {
    match last {
        Some(last) if new <= last => Uuid::from_u128(last.as_u128().wrapping_add(1)),
        _ => new,
    }
}

/// Stores that jobs are no longer suspects, unless they have ended.
pub(super) fn clear(tables: &TransactionTables<'_>, ids: &[String]) -> Result<(), Refusal> {
    for id in ids {
        // A damaged row is reported when the job is read.
        let Ok(Some(mut record)) = get(tables, id) else { continue };
        if !record.state.ended() && std::mem::take(&mut record.runs.suspect) {
            put(tables, &record)?;
        }
    }
    Ok(())
}

/// Stores a new state of a job. A cancel or a pause that was stored after the caller copied the record is kept.
pub(super) fn renew(tables: &TransactionTables<'_>, mut record: JobRecord) -> Result<(), Refusal> {
    // A damaged row is replaced.
    if let Ok(Some(stored)) = flags(tables, &record.id) {
        record.cancel |= stored.cancel;
        record.paused = stored.paused && !record.state.ended();
    }
    put(tables, &record)
}

/// The requests of clients about a job, in its row.
#[derive(Default, Deserialize)]
#[serde(default)]
struct JobFlags {
    cancel: bool,
    paused: bool,
}

fn flags(tables: &TransactionTables<'_>, id: &str) -> Result<Option<JobFlags>, Refusal> {
    let table = tables.job()?;
    let row = table.get(id).map_err(storage)?;
    row.map(|row| parse(JOB, id, row.value())).transpose()
}

/// Stores that the cancel of a job was accepted, even if its end has been stored meanwhile.
pub(super) fn flag_cancel(tables: &TransactionTables<'_>, id: &str) -> Result<(), Refusal> {
    match get(tables, id)? {
        Some(record) => put_row(tables, &JobRecord { cancel: true, ..record }),
        None => Ok(()),
    }
}

/// Stores the row of a job alone; its lists do not depend on the change.
fn put_row(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    let bytes = seal::json(JOB.name(), &record.id, record)?;
    tables.job()?.insert(record.id.as_str(), bytes.as_slice()).map_err(storage)?;
    Ok(())
}

/// Stores the row of a job; an ended job is added to the list of ended jobs.
pub(super) fn put(tables: &TransactionTables<'_>, record: &JobRecord) -> Result<(), Refusal> {
    put_row(tables, record)?;
    if !record.state.ended() {
        return Ok(());
    }
    let bytes = record.runs.stored_bytes.saturating_add(works::bytes(tables, &record.id)?);
    let before = retention::list(tables, record, bytes)?;
    index::end(tables, record)?;
    equal::add(tables, record)?;
    usage::ended(tables, record, bytes, before)
}

/// Removes an ended job with all its rows; `false` if the job was removed before.
pub(super) fn take_out(tables: &TransactionTables<'_>, id: &str, ended_ms: i64) -> Result<bool, Refusal> {
    let bytes = retention::unlist(tables, id, ended_ms)?;
    let row = tables.job()?.remove(id).map_err(storage)?.map(|row| row.value().to_vec());
    tables.log()?.remove(id).map_err(storage)?;
    let work = works::remove(tables, id)?;
    let Some(row) = row else { return Ok(false) };
    let Some(record) = readable::<JobRecord>(JOB, id, &row) else { return Ok(true) };
    tables.request()?.remove(tenant::key(&record.tenant, &record.request_id).as_str()).map_err(storage)?;
    index::remove(tables, &record)?;
    equal::remove(tables, &record)?;
    usage::removed(tables, &record.tenant, bytes)?;
    if let Some(work) = work {
        blob_refs::subtract(tables, &blob_refs::of_job(&record.tenant, &work))?;
    }
    Ok(true)
}

/// The row of a job.
pub(super) fn get(tables: &TransactionTables<'_>, id: &str) -> Result<Option<JobRecord>, Refusal> {
    let table = tables.job()?;
    let row = table.get(id).map_err(storage)?;
    row.map(|row| parse(JOB, id, row.value())).transpose()
}

/// The answer to a submit whose request id is known.
pub(super) fn same(
    tables: &TransactionTables<'_>,
    known: JobRecord,
    asked: &JobRecord,
    asked_work: &JobWork,
) -> Result<SubmitOutcome, Refusal> {
    let same = match known.asks_the_same(asked) {
        Some(same) => same,
        None => works::get(tables, &known.id)?.is_some_and(|work| known.asks_the_same_work(&work, asked, asked_work)),
    };
    if same {
        Ok(SubmitOutcome::Known(Box::new(known)))
    } else {
        Err(Refusal::RequestIdReused(asked.request_id.clone()))
    }
}

/// Adds the outcome of a question to the work of a job, unless the job has ended.
pub(super) fn settle(tables: &TransactionTables<'_>, id: &str, settled: Settled) -> Result<(), Refusal> {
    match (get(tables, id)?, works::get(tables, id)?) {
        (Some(record), Some(mut work)) if !record.state.ended() => {
            work.settle(settled);
            works::put(tables, id, &work)
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use uuid::{NoContext, Timestamp};

    use super::*;
    use crate::ledger::record::tests::record;

    #[test]
    fn identities_ascend_when_the_clock_is_set_back() {
        let first = Uuid::from_u128(0x0190_0000_0000_7000_8000_0000_0000_0007);
        let earlier = Uuid::from_u128(0x0180_0000_0000_7000_8000_0000_0000_0000);
        let later = Uuid::from_u128(0x0190_0000_0001_7000_8000_0000_0000_0000);
        assert_eq!(after(None, earlier), earlier);
        assert_eq!(after(Some(first), later), later);
        let second = after(Some(first), earlier);
        assert!(second > first && after(Some(second), first) > second);
        assert!(second.to_string() > first.to_string(), "texts are ordered as identities are");
    }

    /// The clock shows these milliseconds at three submits; their times.
    fn submitted(clock: [u64; 3]) -> [i64; 3] {
        let backend = redb::backends::InMemoryBackend::new();
        let database = redb::Database::builder().create_with_backend(backend).unwrap();
        let txn = database.begin_write().unwrap();
        let tables = TransactionTables::of(&txn);
        let mut last = String::new();
        clock.map(|ms| {
            let at = Timestamp::from_unix(NoContext, ms / 1000, (ms % 1000) as u32 * 1_000_000);
            let (id, submitted_ms) = next_job(&tables, Uuid::new_v7(at)).unwrap();
            assert!(id > last, "identities ascend");
            put(&tables, &JobRecord { submitted_ms, ..record(&id) }).unwrap();
            last = id;
            submitted_ms
        })
    }

    #[test]
    fn no_submit_is_before_the_last_one_unless_the_clock_was_far_ahead() {
        let (now, hour) = (1_764_000_000_000, 3_600_000);
        assert_eq!(submitted([now, now, now + 5]), [now, now, now + 5].map(u64::cast_signed));
        assert_eq!(submitted([now, now - 2000, now + 1]), [now, now, now + 1].map(u64::cast_signed));
        assert_eq!(submitted([now, now - 60_000, now - 60_000]), [now; 3].map(u64::cast_signed));
        let set_back = [now + hour, now, now + 7];
        assert_eq!(submitted(set_back), set_back.map(u64::cast_signed), "a status shows the clock again");
    }
}
