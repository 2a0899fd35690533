//! The event stream of one kernel.
//!
//! *Invariant:* events leave in the order of the kernel's clock; every chunk promises a tag that no later event of
//! this stream is before.

use counterpoint_event::event::Event;
use counterpoint_sync::backlog::blank;
use counterpoint_sync::coordinator::switch::Port;
use counterpoint_sync::merge::TEXTS;
use counterpoint_sync::stream::{NEAR_CHUNK, Stream};
use counterpoint_sync::tag::Tag;

/// Where chunks go.
pub enum Target<'a> {
    /// To the results of the channel and to the log.
    Stream(Stream<'a>),
    /// Kept as they are: the master's, before the channels start and after they have ended.
    Kept(&'a mut Vec<Event>),
}

/// Collects events into chunks and sends them.
pub struct Emitter<'a> {
    channel: u16,
    coordinator: Port<'a>,
    target: Target<'a>,
    /// Always [`size`](Self::size) events long; those from `count` on are left over from before.
    chunk: Vec<Event>,
    size: usize,
    count: usize,
    /// Events that have room: `size`, or none while events are held back.
    room: usize,
    /// Bytes of texts in the chunk.
    texts: usize,
    /// Events sent.
    gone: u64,
    /// Events that the kernel holds back.
    held: u64,
}

impl<'a> Emitter<'a> {
    /// A stream of a channel that begins.
    pub fn new(channel: u16, coordinator: Port<'a>, target: Target<'a>) -> Self {
        let size = match &target {
            Target::Stream(stream) => stream.chunk_size(coordinator),
            Target::Kept(_) => NEAR_CHUNK,
        };
        let mut chunk = Vec::new();
        chunk.resize_with(size, blank);
        Self { channel, coordinator, target, chunk, size, count: 0, room: size, texts: 0, gone: 0, held: 0 }
    }

    /// Events so far.
    pub(crate) fn count(&self) -> u64 {
        self.gone + self.held + self.count as u64
    }

    /// Counts on from the events of an earlier life.
    pub(crate) fn count_from(&mut self, events: u64) {
        self.gone = events;
    }

    /// The place of the next event, to be written field by field; `None`: the chunk takes no event.
    #[inline(always)]
    pub(crate) fn slot(&mut self) -> Option<&mut Event> {
        if self.count >= self.room {
            return None;
        }
        let slot = self.chunk.get_mut(self.count)?;
        self.count += 1;
        Some(slot)
    }

    /// The last event carries a text; true when the chunk has enough of them.
    pub(crate) fn carries(&mut self, bytes: usize) -> bool {
        self.texts += bytes;
        self.texts > TEXTS
    }

    /// Takes no event while the kernel holds back so many, which count as well; takes events again with `None`.
    pub(crate) fn holds_back(&mut self, held: Option<usize>) {
        (self.room, self.held) = held.map_or((self.size, 0), |held| (0, held as u64));
    }

    /// Events held back.
    pub(crate) fn held_count(&self) -> usize {
        self.held as usize
    }

    /// Does a little of the deferred work; `false` when there is none. `look`: the other kernels may have advanced so
    /// far that there is more.
    pub(crate) fn work(&mut self, look: bool) -> bool {
        match &mut self.target {
            Target::Stream(stream) => stream.work(look, (self.channel, self.coordinator)),
            Target::Kept(_) => false,
        }
    }

    /// No other kernel does anything before this time.
    pub(crate) fn all_reached(&mut self, t: i64) {
        if let Target::Stream(stream) = &mut self.target {
            stream.all_reached(t);
        }
    }

    /// Sends the events so far. `upto`: no later event is before this tag.
    #[inline(never)]
    pub fn flush(&mut self, upto: Tag) {
        let (count, texts) = (std::mem::take(&mut self.count), std::mem::take(&mut self.texts));
        self.gone += count as u64;
        match &mut self.target {
            Target::Stream(stream) => stream.send(&mut self.chunk, (count, texts), upto, self.coordinator),
            Target::Kept(kept) => {
                self.chunk.truncate(count);
                kept.append(&mut self.chunk);
            }
        }
        self.chunk.resize_with(self.size, blank);
    }
}
