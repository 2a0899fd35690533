//! Whether a job can be accepted now.
//!
//! *Invariant:* a submit that repeats an earlier one is answered even when no job can be accepted.

use std::sync::Arc;

use super::Core;
use crate::ledger::NewJob;
use crate::ledger::record::Record;
use crate::reason::Refusal;

/// A place in the queue for a job of a tenant, if a job can be accepted now.
pub(super) fn place(core: &Arc<Core>, tenant: &str) -> Result<impl Drop + Send + use<>, Refusal> {
    if !*core.ledger.writable().borrow() {
        return Err(Refusal::Storage("the ledger cannot be written at the moment".to_owned()));
    }
    core.room()?;
    core.within_quotas(tenant)?;
    core.reserve(tenant)
}

/// The answer to a submit that repeats an earlier one.
pub(super) fn known(core: &Core, job: &NewJob) -> Result<Option<(Box<Record>, bool)>, Refusal> {
    let NewJob { record, work } = job;
    let Some(known) = core.ledger.by_request(&record.tenant, &record.request_id)? else { return Ok(None) };
    let same = match known.asks_the_same(record) {
        Some(same) => same,
        None => known.asks_the_same_work(&core.work(&known.id)?, record, work),
    };
    if !same {
        return Err(Refusal::RequestIdReused(record.request_id.clone()));
    }
    core.answered(&known)?;
    Ok(Some((Box::new(core.current(known)), true)))
}
