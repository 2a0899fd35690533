//! The wait of a running job for a client: for the answer to a dialog, or for a command of stepping.
//!
//! *Invariant:* only a running job waits. Followers of many jobs are notified when a wait has lasted one second, and of
//! the end of each wait that one of them has seen. So short waits for a fast client do not crowd the feed.

use std::collections::BTreeMap;

use counterpoint_proto::v1;

use super::Core;
use super::describe::status;
use super::live::LiveJob;
use super::lock::lock;
use crate::clock::now_ms;
use crate::ledger::record::{JobRecord, JobState};

impl LiveJob {
    /// The wait of the run for a client.
    pub(crate) fn operator_wait(&self) -> Option<v1::OperatorWait> {
        let deadline_ms = self.peek(|record| record.asked.deadline_ms);
        let wait = |action: v1::OperatorAction, (since_ms, until_ms): (i64, i64)| v1::OperatorWait {
            action: action.into(),
            since_ms,
            until_ms: if deadline_ms > 0 { until_ms.min(deadline_ms) } else { until_ms },
        };
        let command = || Some(wait(v1::OperatorAction::Command, self.stepping_if_used()?.client_wait()?));
        let answer = || Some(wait(v1::OperatorAction::Answer, self.desk_if_used()?.wait()?));
        if self.state() == JobState::Running { answer().or_else(command) } else { None }
    }
}

/// The status of a job, with its wait for a client.
pub(crate) fn status_now(core: &Core, record: JobRecord) -> v1::JobStatus {
    let live = if record.state == JobState::Running { core.live(&record.id) } else { None };
    v1::JobStatus { operator_wait: live.and_then(|live| live.operator_wait()), ..status(record) }
}

/// The same for a client that follows many jobs: it is notified when the wait ends.
pub(crate) fn status_for_follower(core: &Core, record: JobRecord) -> v1::JobStatus {
    let status = status_now(core, record);
    if let Some(wait) = status.operator_wait {
        lock(&core.board.shown_waits).insert(status.job_id.clone(), wait.since_ms);
    }
    status
}

/// Time after which followers of many jobs are notified of a wait, ms.
const NOTIFY_AFTER_MS: i64 = 1000;

/// Notifies the followers of many jobs of runs that wait for a client, and of the ends of waits that they have seen.
pub(super) fn notify_followers(core: &Core) {
    let running = lock(&core.board.queue).jobs.running();
    let running: BTreeMap<_, _> = running.into_iter().filter_map(|id| Some((id.clone(), core.live(&id)?))).collect();
    lock(&core.board.shown_waits).retain(|id, _| running.contains_key(id));
    let now = now_ms();
    for (id, live) in running {
        let since = live.operator_wait().map(|wait| wait.since_ms);
        let changed = {
            let mut shown = lock(&core.board.shown_waits);
            match since {
                // A shown wait that has just been followed by the next one stays shown.
                Some(since) => since <= now - NOTIFY_AFTER_MS && shown.insert(id, since) != Some(since),
                None => shown.remove(&id).is_some(),
            }
        };
        if changed {
            core.changed(&live);
        }
    }
}
