//! Receives a job's events on the kernel's side: log and results.
//!
//! Invariant: nothing here waits for a watcher. A job that keeps no log gives its results to the kernels to feed.

use std::io;

use counterpoint_kernel::job::{Sink, WrittenFiles};
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::fold::Folds;
use prometheus_client::metrics::counter::Counter;

use super::live::Live;

/// What a run leaves behind.
pub(crate) struct JobSink<'a> {
    live: &'a Live,
    events: &'a Counter,
    logged: bool,
    pub(crate) folds: Folds,
    pub(crate) files: WrittenFiles,
    /// The files have more bytes than the job may keep.
    pub(crate) dropped: bool,
    pub(crate) error: Option<io::Error>,
}

impl<'a> JobSink<'a> {
    /// `logged`: the live job has a log.
    pub(crate) fn new(live: &'a Live, events: &'a Counter, logged: bool, folds: Folds) -> Self {
        Self { live, events, logged, folds, files: WrittenFiles::new(), dropped: false, error: None }
    }
}

impl Sink for JobSink<'_> {
    fn folds(&mut self) -> Option<&mut Folds> {
        (!self.logged).then_some(&mut self.folds)
    }

    fn files(&mut self, files: WrittenFiles) {
        let bytes = files.iter().map(|(path, text)| (path.len() + text.len()) as u64).sum();
        match self.live.check_bytes(bytes) {
            true => self.files = files,
            false => self.dropped = true,
        }
    }

    fn events(&mut self, first_seq: u64, batch: &[Event]) -> bool {
        if let Err(error) = self.live.append(first_seq, batch) {
            self.error = Some(error);
            return false;
        }
        self.events.inc_by(batch.len() as u64);
        batch.iter().for_each(|event| self.folds.event(event));
        true
    }
}
