//! The progress of a log, reported by its writer to its readers.
//!
//! Invariant: bytes below [`Position::bytes`] are in the file and will not change.

use tokio::sync::watch;

/// End of the readable part of a log. The log of a run that the host failed is dropped; the next run writes another
/// file with the same events.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Position {
    /// Logs dropped before this one.
    pub(crate) dropped: u32,
    /// Bytes of the file.
    pub(crate) bytes: u64,
    /// Last event in them.
    pub(crate) last_seq: u64,
}

/// Shared between one writer and any number of readers.
#[derive(Debug)]
pub(crate) struct Tail(watch::Sender<Position>);

impl Tail {
    pub(crate) fn new() -> Self {
        Self(watch::Sender::new(Position::default()))
    }

    pub(crate) fn set(&self, bytes: u64, last_seq: u64) {
        self.0.send_modify(|position| *position = Position { bytes, last_seq, ..*position });
    }

    /// The log has been dropped.
    pub(crate) fn begin_again(&self) {
        self.0.send_modify(|position| *position = Position { dropped: position.dropped + 1, ..Position::default() });
    }

    /// Whether there is a follower.
    pub(crate) fn followed(&self) -> bool {
        self.0.receiver_count() > 0
    }

    /// The end now.
    pub(crate) fn position(&self) -> Position {
        *self.0.borrow()
    }

    pub(crate) fn follow(&self) -> watch::Receiver<Position> {
        self.0.subscribe()
    }
}
