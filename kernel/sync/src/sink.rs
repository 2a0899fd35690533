//! The receiver of the log of a job.

use std::sync::Arc;

use counterpoint_event::event::Event;
use counterpoint_results::builder::ResultsBuilder;

/// Text files that macros have written, ascending by path with `/` between parts.
pub type WrittenFiles = Vec<(String, Arc<str>)>;

/// Receives the log of a job.
pub trait LogSink: Send {
    /// The results that the kernels make, each those of its own channel on its own thread; `None`: no results are
    /// requested.
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        None
    }

    /// Whether the ordered log is requested. Without it nothing is merged, and [`events`](Self::events) is never
    /// called.
    fn is_logged(&self) -> bool {
        true
    }

    /// The files that macros have written; once, when all kernels have ended.
    fn files(&mut self, files: WrittenFiles) {
        let _ = files;
    }

    /// A batch of events in log order; `first_seq` is the number of the first one (the log counts from 1).
    /// Returning `false` stops the run (the log cannot be kept, for example the disk is full).
    fn events(&mut self, first_seq: u64, batch: &[Event]) -> bool;
}
