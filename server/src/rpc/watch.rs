//! One watcher of one job.
//!
//! It pulls from the log by its cursor, at the pace of its client: one message may be in transit. For a client that
//! does not read nothing else is held: batches read ahead are dropped and read again later. Invariant: a watcher never
//! makes a kernel, a log or another watcher wait; it sees each event after its cursor exactly once, in order, and the
//! end of the job last.

use std::ops::RangeInclusive;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use prost::Message as _;
use tokio::sync::mpsc;
use tokio::time::Instant;
use tonic::Status;

use super::blocking;
use crate::jobs::Core;
use crate::jobs::describe::status;
use crate::jobs::live::LiveJob;
use crate::jobs::progress;
use crate::jobs::streams::Listed;
use crate::ledger::record::JobState;
use crate::log::damage::{cut_short, gone};
use crate::log::filter::BatchFilter;
use crate::log::kept::StoredLog;
use crate::log::reader::{Batch, LogReader, ResumePoint};
use crate::log::tail::ReadableEnd;
use crate::reason::Refusal;

/// Progress at most this often.
const PROGRESS_EVERY: Duration = Duration::from_millis(100);
/// A sign of life on an idle stream, unless the client asks for another interval.
const HEARTBEAT_MS: u32 = 5_000;
/// Intervals that it may ask for, ms.
const HEARTBEATS_MS: RangeInclusive<u32> = 100..=60_000;
/// Bytes read from the log at once: at first, and for a client that has kept pace for this many reads.
const FIRST_PULL: usize = 32 * 1024;
const PULL: usize = 256 * 1024;
const PACE: u32 = 8;
/// Time after which a client that takes nothing counts as stalled.
const STALL: Duration = Duration::from_millis(100);
/// Messages below this size are padded up to it: receivers count small HTTP/2 frames as a flood.
pub(super) const SMALLEST: usize = 256;

/// Interval between signs of life that a client asks for.
pub(super) fn heartbeat(asked_ms: u32) -> Result<Duration, Refusal> {
    let ms = if asked_ms == 0 { HEARTBEAT_MS } else { asked_ms };
    if !HEARTBEATS_MS.contains(&ms) {
        return Err(Refusal::field("heartbeat_ms", "must be 0, or 100 to 60,000"));
    }
    Ok(Duration::from_millis(ms.into()))
}

type Out = mpsc::Sender<Result<v1::WatchJobResponse, Status>>;

/// A watcher.
pub(super) struct JobWatcher {
    core: Arc<Core>,
    live: Arc<LiveJob>,
    listed: Listed,
    level: v1::WatchLevel,
    heartbeat: Duration,
    cursor: u64,
    reader: Option<LogReader>,
    /// Reads since the client stood still.
    kept_pace: u32,
    /// Where the log is to be read on after the client stood still.
    resume: Option<ResumePoint>,
    described: bool,
    /// Logs that the job has dropped, as far as known.
    dropped: u32,
    filter: BatchFilter,
    last_progress: v1::Progress,
    /// When progress was last looked at, and when it was last sent.
    looked_at: Instant,
    sent_at: Instant,
}

/// Why a watch is over, of one job or of many.
pub(super) enum Over {
    /// The client has gone.
    Gone,
    /// To be reported to the client.
    Refused(Refusal),
}

impl From<Refusal> for Over {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl JobWatcher {
    pub(super) fn new(core: Arc<Core>, request: v1::WatchJobRequest) -> Result<Self, Refusal> {
        let level = v1::WatchLevel::try_from(request.level)
            .map_err(|_| Refusal::field("level", format!("{} is not a level", request.level)))?;
        let heartbeat = heartbeat(request.heartbeat_ms)?;
        let live = match core.live(&request.job_id) {
            Some(live) => live,
            None => from_ledger(&core, &request.job_id)?,
        };
        Ok(Self {
            listed: core.streams.list(live.clone()),
            core,
            live,
            level,
            heartbeat,
            cursor: request.after_seq,
            reader: None,
            kept_pace: 0,
            resume: None,
            described: false,
            dropped: 0,
            filter: BatchFilter::new(level),
            last_progress: v1::Progress::default(),
            looked_at: Instant::now(),
            sent_at: Instant::now(),
        })
    }

    /// Serves the client until the job has ended, the client has gone, or the server drains.
    pub(super) async fn run(mut self, out: Out) {
        if let Err(Over::Refused(refusal)) = self.serve(&out).await {
            let _ = out.send(Err(refusal.into())).await;
        }
    }

    async fn serve(&mut self, out: &Out) -> Result<(), Over> {
        let (mut states, mut tail) = (self.live.follow(), self.live.tail().follow());
        let mut drain = self.core.drain.follow();
        self.progress(out, true).await?;
        let live = self.live.clone();
        // Events from before the first follower; the flusher handles all later ones.
        let flush = move || {
            live.flush();
            Ok(())
        };
        if self.live.may_flush() {
            blocking(flush).await?;
        }
        loop {
            // The state is read before the position: when it says ended, the position is final.
            let state = *states.borrow_and_update();
            let position = *tail.borrow_and_update();
            if !self.batches(out, position).await? {
                continue;
            }
            if state.ended() {
                return self.end(out, position).await;
            }
            if *drain.borrow_and_update() && state != JobState::Running {
                return Err(Refusal::Draining { cursor: self.cursor }.into());
            }
            self.progress(out, false).await?;
            let follows_log = self.level > v1::WatchLevel::Progress || self.reader.is_none();
            tokio::select! {
                _ = states.changed() => {}
                _ = tail.changed(), if follows_log => {}
                _ = drain.changed() => {}
                () = tokio::time::sleep_until(self.looked_at + PROGRESS_EVERY) => {}
                () = out.closed() => return Err(Over::Gone),
            }
        }
    }

    /// Sends the events of the log after the cursor; `false` if the client stopped reading meanwhile.
    async fn batches(&mut self, out: &Out, position: ReadableEnd) -> Result<bool, Over> {
        if position.dropped != self.dropped {
            (self.dropped, self.reader, self.resume) = (position.dropped, None, None);
        }
        if position.bytes == 0 || self.reader.is_none() && !self.open(out).await? {
            return Ok(true);
        }
        if self.level <= v1::WatchLevel::Progress {
            self.cursor = self.cursor.max(position.last_seq);
            return Ok(true);
        }
        while let Some(mut reader) = self.reader.take() {
            reader.extend(position.bytes);
            let (most, slow) = (most(self.kept_pace), self.kept_pace < PACE);
            let (reader, batches) = if reader.in_memory() {
                pull(reader, most, slow)?
            } else {
                let _place = self.core.streams.reading().await;
                blocking(move || pull(reader, most, slow)).await?
            };
            if batches.is_empty() {
                self.reader = Some(reader);
                break;
            }
            for mut batch in batches {
                let keeps_pace = out.try_reserve().is_ok();
                if !keeps_pace {
                    if tokio::time::timeout(STALL, out.reserve()).await.is_err() {
                        self.resume = Some(batch.spot);
                        break;
                    }
                    // A part of a piece of the log would hold the whole piece for as long as the client takes nothing.
                    batch.body = Bytes::copy_from_slice(&batch.body);
                }
                self.batch(out, batch).await?;
            }
            self.kept_pace = self.kept_pace.saturating_add(1);
            if self.resume.is_some() {
                self.kept_pace = 0;
                drop(reader);
                out.reserve().await.map_err(|_| Over::Gone)?;
                return Ok(false);
            }
            self.reader = Some(reader);
        }
        if let Some(batch) = self.filter.take() {
            send_batch(out, batch).await?;
        }
        Ok(true)
    }

    /// Opens the log; `false` if it has just been dropped.
    async fn open(&mut self, out: &Out) -> Result<bool, Over> {
        let (after, resume) = (self.cursor, self.resume.take());
        let opened = if let Some(small) = self.live.small_log() {
            open(&small, resume, after)?
        } else {
            let (core, id) = (self.core.clone(), self.live.id.clone());
            let _place = self.core.streams.reading().await;
            blocking(move || match core.kept_log(&id)? {
                Some(log) => open(&log, resume, after),
                None => Ok(None),
            })
            .await?
        };
        let Some(reader) = opened else { return Ok(false) };
        if !std::mem::replace(&mut self.described, true) {
            send(out, Content::Description(reader.description().clone())).await?;
        }
        self.reader = Some(reader);
        Ok(true)
    }

    async fn batch(&mut self, out: &Out, batch: Batch) -> Result<(), Over> {
        self.cursor = batch.last;
        self.listed.reached(self.cursor);
        if self.level == v1::WatchLevel::Everything {
            return send_batch(out, batch.body).await;
        }
        self.filter.add(batch.first, batch.last, &batch.body);
        if !self.filter.full() {
            return Ok(());
        }
        match self.filter.take() {
            Some(batch) => send_batch(out, batch).await,
            None => Ok(()),
        }
    }

    /// Sends progress when it is due and has changed, or as a sign of life.
    async fn progress(&mut self, out: &Out, first: bool) -> Result<(), Over> {
        if !first && self.looked_at.elapsed() < PROGRESS_EVERY {
            return Ok(());
        }
        self.looked_at = Instant::now();
        let progress = progress::now(&self.core, &self.live, self.cursor);
        if first || progress != self.last_progress || self.sent_at.elapsed() >= self.heartbeat {
            self.last_progress = progress.clone();
            self.sent_at = Instant::now();
            send(out, Content::Progress(progress)).await?;
        }
        Ok(())
    }

    async fn end(&mut self, out: &Out, position: ReadableEnd) -> Result<(), Over> {
        let record = self.live.record();
        // A cursor of an earlier run may be after the end of a later one that was stopped: nothing is missing there.
        let commands = self.core.options.system.allow_system && record.machine.trusted;
        if self.cursor > position.last_seq && record.log_is_final() && !commands {
            return Err(Refusal::CursorBeyondLog { after: self.cursor, last: position.last_seq }.into());
        }
        if self.cursor < position.last_seq && self.level > v1::WatchLevel::Progress {
            let (core, id, cursor) = (self.core.clone(), self.live.id.clone(), self.cursor);
            let there = blocking(move || Ok(core.kept_log(&id)?.is_some())).await?;
            let id = &self.live.id;
            let error = if there { cut_short(id, cursor, position.last_seq) } else { gone(id) };
            return Err(Refusal::from(error).into());
        }
        self.progress(out, true).await?;
        send(out, Content::Ended(status(record))).await
    }
}

/// Opens a log at a place, or after an event; none if it has just been dropped.
fn open(log: &StoredLog, resume: Option<ResumePoint>, after: u64) -> Result<Option<LogReader>, Refusal> {
    let opened = match resume {
        Some(spot) => LogReader::resume(log, spot, after),
        None => LogReader::open(log, after),
    };
    match opened {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        other => Ok(Some(other?)),
    }
}

/// An ended job that is no longer in memory, as if it had just ended.
fn from_ledger(core: &Core, id: &str) -> Result<Arc<LiveJob>, Refusal> {
    let record = core.job(id)?;
    // Of a log that cannot be read there is nothing, which its watch then tells.
    let bytes = core.kept_log(id)?.map_or(0, |log| log.length().unwrap_or(0));
    let events = record.events;
    let live = LiveJob::new(record);
    live.tail().set(bytes, events);
    Ok(Arc::new(live))
}

/// Bytes to be read at once after this many reads for a client that has kept pace.
fn most(kept_pace: u32) -> usize {
    FIRST_PULL.saturating_mul(1 << kept_pace.saturating_sub(PACE - 1).min(16)).min(PULL)
}

/// Reads this many bytes of batches. For a client that may be slow, none of them holds more of the log than itself, and
/// the reader holds next to nothing.
fn pull(mut reader: LogReader, most: usize, slow: bool) -> Result<(LogReader, Vec<Batch>), Refusal> {
    let (mut batches, mut bytes) = (Vec::new(), 0);
    while bytes < most {
        let Some(mut batch) = reader.next_batch()? else { break };
        bytes += batch.body.len();
        if slow {
            batch.body = Bytes::copy_from_slice(&batch.body);
        }
        batches.push(batch);
    }
    if slow {
        reader.rest();
    }
    Ok((reader, batches))
}

async fn send_batch(out: &Out, batch: Bytes) -> Result<(), Over> {
    send(out, Content::Batch(v1::EventBatch::encoded(batch))).await
}

async fn send(out: &Out, content: Content) -> Result<(), Over> {
    let mut response = v1::WatchJobResponse { content: Some(content), padding: Bytes::new() };
    let length = response.encoded_len();
    if length < SMALLEST {
        response.padding = Bytes::from_static(&[0; SMALLEST]).slice(..SMALLEST - length);
    }
    out.send(Ok(response)).await.map_err(|_| Over::Gone)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_grow_for_a_client_that_keeps_pace() {
        let sizes: Vec<_> = (0..12).map(|reads| most(reads) / FIRST_PULL).collect();
        assert_eq!(sizes, [1, 1, 1, 1, 1, 1, 1, 1, 2, 4, 8, 8]);
        assert_eq!(most(u32::MAX), PULL);
    }
}
