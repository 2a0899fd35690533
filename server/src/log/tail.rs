//! The progress of a log, reported by its writer to its readers.
//!
//! Invariant: bytes below [`ReadableEnd::bytes`] are in the file and will not change.

use tokio::sync::watch;

/// End of the readable part of a log. The log of a run that the host failed is dropped; the next run writes another
/// file with the same events.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct ReadableEnd {
    /// Logs dropped before this one.
    pub(crate) dropped: u32,
    /// Bytes of the file.
    pub(crate) bytes: u64,
    /// Last event in them.
    pub(crate) last_seq: u64,
}

/// Shared between one writer and any number of readers.
#[derive(Debug)]
pub(crate) struct Tail(watch::Sender<ReadableEnd>);

impl Tail {
    pub(crate) fn new() -> Self {
        Self(watch::Sender::new(ReadableEnd::default()))
    }

    pub(crate) fn set(&self, bytes: u64, last_seq: u64) {
        self.0.send_modify(|position| *position = ReadableEnd { bytes, last_seq, ..*position });
    }

    /// The log has been dropped.
    pub(crate) fn begin_again(&self) {
        self.0.send_modify(|position| {
            *position = ReadableEnd { dropped: position.dropped + 1, ..ReadableEnd::default() }
        });
    }

    /// Whether there is a follower.
    pub(crate) fn followed(&self) -> bool {
        self.0.receiver_count() > 0
    }

    /// The end now.
    pub(crate) fn position(&self) -> ReadableEnd {
        *self.0.borrow()
    }

    pub(crate) fn follow(&self) -> watch::Receiver<ReadableEnd> {
        self.0.subscribe()
    }
}
