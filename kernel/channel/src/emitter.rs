//! The event stream of one kernel, with the events that compensation and untimed moves hold back.
//!
//! *Invariant:* events are sent in the order of the kernel's clock; every chunk promises a tag that no later event of
//! this stream precedes.

mod moves;

use counterpoint_event::event::{Event, Kind};
use counterpoint_sync::backlog::blank;
use counterpoint_sync::coordinator::switch::Port;
use counterpoint_sync::merge::TEXTS;
use counterpoint_sync::stream::{EventStream, NEAR_CHUNK};
use counterpoint_sync::tag::Tag;

use super::at::ExecutionPoint;
use super::pace::FeedPlanner;

/// The destination of chunks.
pub enum ChunkTarget<'a> {
    /// To the results of the channel and to the log.
    Stream(EventStream<'a>),
    /// Kept unchanged: events of the master before the channels start and after they have ended.
    Kept(&'a mut Vec<Event>),
}

/// Events that are held back until the move before them is known.
struct HeldEvents {
    events: Vec<Event>,
    /// The tag that no later event precedes.
    since: Tag,
}

/// Collects events into chunks and sends them.
pub struct Emitter<'a> {
    channel: u16,
    coordinator: Port<'a>,
    target: ChunkTarget<'a>,
    /// Always [`size`](Self::size) events long; the events from `count` on are old.
    chunk: Vec<Event>,
    size: usize,
    count: usize,
    /// Capacity for events: `size`, or 0 while events are held back.
    room: usize,
    /// Bytes of texts in the chunk.
    texts: usize,
    /// Events sent.
    gone: u64,
    /// Events that the kernel holds back.
    held: u64,
    /// The effects that compensation holds back.
    buffer: Option<HeldEvents>,
    /// Moves at feed whose times depend on later moves; `None` if speeds change instantly.
    pace: Option<Box<FeedPlanner>>,
}

impl<'a> Emitter<'a> {
    /// The stream of a channel that starts.
    pub fn new(channel: u16, coordinator: Port<'a>, target: ChunkTarget<'a>) -> Self {
        let size = match &target {
            ChunkTarget::Stream(stream) => stream.chunk_size(coordinator),
            ChunkTarget::Kept(_) => NEAR_CHUNK,
        };
        let mut chunk = Vec::new();
        chunk.resize_with(size, blank);
        let (count, room, texts, gone, held, buffer, pace) = (0, size, 0, 0, 0, None, None);
        Self { channel, coordinator, target, chunk, size, count, room, texts, gone, held, buffer, pace }
    }

    /// Adds the look-ahead for moves at feed.
    pub fn paced(self, pace: Option<Box<FeedPlanner>>) -> Self {
        Self { pace, ..self }
    }

    /// Adds an event of this block at the current time.
    #[inline]
    pub fn emit(&mut self, at: &ExecutionPoint, dur_ns: i64, kind: Kind) {
        let bytes = kind.text_bytes();
        self.emit_as(at, dur_ns, |slot| *slot = kind);
        self.carries(at, bytes);
    }

    /// Adds an event whose kind is written in place.
    #[inline(always)]
    pub fn emit_as(&mut self, at: &ExecutionPoint, dur_ns: i64, write: impl FnOnce(&mut Kind)) {
        let ExecutionPoint { channel, clock, micro, file, line, caller, .. } = *at;
        let slot = match self.slot() {
            Some(event) => Some(event),
            None => self.other_slot(Tag { t: clock, micro, channel }),
        };
        if let Some(event) = slot {
            (event.t_ns, event.micro, event.dur_ns) = (clock, micro, dur_ns);
            (event.channel, event.file, event.line, event.caller) = (channel, file, line, caller);
            write(&mut event.kind);
        }
    }

    /// Adds a complete event.
    pub fn push(&mut self, event: Event) {
        let slot = match self.slot() {
            Some(slot) => Some(slot),
            None => self.other_slot(Tag { t: event.t_ns, micro: event.micro, channel: self.channel }),
        };
        if let Some(slot) = slot {
            *slot = event;
        }
    }

    /// The place of an event at this tag if the chunk is full: among the events held back, or in the next chunk.
    #[cold]
    #[inline(never)]
    fn other_slot(&mut self, tag: Tag) -> Option<&mut Event> {
        if self.buffer.is_none() && self.has_moves() {
            return self.slot_after_moves();
        }
        if self.buffer.is_none() {
            self.flush(tag);
            return self.slot();
        }
        self.held += 1;
        self.room = 0;
        let buffer = self.buffer.as_mut()?;
        buffer.events.push(blank());
        buffer.events.last_mut()
    }

    /// Holds events back from this tag on, until the move before them is known.
    pub fn hold(&mut self, since: Tag) {
        if self.buffer.is_none() {
            self.buffer = Some(HeldEvents { events: Vec::new(), since });
            self.hold_back();
        }
    }

    /// Events that wait for the move before them.
    pub fn buffered(&self) -> usize {
        self.buffer.as_ref().map_or(0, |buffer| buffer.events.len())
    }

    /// Stops holding events back, and returns them for the caller to place.
    pub fn release(&mut self) -> Vec<Event> {
        let events = self.buffer.take().map(|buffer| buffer.events).unwrap_or_default();
        self.hold_back();
        events
    }

    /// Tag from which events wait for the move before them.
    pub fn held_since(&self) -> Option<Tag> {
        self.buffer.as_ref().map(|buffer| buffer.since)
    }

    /// The time before which this channel has no further shared operation, ns.
    #[inline(always)]
    pub fn bound(&self, at: &ExecutionPoint) -> i64 {
        let since = self.buffer.as_ref().map_or(at.clock, |buffer| buffer.since.t);
        match &self.pace {
            None => since,
            Some(pace) => pace.first().map_or(since + pace.late, |(t, _)| t),
        }
    }

    /// The tag that no event sent later precedes.
    pub fn promise(&self, at: &ExecutionPoint) -> Tag {
        let tag = self.held_since().unwrap_or_else(|| at.tag());
        match self.pace.as_deref() {
            None => tag,
            Some(pace) => match pace.first() {
                Some((t, micro)) => Tag { t, micro, ..tag },
                None => Tag { t: tag.t + pace.late, ..tag },
            },
        }
    }

    /// Number of events so far.
    pub fn count(&self) -> u64 {
        self.gone + self.held + self.count as u64
    }

    /// Continues the count of an earlier life.
    pub fn count_from(&mut self, events: u64) {
        self.gone = events;
    }

    /// The place of the next event, to be written field by field; `None`: the chunk takes no event.
    #[inline(always)]
    fn slot(&mut self) -> Option<&mut Event> {
        if self.count >= self.room {
            return None;
        }
        let slot = self.chunk.get_mut(self.count)?;
        self.count += 1;
        Some(slot)
    }

    /// Counts the text of the last event; sends the events when the chunk has enough text.
    #[inline]
    pub fn carries(&mut self, at: &ExecutionPoint, bytes: usize) {
        self.texts += bytes;
        if bytes > 0 && self.texts > TEXTS {
            self.flush(self.promise(at));
        }
    }

    /// Accepts no event while this many are held back, and counts those; `None` accepts events again.
    fn holds_back(&mut self, held: Option<usize>) {
        (self.room, self.held) = held.map_or((self.size, 0), |held| (0, held as u64));
    }

    /// Does part of the deferred work; returns `false` if there is none. `look`: the progress of the other kernels may
    /// have added work.
    pub fn work(&mut self, look: bool) -> bool {
        match &mut self.target {
            ChunkTarget::Stream(stream) => stream.work(look, (self.channel, self.coordinator)),
            ChunkTarget::Kept(_) => false,
        }
    }

    /// Records that no other kernel acts before this time, ns.
    pub fn all_reached(&mut self, t: i64) {
        if let ChunkTarget::Stream(stream) = &mut self.target {
            stream.all_reached(t);
        }
    }

    /// Sends the collected events. `upto`: the tag that no later event precedes.
    #[inline(never)]
    pub fn flush(&mut self, upto: Tag) {
        let (count, texts) = (std::mem::take(&mut self.count), std::mem::take(&mut self.texts));
        self.gone += count as u64;
        match &mut self.target {
            ChunkTarget::Stream(stream) => stream.send(&mut self.chunk, (count, texts), upto, self.coordinator),
            ChunkTarget::Kept(kept) => {
                self.chunk.truncate(count);
                kept.append(&mut self.chunk);
            }
        }
        self.chunk.resize_with(self.size, blank);
    }
}
