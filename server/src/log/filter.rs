//! Which events a watcher of a given level sees.
//!
//! Invariant: filtering copies encoded events and never decodes or changes them; a filtered batch covers the same
//! sequence numbers as the batches it was made of.

use bytes::Bytes;
use counterpoint_proto::v1::WatchLevel;

use super::{decode, encode};

/// Whether an event with this oneof field belongs to a level below EVERYTHING.
fn wanted(level: WatchLevel, field: u64) -> bool {
    match level {
        WatchLevel::Unspecified | WatchLevel::Progress => false,
        // Lifecycle, stop, message, wait, release, diagnostic, verdict.
        WatchLevel::Diagnostics => matches!(field, 10 | 20 | 23..=27),
        // Block, tool and its data, call and return too.
        WatchLevel::Blocks => matches!(field, 10 | 11 | 14 | 20..=27 | 29),
        WatchLevel::Everything => true,
    }
}

/// A filtered batch being put together.
#[derive(Debug)]
pub(crate) struct BatchFilter {
    level: WatchLevel,
    out: Vec<u8>,
    first: u64,
    last: u64,
    events: usize,
}

impl BatchFilter {
    pub(crate) fn new(level: WatchLevel) -> Self {
        Self { level, out: Vec::new(), first: 0, last: 0, events: 0 }
    }

    /// Adds the wanted events of an encoded batch.
    pub(crate) fn add(&mut self, first: u64, last: u64, batch: &[u8]) {
        if self.first == 0 {
            self.first = first;
        }
        self.last = last;
        for event in decode::events(batch) {
            if wanted(self.level, decode::kind_field(event)) {
                encode::encoded(&mut self.out, event);
                self.events += 1;
            }
        }
    }

    /// Whether enough has come together to be sent.
    pub(crate) fn full(&self) -> bool {
        self.events >= super::BATCH_EVENTS as usize || self.out.len() >= super::BATCH_BYTES
    }

    /// The batch so far, `None` when nothing was wanted.
    pub(crate) fn take(&mut self) -> Option<Bytes> {
        let (first, last) = (std::mem::take(&mut self.first), self.last);
        if std::mem::take(&mut self.events) == 0 {
            return None;
        }
        let mut batch = std::mem::take(&mut self.out);
        encode::varint_field(&mut batch, 1, first);
        encode::varint_field(&mut batch, 2, last);
        Some(Bytes::from(batch))
    }
}
