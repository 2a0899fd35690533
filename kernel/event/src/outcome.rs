//! How a run ended.

/// How the run ended, apart from what the log says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Events in the log.
    pub events: u64,
    /// It was cancelled.
    pub cancelled: bool,
    /// The sink refused events.
    pub sink_failed: bool,
}
