//! Follows the states of many jobs, over broken connections and restarts of the server.
//!
//! *Invariants:* a job that has changed is delivered with its newest state at least once; a client that lists the jobs
//! when it receives `Anew` misses no change; `next` may be dropped and called again.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::{Instant, sleep_until, timeout};
use tonic::Streaming;

use crate::backoff::Backoff;
use crate::connection::Connection;
use crate::error::Error;
use crate::v1;

/// Heartbeat that is requested.
const HEARTBEAT: Duration = Duration::from_secs(5);
/// How long a silent stream counts as alive.
const PATIENCE: Duration = Duration::from_secs(20);

/// The items of a watch of many jobs.
#[derive(Debug, Clone, PartialEq)]
pub enum JobUpdate {
    /// A job, with its newest state.
    Job(Box<v1::JobStatus>),
    /// The job with this identity was removed.
    Removed(String),
    /// The server no longer knows all changes since the cursor, for example after a restart. The jobs that have not
    /// ended follow. To find the jobs that have ended in the meantime, call `ListJobs` when you receive this update.
    /// The watch has already restarted, so it delivers all later changes. Compare the jobs by their ids: ends are not
    /// delivered in the order of their times.
    Anew,
}

/// A watch of many jobs.
#[derive(Debug)]
pub struct WatchJobs {
    connection: Connection,
    filter: v1::JobFilter,
    cursor: u64,
    /// The cursor was too old, and the caller does not know this yet.
    anew: bool,
    stream: Option<Streaming<v1::WatchJobsResponse>>,
    waiting: VecDeque<JobUpdate>,
    backoff: Backoff,
    /// When the next attempt is due.
    due: Option<Instant>,
}

impl WatchJobs {
    pub(crate) fn new(connection: Connection, filter: v1::JobFilter) -> Self {
        let backoff = Backoff::of(&connection.settings);
        let (cursor, waiting) = (0, VecDeque::new());
        Self { connection, filter, cursor, anew: false, stream: None, waiting, backoff, due: None }
    }

    /// Continues at the cursor of an earlier watch instead of at the jobs that have not ended.
    #[must_use]
    pub fn after(mut self, cursor: u64) -> Self {
        self.cursor = cursor;
        self
    }

    /// Changes up to it have been delivered, unless `next` has not returned all of the last message yet.
    #[must_use]
    pub fn cursor(&self) -> u64 {
        self.cursor
    }

    /// The next item.
    ///
    /// # Errors
    /// When the server refuses, or was not reached within the patience of the client.
    pub async fn next(&mut self) -> Result<JobUpdate, Error> {
        loop {
            if let Some(update) = self.waiting.pop_front() {
                return Ok(update);
            }
            if let Some(due) = self.due {
                sleep_until(due).await;
                self.due = None;
            }
            match self.message().await {
                Ok(message) => {
                    self.backoff.succeeded();
                    self.take(message);
                }
                Err(error) => {
                    self.stream = None;
                    if error.reason().as_deref() == Some("CURSOR_TOO_OLD") && self.cursor > 0 {
                        (self.cursor, self.anew) = (0, true);
                        continue;
                    }
                    let pause = if error.is_passing() { self.backoff.failed(&error) } else { None };
                    let Some(pause) = pause else { return Err(error) };
                    self.due = Some(Instant::now() + pause);
                }
            }
        }
    }

    /// The next message of the stream; opens a stream first if none is open.
    async fn message(&mut self) -> Result<v1::WatchJobsResponse, Error> {
        let silent = |_| Error::from(tonic::Status::unavailable("the watch was silent for too long"));
        let stream = match &mut self.stream {
            Some(stream) => stream,
            none => {
                let request = v1::WatchJobsRequest {
                    filter: Some(self.filter.clone()),
                    after: self.cursor,
                    heartbeat_ms: u32::try_from(HEARTBEAT.as_millis()).unwrap_or(u32::MAX),
                };
                let mut jobs = self.connection.jobs();
                let answer = timeout(PATIENCE, jobs.watch_jobs(request)).await.map_err(silent)??;
                none.insert(answer.into_inner())
            }
        };
        let message = timeout(PATIENCE, stream.message()).await.map_err(silent)??;
        message.ok_or_else(|| tonic::Status::unavailable("the server ended the stream").into())
    }

    fn take(&mut self, message: v1::WatchJobsResponse) {
        // The server has followed all changes since before this message.
        if std::mem::take(&mut self.anew) {
            self.waiting.push_back(JobUpdate::Anew);
        }
        for change in message.changes {
            let job = change.status.unwrap_or_default();
            self.waiting.push_back(match change.removed {
                true => JobUpdate::Removed(job.job_id),
                false => JobUpdate::Job(Box::new(job)),
            });
        }
        // Without a cursor the jobs that have not ended are not complete yet.
        if message.cursor > 0 {
            self.cursor = message.cursor;
        }
    }
}
