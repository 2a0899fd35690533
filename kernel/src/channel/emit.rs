//! The event stream of one kernel.
//!
//! Invariant: events leave in the order of the kernel's clock; every chunk promises a tag that no later event of
//! this stream is before.

use crate::job::Sink;
use crate::log::event::Event;
use crate::multi::coordinator::Coordinator;
use crate::multi::merge::{CHUNK, Feeder, Merger, Message};
use crate::multi::tag::Tag;

/// Events in a chunk that goes straight to the sink: small enough to stay in the cache of the core that made them.
const DIRECT_CHUNK: usize = 64;

/// Where chunks go.
pub(crate) enum Target<'a> {
    /// To the merger on its own thread.
    Queue(Feeder),
    /// To the sink on this thread: the only kernel of a job needs no merging.
    Direct {
        /// Counts and limits the log.
        merger: &'a mut Merger,
        /// Receives it.
        sink: &'a mut dyn Sink,
    },
}

/// Collects events into chunks and hands them on.
pub(crate) struct Emitter<'a> {
    rank: u16,
    coordinator: &'a Coordinator,
    target: Target<'a>,
    size: usize,
    chunk: Vec<Event>,
}

impl<'a> Emitter<'a> {
    pub(crate) fn new(rank: u16, coordinator: &'a Coordinator, mut target: Target<'a>) -> Self {
        let (size, chunk) = match &mut target {
            Target::Queue(feeder) => (CHUNK, feeder.try_empty().unwrap_or_default()),
            Target::Direct { .. } => (DIRECT_CHUNK, Vec::with_capacity(DIRECT_CHUNK)),
        };
        Self { rank, coordinator, target, size, chunk }
    }

    /// Adds an event; a full chunk goes out first.
    #[inline(always)]
    pub(crate) fn push(&mut self, event: Event) {
        if self.chunk.len() >= self.size {
            let upto = Tag { t: event.t_ns, micro: event.micro, rank: self.rank };
            self.flush(upto);
        }
        self.chunk.push(event);
    }

    /// Sends what there is. `upto`: no later event is before this tag.
    pub(crate) fn flush(&mut self, upto: Tag) {
        match &mut self.target {
            Target::Direct { merger, sink } => {
                if !merger.pass(self.rank, &self.chunk, *sink) {
                    self.coordinator.abort();
                }
                self.chunk.clear();
            }
            Target::Queue(feeder) => {
                let next = feeder.try_empty();
                let empty = next.is_none();
                let events = std::mem::replace(&mut self.chunk, next.unwrap_or_default());
                let _ = feeder.messages.send(Message::Chunk { rank: self.rank, events, upto });
                if empty {
                    self.chunk = self.coordinator.wait_credit(upto, || feeder.wait_empty());
                }
            }
        }
    }
}
