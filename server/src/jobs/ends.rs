//! The ends of jobs: made durable together, then visible.
//!
//! A worker hands the end of its job over and is done; the ledger keeps many ends in one transaction, and one thread
//! makes them visible. Invariant: an end is visible only when it is durable. While the ledger cannot be written an end
//! waits, until the server drains: then the job is run again by the next server.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use super::Core;
use super::live::LiveJob;
use crate::ledger::record::{JobRecord, JobState};
use crate::log::writer::Small;
use crate::reason::Refusal;
use crate::spans::JobSpans;
use crate::webhooks::Webhooks;

/// Time between two attempts to make the end of a job durable.
const PAUSE: Duration = Duration::from_millis(50);

/// The end of a job.
pub(super) struct JobEnd {
    core: Arc<Core>,
    live: Arc<LiveJob>,
    record: JobRecord,
    /// Its log, if that is small.
    log: Option<Small>,
}

/// Ends that the ledger has answered, and where spans and messages of jobs go.
#[derive(Debug)]
pub(crate) struct Ends {
    answered: Sender<(JobEnd, Result<(), Refusal>)>,
    spans: JobSpans,
    webhooks: Webhooks,
}

impl Ends {
    /// Starts the thread; it ends with the last handle.
    pub(super) fn start(spans: JobSpans, webhooks: Webhooks) -> io::Result<Self> {
        let (answered, receive) = channel();
        std::thread::Builder::new().name("ends".to_owned()).spawn(move || finish(&receive))?;
        Ok(Self { answered, spans, webhooks })
    }
}

impl JobEnd {
    pub(super) fn new(core: &Arc<Core>, live: &Arc<LiveJob>, record: JobRecord, log: Option<Small>) -> Self {
        Self { core: core.clone(), live: live.clone(), record, log }
    }

    /// Hands it over to the ledger.
    pub(super) fn keep(self) {
        let (ends, core) = (self.core.ends.answered.clone(), self.core.clone());
        let (record, log) = (self.record.clone(), self.log.as_ref().map(|log| log.bytes.clone()));
        let then = move |kept| {
            // Without the thread the server is ending.
            let _ = ends.send((self, kept));
        };
        core.ledger.end(record, log, Box::new(then));
    }

    /// Makes it visible and gives the place of the job free.
    fn show(self) {
        let Self { core, live, record, log } = self;
        core.board.tally.ended(&record);
        core.ended(&record);
        if let Some(log) = log.filter(|_| record.state.ended()) {
            live.tail().set(log.bytes.len() as u64, log.last_seq);
        }
        live.change(|now| {
            *now = JobRecord { cancel: now.cancel, paused: now.paused && !record.state.ended(), ..record }
        });
        core.free(&live);
    }
}

fn finish(ends: &Receiver<(JobEnd, Result<(), Refusal>)>) {
    let mut waiting: Vec<JobEnd> = Vec::new();
    let mut due = Instant::now();
    loop {
        let next = match waiting.is_empty() {
            true => ends.recv().map_err(|_| RecvTimeoutError::Disconnected),
            false if due <= Instant::now() => Err(RecvTimeoutError::Timeout),
            false => ends.recv_timeout(due.saturating_duration_since(Instant::now())),
        };
        match next {
            Ok((end, Ok(()))) => end.show(),
            Ok((end, Err(error))) if end.core.drain.begun() => {
                tracing::error!(%error, "the end of the job could not be kept; the next server runs it again");
                let record = JobRecord { state: JobState::Queued, ..end.live.record() };
                JobEnd { record, log: None, ..end }.show();
            }
            Ok((end, Err(_))) => {
                if waiting.is_empty() {
                    due = Instant::now() + PAUSE;
                }
                waiting.push(end);
            }
            Err(RecvTimeoutError::Timeout) => waiting.drain(..).for_each(JobEnd::keep),
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

impl Core {
    /// Lets monitoring see that a job has ended; others are left out.
    pub(super) fn ended(&self, record: &JobRecord) {
        self.metrics.ended(match record.state {
            JobState::Queued | JobState::Running => return,
            JobState::Succeeded => "SUCCEEDED",
            JobState::Failed => "FAILED",
            JobState::Cancelled => "CANCELLED",
        });
        if let Some(reached) = record.runs.reached {
            self.metrics.limit(reached.name());
        }
        self.ends.spans.ended(record);
        self.ends.webhooks.ended(record);
    }

    /// Sends the spans and the messages that are left.
    pub(crate) fn close_exports(&self) {
        self.ends.spans.close();
        self.ends.webhooks.close();
    }
}
