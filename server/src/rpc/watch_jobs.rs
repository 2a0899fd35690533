//! One watcher of many jobs.
//!
//! It follows the feed of changes by its cursor and sends the newest state of each job that has changed. Without a
//! cursor it starts with the jobs that have not ended, page by page; later changes follow from the feed. Invariant: a
//! client that resumes at its cursor misses no job that has changed.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use counterpoint_proto::v1;
use prost::Message as _;
use tokio::sync::mpsc;
use tokio::time::timeout;
use tonic::Status;

use super::look_up;
use super::watch::{Over, SMALLEST, heartbeat};
use crate::access::Caller;
use crate::jobs::Core;
use crate::jobs::feed::JobChange;
use crate::jobs::filter::{JobConditions, OPEN};
use crate::jobs::operator_wait::status_for_follower;
use crate::ledger::{PAGE_BYTES, Query};
use crate::reason::Refusal;

/// Most changes of a message.
const GROUP: usize = 100;
/// Shortest time between two messages with changes: a job that changes often is sent with its newest state.
const PAUSE: Duration = Duration::from_millis(20);

type Out = mpsc::Sender<Result<v1::WatchJobsResponse, Status>>;

/// A watcher.
pub(super) struct JobFeedWatcher {
    core: Arc<Core>,
    tenant: String,
    /// Key of the identity that watches.
    identity: String,
    filter: JobConditions,
    heartbeat: Duration,
    /// Where the feed is read from; none: the jobs that have not ended come first.
    cursor: Option<u64>,
}

impl JobFeedWatcher {
    pub(super) fn new(core: Arc<Core>, caller: &Caller, request: v1::WatchJobsRequest) -> Result<Self, Refusal> {
        let cursor = Some(request.after).filter(|after| *after > 0);
        if let Some(cursor) = cursor {
            // A cursor that cannot be continued from is refused before the stream begins.
            core.feed().after(caller.tenant(), cursor, 0)?;
        }
        Ok(Self {
            filter: JobConditions::read(request.filter.unwrap_or_default())?,
            heartbeat: heartbeat(request.heartbeat_ms)?,
            tenant: caller.tenant().to_owned(),
            identity: caller.identity.key(),
            cursor,
            core,
        })
    }

    /// Serves the client until it has gone or the server drains.
    pub(super) async fn run(mut self, out: Out) {
        if let Err(Over::Refused(refusal)) = self.serve(&out).await {
            let _ = out.send(Err(refusal.into())).await;
        }
    }

    async fn serve(&mut self, out: &Out) -> Result<(), Over> {
        let (mut last, mut drain) = (self.core.feed().follow(), self.core.drain.follow());
        let mut cursor = match self.cursor {
            Some(cursor) => cursor,
            None => {
                let cursor = *last.borrow_and_update();
                self.open_jobs(out).await?;
                cursor
            }
        };
        // At once: the client learns its cursor.
        send(out, Vec::new(), cursor).await?;
        loop {
            last.mark_unchanged();
            let found = self.core.feed().after(&self.tenant, cursor, GROUP)?;
            let behind = found.cursor < *last.borrow_and_update();
            if found.cursor > cursor {
                cursor = found.cursor;
                let mut left = found.changes;
                while !left.is_empty() {
                    let (changes, rest) = self.read(left).await?;
                    left = rest;
                    if !changes.is_empty() {
                        // A client that resumes before the last part receives all parts again.
                        send(out, changes, if left.is_empty() { cursor } else { 0 }).await?;
                    }
                }
            }
            if *drain.borrow_and_update() {
                return Err(Refusal::Draining { cursor }.into());
            }
            if behind {
                continue;
            }
            tokio::select! {
                changed = timeout(self.heartbeat, last.changed()) => match changed {
                    Ok(_) => tokio::time::sleep(PAUSE).await,
                    Err(_) => send(out, Vec::new(), cursor).await?,
                },
                _ = drain.changed() => {}
                () = out.closed() => return Err(Over::Gone),
            }
        }
    }

    /// Sends the jobs that have not ended.
    async fn open_jobs(&self, out: &Out) -> Result<(), Over> {
        let mut open = self.filter.clone();
        match self.filter.states.among(&OPEN) {
            Some(states) => open.states = states,
            None => return Ok(()),
        }
        let mut after = String::new();
        loop {
            let (core, query) = (self.core.clone(), open.query(&self.tenant, &self.core, GROUP));
            let query = Query { after, ..query };
            let filter = self.filter.clone();
            let read = look_up(&self.core, &self.identity, move || {
                let page = core.ledger.jobs(&query)?;
                let jobs = page.jobs.into_iter().map(|record| core.current(record));
                let changes: Vec<_> =
                    jobs.filter(|record| filter.takes(record)).map(|r| change(status_for_follower(&core, r))).collect();
                Ok((changes, page.next))
            });
            let (jobs, next) = tokio::select! {
                read = read => read?,
                () = out.closed() => return Err(Over::Gone),
            };
            if !jobs.is_empty() {
                send(out, jobs, 0).await?;
            }
            match next {
                Some(next) => after = next,
                None => return Ok(()),
            }
        }
    }

    /// The newest states of jobs that have changed, as many as a message may have, and the changes left.
    async fn read(&self, changes: Vec<JobChange>) -> Result<(Vec<v1::JobChange>, Vec<JobChange>), Refusal> {
        let (core, filter) = (self.core.clone(), self.filter.clone());
        look_up(&self.core, &self.identity, move || {
            let (mut read, mut bytes) = (Vec::new(), 0);
            let mut changes = changes.into_iter();
            while bytes < PAGE_BYTES {
                let Some(JobChange { id, removed, .. }) = changes.next() else { break };
                if let Some(removed) = removed {
                    let status = v1::JobStatus { job_id: id.to_string(), ..Default::default() };
                    read.extend(filter.took(&removed).then_some(v1::JobChange { status: Some(status), removed: true }));
                    continue;
                }
                match core.job(&id) {
                    Ok(record) if filter.takes(&record) => {
                        let change = change(status_for_follower(&core, record));
                        bytes += change.encoded_len() as u64;
                        read.push(change);
                    }
                    Ok(_) => {}
                    // Removed since, or lost: its removal follows, or a request for it reports the fault.
                    Err(Refusal::UnknownJob(_) | Refusal::DataLoss(_)) => {}
                    Err(refusal) => return Err(refusal),
                }
            }
            Ok((read, changes.collect()))
        })
        .await
    }
}

fn change(status: v1::JobStatus) -> v1::JobChange {
    v1::JobChange { status: Some(status), removed: false }
}

async fn send(out: &Out, changes: Vec<v1::JobChange>, cursor: u64) -> Result<(), Over> {
    let mut response = v1::WatchJobsResponse { changes, cursor, padding: Bytes::new() };
    let length = response.encoded_len();
    if length < SMALLEST {
        response.padding = Bytes::from_static(&[0; SMALLEST]).slice(..SMALLEST - length);
    }
    out.send(Ok(response)).await.map_err(|_| Over::Gone)
}
