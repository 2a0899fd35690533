//! The event stream of one kernel.
//!
//! Invariant: events leave in the order of the kernel's clock; every chunk promises a tag that no later event of
//! this stream is before.

use crate::job::Sink;
use crate::log::event::Event;
use crate::multi::coordinator::Coordinator;
use crate::multi::feed::Feed;
use crate::multi::merge::{CHUNK, Feeder, Merger, Message};
use crate::multi::tag::Tag;

/// Events in a chunk that stays on this thread: small enough for the cache of the core that made them.
const NEAR_CHUNK: usize = 64;

/// Where chunks go.
pub(crate) enum Target<'a> {
    /// To the merger on its own thread.
    Queue(Feeder),
    /// To the sink on this thread: the only kernel of a job needs no merging.
    Direct {
        /// Numbers the log.
        merger: &'a mut Merger,
        /// Receives it.
        sink: &'a mut dyn Sink,
    },
    /// Kept as they are: the master's, before the channels start and after they have ended.
    Kept(&'a mut Vec<Event>),
    /// Into the results of this channel.
    Lane(&'a mut Feed),
}

/// Collects events into chunks and hands them on.
pub(crate) struct Emitter<'a> {
    rank: u16,
    coordinator: &'a Coordinator,
    target: Target<'a>,
    size: usize,
    chunk: Vec<Event>,
    /// Events handed on.
    gone: u64,
}

impl<'a> Emitter<'a> {
    pub(crate) fn new(rank: u16, coordinator: &'a Coordinator, mut target: Target<'a>) -> Self {
        let (size, chunk) = match &mut target {
            Target::Queue(feeder) => (CHUNK, feeder.try_empty().unwrap_or_default()),
            Target::Direct { .. } | Target::Lane(_) | Target::Kept(_) => (NEAR_CHUNK, Vec::with_capacity(NEAR_CHUNK)),
        };
        Self { rank, coordinator, target, size, chunk, gone: 0 }
    }

    /// Events so far.
    pub(crate) fn count(&self) -> u64 {
        self.gone + self.chunk.len() as u64
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
    #[inline(never)]
    pub(crate) fn flush(&mut self, upto: Tag) {
        self.gone += self.chunk.len() as u64;
        match &mut self.target {
            Target::Direct { merger, sink } => {
                if !merger.pass(self.rank, &self.chunk, *sink) {
                    self.coordinator.abort();
                }
                self.chunk.clear();
            }
            Target::Kept(events) => events.append(&mut self.chunk),
            Target::Lane(feed) => {
                if feed.pass(&mut self.chunk, || self.coordinator.floor(upto.rank)) {
                    self.coordinator.catch_up(upto);
                }
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
