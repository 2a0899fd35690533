//! How a run ended.

/// How the run ended, beyond the content of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunEnd {
    /// Events in the log.
    pub events: u64,
    /// It was cancelled.
    pub cancelled: bool,
    /// The sink refused events.
    pub sink_failed: bool,
}
