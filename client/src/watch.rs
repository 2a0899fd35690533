//! Follows a job to its end, over broken connections and restarts of the server.
//!
//! *Invariants:* every event of the level is delivered once and in order; a watch ends with [`Update::Ended`] or an
//! error, never quietly; `next` may be dropped and called again.

use std::time::Duration;

use tokio::time::{Instant, sleep_until, timeout};
use tonic::Streaming;

use crate::backoff::Backoff;
use crate::connection::Connection;
use crate::error::Error;
use crate::v1;
use crate::v1::watch_job_response::Content;

/// Heartbeat that is requested unless the caller chooses another.
const HEARTBEAT: Duration = Duration::from_secs(5);
/// Beyond two heartbeats, how long a silent stream counts as alive.
const SILENCE: Duration = Duration::from_secs(10);

/// Longest time in which the server closes the stream of a job that has ended.
const CLOSING: Duration = Duration::from_secs(1);

/// The items of a watch.
#[derive(Debug, Clone, PartialEq)]
pub enum Update {
    /// The fixed data of the job; once, before the first events.
    Description(v1::JobDescription),
    /// Events; [`Watch::cursor`] is after them.
    Events(v1::EventBatch),
    /// Where the job is now.
    Progress(v1::Progress),
    /// The job has ended; nothing comes after it.
    Ended(Box<v1::JobStatus>),
}

/// A watch of one job.
#[derive(Debug)]
pub struct Watch {
    connection: Connection,
    job: String,
    level: v1::WatchLevel,
    heartbeat: Duration,
    cursor: u64,
    described: bool,
    stream: Option<Streaming<v1::WatchJobResponse>>,
    backoff: Backoff,
    /// When the next attempt is due.
    due: Option<Instant>,
    ended: Option<v1::JobStatus>,
    reconnects: u64,
}

impl Watch {
    pub(crate) fn new(connection: Connection, job: &str, level: v1::WatchLevel) -> Self {
        let backoff = Backoff::of(&connection.settings);
        Self {
            connection,
            job: job.to_owned(),
            level,
            heartbeat: HEARTBEAT,
            cursor: 0,
            described: false,
            stream: None,
            backoff,
            due: None,
            ended: None,
            reconnects: 0,
        }
    }

    /// Continues after this event instead of at the first one.
    #[must_use]
    pub fn after(mut self, cursor: u64) -> Self {
        self.cursor = cursor;
        self
    }

    /// Longest time without a message, 0.1 to 60 s.
    #[must_use]
    pub fn heartbeat(mut self, heartbeat: Duration) -> Self {
        self.heartbeat = heartbeat;
        self
    }

    /// Number of the last event that was delivered or that the level leaves out. A watch that is made later with
    /// [`Watch::after`] continues there.
    #[must_use]
    pub fn cursor(&self) -> u64 {
        self.cursor
    }

    /// How often the stream had to be made again.
    #[must_use]
    pub fn reconnects(&self) -> u64 {
        self.reconnects
    }

    /// The next update. After [`Update::Ended`] the same is returned again.
    ///
    /// # Errors
    /// When the server refuses, does not keep to the contract, or was not reached within the patience of the client.
    pub async fn next(&mut self) -> Result<Update, Error> {
        loop {
            if let Some(status) = self.ended.clone() {
                self.close().await;
                return Ok(Update::Ended(Box::new(status)));
            }
            if let Some(due) = self.due {
                sleep_until(due).await;
                self.due = None;
            }
            match self.message().await {
                Ok(Some(content)) => {
                    self.backoff.succeeded();
                    if let Some(update) = self.take(content)? {
                        return Ok(update);
                    }
                }
                Ok(None) => {}
                Err(error) => {
                    self.stream = None;
                    let pause = if error.is_passing() { self.backoff.failed(&error) } else { None };
                    let Some(pause) = pause else { return Err(error) };
                    self.reconnects += 1;
                    self.due = Some(Instant::now() + pause);
                }
            }
        }
    }

    /// The next message of the stream; opens a stream first if none is open.
    async fn message(&mut self) -> Result<Option<Content>, Error> {
        let patience = self.heartbeat * 2 + SILENCE;
        let silent = |_| Error::from(tonic::Status::unavailable("the watch was silent for too long"));
        if self.stream.is_none() {
            let request = v1::WatchJobRequest {
                job_id: self.job.clone(),
                after_seq: self.cursor,
                level: self.level.into(),
                heartbeat_ms: u32::try_from(self.heartbeat.as_millis()).unwrap_or(u32::MAX),
            };
            let mut jobs = self.connection.jobs();
            let answer = timeout(patience, jobs.watch_job(request)).await.map_err(silent)??;
            self.stream = Some(answer.into_inner());
        }
        let Some(stream) = &mut self.stream else { return Ok(None) };
        match timeout(patience, stream.message()).await.map_err(silent)?? {
            Some(message) => Ok(message.content),
            None => Err(tonic::Status::unavailable("the server ended the stream").into()),
        }
    }

    /// Reads the stream to its end. A stream that is dropped before its end is reset. After about a thousand streams
    /// that were reset while the server was closing them, HTTP/2 closes the connection with all other calls on it.
    async fn close(&mut self) {
        if let Some(stream) = &mut self.stream {
            let _ = timeout(CLOSING, async { while let Ok(Some(_)) = stream.message().await {} }).await;
        }
        self.stream = None;
    }

    fn take(&mut self, content: Content) -> Result<Option<Update>, Error> {
        Ok(match content {
            Content::Description(_) if std::mem::replace(&mut self.described, true) => None,
            Content::Description(description) => Some(Update::Description(description)),
            Content::Batch(batch) => self.fresh(batch)?.map(Update::Events),
            Content::Progress(progress) => {
                self.cursor = self.cursor.max(progress.position);
                Some(Update::Progress(progress))
            }
            Content::Ended(status) => {
                self.ended = Some(status);
                None
            }
        })
    }

    /// The part of a batch that was not delivered before.
    fn fresh(&mut self, mut batch: v1::EventBatch) -> Result<Option<v1::EventBatch>, Error> {
        if batch.last_seq <= self.cursor {
            return Ok(None);
        }
        if self.level == v1::WatchLevel::Everything && batch.first_seq > self.cursor + 1 {
            return Err(Error::Contract(format!(
                "event {} of job {} was followed by event {}",
                self.cursor, self.job, batch.first_seq
            )));
        }
        if batch.first_seq <= self.cursor {
            batch.events.retain(|event| event.seq > self.cursor);
            batch.first_seq = self.cursor + 1;
        }
        self.cursor = batch.last_seq;
        Ok(Some(batch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ClientSettings;

    fn watch(level: v1::WatchLevel, cursor: u64) -> Watch {
        let channel = tonic::transport::Endpoint::from_static("http://127.0.0.1:1").connect_lazy();
        let settings = ClientSettings::new("http://127.0.0.1:1");
        Watch::new(Connection::over(channel, &settings), "job", level).after(cursor)
    }

    fn batch(first_seq: u64, last_seq: u64) -> v1::EventBatch {
        let events = (first_seq..=last_seq).map(|seq| v1::Event { seq, ..Default::default() }).collect();
        v1::EventBatch { first_seq, last_seq, events, ..Default::default() }
    }

    #[tokio::test]
    async fn what_comes_twice_is_removed_and_a_gap_is_an_error() {
        let mut everything = watch(v1::WatchLevel::Everything, 10);
        assert_eq!(everything.fresh(batch(1, 10)).unwrap(), None);
        let fresh = everything.fresh(batch(9, 13)).unwrap().unwrap();
        let numbers: Vec<u64> = fresh.events.iter().map(|event| event.seq).collect();
        assert_eq!((fresh.first_seq, numbers, everything.cursor()), (11, vec![11, 12, 13], 13));
        assert!(everything.fresh(batch(15, 16)).unwrap_err().to_string().contains("followed by event 15"));
        let mut blocks = watch(v1::WatchLevel::Blocks, 10);
        assert!(blocks.fresh(batch(15, 16)).unwrap().is_some(), "other levels leave events out");
    }
}
