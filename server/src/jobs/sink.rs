//! Receives a job's events on the kernel's side: log, results, and the few facts the server keeps.
//!
//! Invariant: nothing here waits for a watcher.

use std::io;

use counterpoint_kernel::job::Sink;
use counterpoint_kernel::log::event::{Event, Kind};

use super::live::{Live, lock};
use crate::results::Folds;

/// What a run leaves behind.
pub(crate) struct JobSink<'a> {
    live: &'a Live,
    pub(crate) folds: Folds,
    pub(crate) severity: u8,
    pub(crate) verdict: Option<String>,
    pub(crate) error: Option<io::Error>,
}

impl<'a> JobSink<'a> {
    pub(crate) fn new(live: &'a Live, folds: Folds) -> Self {
        Self { live, folds, severity: 0, verdict: None, error: None }
    }

    fn note(&mut self, event: &Event) {
        match &event.kind {
            Kind::Wait(wait) => {
                let others = wait.participants.iter().filter(|&&c| c != event.channel);
                let others: Vec<String> = others.map(ToString::to_string).collect();
                self.waits(event.channel, format!("{} with {}", wait.key, others.join(", ")));
            }
            Kind::Release(_) => self.waits(event.channel, String::new()),
            Kind::Diagnostic(diagnostic) => self.severity = self.severity.max(diagnostic.severity),
            Kind::Verdict(verdict) => self.verdict = Some(verdict.text.to_string()),
            _ => {}
        }
    }

    fn waits(&self, channel: u16, text: String) {
        let Some(run) = self.live.run() else { return };
        let mut waits = lock(&run.waits);
        let places = run.info.channels.iter().zip(waits.iter_mut());
        if let Some((_, place)) = places.into_iter().find(|(c, _)| c.number == channel) {
            *place = text;
        }
    }
}

impl Sink for JobSink<'_> {
    fn events(&mut self, first_seq: u64, batch: &[Event]) -> bool {
        if let Err(error) = self.live.append(first_seq, batch) {
            self.error = Some(error);
            return false;
        }
        for (seq, event) in (first_seq..).zip(batch) {
            self.folds.event(seq, event);
            self.note(event);
        }
        true
    }
}
