//! The event stream of one kernel.
//!
//! Invariant: events leave in the order of the kernel's clock; every chunk promises a tag that no later event of
//! this stream is before.

use crate::log::event::Event;
use crate::multi::coordinator::Coordinator;
use crate::multi::merge::{CHUNK, Feeder, Message};
use crate::multi::tag::Tag;

/// Collects events into chunks and hands them to the merger.
pub(crate) struct Emitter<'a> {
    rank: u16,
    coordinator: &'a Coordinator,
    feeder: Feeder,
    chunk: Vec<Event>,
}

impl<'a> Emitter<'a> {
    pub(crate) fn new(rank: u16, coordinator: &'a Coordinator, mut feeder: Feeder) -> Self {
        let chunk = feeder.try_empty().unwrap_or_default();
        Self { rank, coordinator, feeder, chunk }
    }

    /// Adds an event; a full chunk goes out first.
    pub(crate) fn push(&mut self, event: Event) {
        if self.chunk.len() >= CHUNK {
            let upto = Tag { t: event.t_ns, micro: event.micro, rank: self.rank };
            self.flush(upto);
        }
        self.chunk.push(event);
    }

    /// Sends what there is. `upto`: no later event is before this tag.
    pub(crate) fn flush(&mut self, upto: Tag) {
        let next = self.feeder.try_empty();
        let empty = next.is_none();
        let events = std::mem::replace(&mut self.chunk, next.unwrap_or_default());
        let _ = self.feeder.messages.send(Message::Chunk { rank: self.rank, events, upto });
        if empty {
            let (coordinator, feeder) = (self.coordinator, &mut self.feeder);
            self.chunk = coordinator.wait_credit(upto, || feeder.wait_empty());
        }
    }
}
