//! The wait of a running job for a client: for the answer to a dialog, or for a command of stepping.
//!
//! *Invariant:* only a running job waits. The followers of many jobs learn of the start and the end of each wait of more
//! than a second; the short waits for a fast client do not crowd the feed.

use std::collections::BTreeMap;

use counterpoint_proto::v1;

use super::Core;
use super::describe::status;
use super::live::{Live, lock};
use crate::clock::now_ms;
use crate::ledger::record::{Record, State};

impl Live {
    /// The wait of the run for a client.
    pub(crate) fn operator_wait(&self) -> Option<v1::OperatorWait> {
        let wait = |action: v1::OperatorAction, since_ms| v1::OperatorWait { action: action.into(), since_ms };
        let command = || Some(wait(v1::OperatorAction::Command, self.stepping_if_used()?.stands_since()?));
        let answer = || Some(wait(v1::OperatorAction::Answer, self.desk_if_used()?.asking_since()?));
        if self.state() == State::Running { answer().or_else(command) } else { None }
    }
}

/// The status of a job, with its wait for a client.
pub(crate) fn status_now(core: &Core, record: Record) -> v1::JobStatus {
    let live = if record.state == State::Running { core.live(&record.id) } else { None };
    v1::JobStatus { operator_wait: live.and_then(|live| live.operator_wait()), ..status(record) }
}

/// Waits of this time or more are told to the followers of many jobs, ms.
const TOLD_AFTER_MS: i64 = 1000;

/// The waits that the followers of many jobs know, by job: the start of each, ms since 1970.
#[derive(Debug, Default)]
pub(super) struct KnownWaits(BTreeMap<String, i64>);

impl KnownWaits {
    /// Tells the followers of many jobs of the runs that wait for a client since the last call, or no longer wait.
    pub(super) fn tell(&mut self, core: &Core) {
        let running = lock(&core.board.queue).jobs.running();
        let (mut waits, now) = (BTreeMap::new(), now_ms());
        for live in running.into_iter().filter_map(|id| core.live(&id)) {
            let since = live.operator_wait().map(|wait| wait.since_ms).filter(|since| *since <= now - TOLD_AFTER_MS);
            if since != self.0.get(&live.id).copied() {
                core.changed(&live);
            }
            waits.extend(since.map(|since| (live.id.clone(), since)));
        }
        self.0 = waits;
    }
}
