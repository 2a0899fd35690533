//! Receives a job's events on the kernel's side: log and results.
//!
//! Invariant: nothing here waits for a watcher. The kernels make the results, with a log or without one.

use std::io;
use std::sync::Arc;

use counterpoint_kernel::job::{LogSink, WrittenFiles};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::Event;
use prometheus_client::metrics::counter::Counter;

use super::Core;
use super::flusher::Flusher;
use super::live::LiveJob;

/// Output of a run.
pub(crate) struct JobSink<'a> {
    live: &'a Arc<LiveJob>,
    flusher: &'a Flusher,
    events: &'a Counter,
    logged: bool,
    pub(crate) builder: ResultsBuilder,
    pub(crate) files: WrittenFiles,
    /// The files have more bytes than the job may keep.
    pub(crate) dropped: bool,
    /// Whether events came after a request that ends only this run. They are not in the log, because the repeated run
    /// has other events there.
    pub(crate) cut: bool,
    pub(crate) error: Option<io::Error>,
}

impl<'a> JobSink<'a> {
    pub(crate) fn new(live: &'a Arc<LiveJob>, core: &'a Core, builder: ResultsBuilder) -> Self {
        let (flusher, events, logged) = (&core.flusher, &core.metrics.jobs.events, core.options.embedded.log);
        Self {
            live,
            flusher,
            events,
            logged,
            builder,
            files: WrittenFiles::new(),
            dropped: false,
            cut: false,
            error: None,
        }
    }
}

impl LogSink for JobSink<'_> {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.builder)
    }

    fn is_logged(&self) -> bool {
        self.logged
    }

    fn files(&mut self, files: WrittenFiles) {
        let bytes = files.iter().map(|(path, text)| (path.len() + text.len()) as u64).sum();
        match self.live.check_bytes(bytes) {
            true => self.files = files,
            false => self.dropped = true,
        }
    }

    fn events(&mut self, first_seq: u64, batch: &[Event]) -> bool {
        self.cut |= self.live.will_be_repeated();
        if self.cut {
            return true;
        }
        match self.live.append(first_seq, batch) {
            Ok(true) => self.flusher.later(self.live),
            Ok(false) => {}
            Err(error) => {
                self.error = Some(error);
                return false;
            }
        }
        self.events.inc_by(batch.len() as u64);
        true
    }
}
