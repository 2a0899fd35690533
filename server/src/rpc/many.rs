//! `CancelJobs` and `DeleteJobs`: apply the call for one job to the jobs of a filter, page by page.
//!
//! Invariants: a call reaches jobs of its tenant only, a bounded number of them, and none that was accepted after the
//! first page; it can be repeated after a failure. It runs to its end even if its client leaves.

use std::sync::Arc;

use counterpoint_proto::v1;
use tokio::task::JoinSet;
use tracing::Instrument as _;

use super::door::page_token;
use super::{look_up, to_the_end};
use crate::access::Caller;
use crate::jobs::Core;
use crate::jobs::filter::{ENDED, JobConditions, OPEN};
use crate::ledger::{PAGE_BYTES, Query};
use crate::reason::Refusal;

/// Maximum number of jobs in a call.
const MOST: usize = 500;
/// Jobs in progress at the same time: they share commits of the ledger.
const TOGETHER: usize = 32;

/// The selection of jobs in the request.
pub(super) struct Choice {
    pub(super) filter: Option<v1::JobFilter>,
    pub(super) all: bool,
    pub(super) dry_run: bool,
    pub(super) page_size: u32,
    pub(super) page_token: String,
}

/// Action on each job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BulkAction {
    Cancel,
    Delete,
}

impl BulkAction {
    /// Acts on one job. Returns `false` if the job has ended or was deleted since it was found.
    async fn on(self, core: &Arc<Core>, id: &str) -> Result<bool, Refusal> {
        let done = match self {
            Self::Cancel => core.cancel_first(id).await.map(|(_, first)| first),
            Self::Delete => core.delete(id).await.map(|()| true),
        };
        match done {
            Err(Refusal::UnknownJob(_) | Refusal::JobNotEnded(_)) => Ok(false),
            done => done,
        }
    }
}

/// The filter of a choice, with the states in which the act is possible.
fn filter(choice: &Choice, act: BulkAction) -> Result<JobConditions, Refusal> {
    page_token(&choice.page_token)?;
    let mut filter = JobConditions::read(choice.filter.clone().unwrap_or_default())?;
    match (filter.is_empty(), choice.all) {
        (true, false) => return Err(Refusal::field("filter", "has no condition: give one, or set all")),
        (false, true) => return Err(Refusal::field("all", "must not be set with a condition in the filter")),
        _ => {}
    }
    let (states, wanted) = match act {
        BulkAction::Cancel => (&OPEN[..], "QUEUED, RUNNING or PAUSED, as only such jobs can be cancelled"),
        BulkAction::Delete => (&ENDED[..], "SUCCEEDED, FAILED or CANCELLED, as only ended jobs can be deleted"),
    };
    let among = filter.states.among(states);
    filter.states = among.ok_or_else(|| Refusal::field("filter.states", format!("must have {wanted}")))?;
    Ok(filter)
}

/// Acts on a page of jobs; returns their ids and the token of the next page.
pub(super) async fn each(
    core: &Arc<Core>,
    caller: &Caller,
    choice: Choice,
    act: BulkAction,
) -> Result<(Vec<String>, String), Refusal> {
    let filter = filter(&choice, act)?;
    let size = if choice.page_size == 0 { MOST } else { (choice.page_size as usize).min(MOST) };
    let (core, tenant) = (core.clone(), caller.tenant().to_owned());
    let (find, of) = (core.clone(), filter.clone());
    let (ids, next) = look_up(&core, &caller.identity.key(), move || {
        let query = Query {
            newest_first: true,
            after: choice.page_token,
            most_bytes: PAGE_BYTES.min(find.memory().of_answers()),
            ..of.query(&tenant, &find, size)
        };
        let page = find.ledger.jobs(&query)?;
        let records = page.jobs.into_iter().map(|record| find.current(record));
        let due = records.filter(|record| of.takes(record) && (act == BulkAction::Delete || !record.cancel));
        Ok((due.map(|record| record.id).collect::<Vec<_>>(), page.next.unwrap_or_default()))
    })
    .await?;
    if choice.dry_run {
        return Ok((ids, next));
    }
    let span = tracing::info_span!("many jobs", act = ?act);
    let noted = caller.clone();
    let all = async move {
        let (done, failed) = act_on(&core, &noted, ids, act).await;
        failed.map_or(Ok((done, next)), Err)
    };
    to_the_end(caller, all.instrument(span)).await
}

/// Acts on jobs; returns the changed jobs, in their order, and the first failure. The changed jobs are noted for the
/// audit log.
async fn act_on(
    core: &Arc<Core>,
    caller: &Caller,
    ids: Vec<String>,
    act: BulkAction,
) -> (Vec<String>, Option<Refusal>) {
    let (mut done, mut failed) = (Vec::new(), None);
    for group in ids.chunks(TOGETHER) {
        caller.asks(group);
        let mut tasks = JoinSet::new();
        for (at, id) in group.iter().cloned().enumerate() {
            let core = core.clone();
            tasks.spawn(async move { (at, act.on(&core, &id).await) });
        }
        let mut outcomes = tasks.join_all().await;
        outcomes.sort_by_key(|(at, _)| *at);
        for (id, (_, outcome)) in group.iter().zip(outcomes) {
            match outcome {
                Ok(true) => done.push(id.clone()),
                Ok(false) => {}
                Err(refusal) => failed = failed.or(Some(refusal)),
            }
        }
        caller.about_jobs(&done);
        if failed.is_some() {
            break;
        }
    }
    (done, failed)
}
