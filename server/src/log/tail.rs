//! How far a log has come: what its writer tells its readers.
//!
//! Invariant: bytes below [`Position::bytes`] are in the file and will not change.

use tokio::sync::watch;

/// End of the readable part of a log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Position {
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

    pub(crate) fn set(&self, position: Position) {
        self.0.send_replace(position);
    }

    pub(crate) fn follow(&self) -> watch::Receiver<Position> {
        self.0.subscribe()
    }
}
