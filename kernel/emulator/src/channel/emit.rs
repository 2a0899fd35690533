//! The event stream of one kernel.
//!
//! Invariant: events leave in the order of the kernel's clock; every chunk promises a tag that no later event of
//! this stream is before.

use counterpoint_event::event::{Dwell, Event, Kind};
use counterpoint_sync::backlog::Backlog;
use counterpoint_sync::coordinator::switch::Port;
use counterpoint_sync::merge::{CHUNK, Feeder, Merger, Message, TEXTS};
use counterpoint_sync::sink::Sink;
use counterpoint_sync::tag::Tag;

/// Events in a chunk that stays on this thread: small enough for the cache of the core that made them.
const NEAR_CHUNK: usize = 64;
/// Events in such a chunk when there are other kernels: little work for the short time while this one waits.
const SHORT_CHUNK: usize = 16;

/// Events in a chunk of those that are held back: a block or two.
const HELD_CHUNK: usize = 8;

/// Where chunks go.
pub enum Target<'a> {
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
    Results(&'a mut Backlog),
    /// Held back until a move before them is known.
    Held(Box<Held<'a>>),
}

/// Events that are held back, and the emitter that they will go to.
pub struct Held<'a> {
    events: Vec<Event>,
    /// None only while it is being made.
    real: Option<Emitter<'a>>,
    /// Nothing that comes out later is before this.
    since: Tag,
}

/// Collects events into chunks and hands them on.
pub struct Emitter<'a> {
    channel: u16,
    coordinator: Port<'a>,
    target: Target<'a>,
    /// Always [`size`](Self::size) events long; those from `count` on are left over from before.
    chunk: Vec<Event>,
    size: usize,
    count: usize,
    /// Bytes of texts in the chunk.
    texts: usize,
    /// Events handed on.
    gone: u64,
}

/// An event to be overwritten.
fn blank() -> Event {
    Event { t_ns: 0, micro: 0, dur_ns: 0, channel: 0, file: 0, line: 0, kind: Kind::Dwell(Dwell) }
}

impl<'a> Emitter<'a> {
    /// A stream of a channel that begins.
    pub fn new(channel: u16, coordinator: Port<'a>, mut target: Target<'a>) -> Self {
        let (size, mut chunk) = match &mut target {
            Target::Queue(feeder) => (CHUNK, feeder.try_empty().unwrap_or_default()),
            Target::Results(_) if !coordinator.is_single() => (SHORT_CHUNK, Vec::new()),
            Target::Direct { .. } | Target::Results(_) | Target::Kept(_) | Target::Held(_) => (NEAR_CHUNK, Vec::new()),
        };
        chunk.resize_with(size, blank);
        Self { channel, coordinator, target, chunk, size, count: 0, texts: 0, gone: 0 }
    }

    /// Events so far.
    pub(crate) fn count(&self) -> u64 {
        self.gone + self.count as u64
    }

    /// Counts on from the events of an earlier life.
    pub(crate) fn go_on_from(&mut self, events: u64) {
        self.gone = events;
    }

    /// Adds an event; a full chunk goes out first.
    pub(crate) fn push(&mut self, event: Event) {
        if let Some(slot) = self.slot(event.t_ns, event.micro) {
            *slot = event;
        }
    }

    /// The place of the next event, to be written field by field (never `None`). The event is at this tag.
    #[inline(always)]
    pub(crate) fn slot(&mut self, t: i64, micro: u32) -> Option<&mut Event> {
        if self.count >= self.size {
            self.flush(Tag { t, micro, channel: self.channel });
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

    /// Holds events back from here on.
    pub(crate) fn hold(&mut self, since: Tag) {
        let target = Target::Held(Box::new(Held { events: Vec::new(), real: None, since }));
        let mut chunk = Vec::new();
        chunk.resize_with(HELD_CHUNK, blank);
        let (channel, coordinator, gone) = (self.channel, self.coordinator, self.count());
        let held = Self { channel, coordinator, target, chunk, size: HELD_CHUNK, count: 0, texts: 0, gone };
        let real = std::mem::replace(self, held);
        if let Target::Held(held) = &mut self.target {
            held.real = Some(real);
        }
    }

    /// Events held back so far.
    pub(crate) fn held(&self) -> usize {
        if let Target::Held(held) = &self.target { held.events.len() + self.count } else { 0 }
    }

    /// Events are held back, and the clock has gone on since.
    pub(crate) fn is_late(&self, t: i64) -> bool {
        matches!(&self.target, Target::Held(held) if held.since.t < t)
    }

    /// Ends holding back; whoever calls puts the events where they belong.
    pub(crate) fn release(&mut self) -> Vec<Event> {
        if let Target::Held(held) = &mut self.target
            && let Some(real) = held.real.take()
        {
            let mut events = std::mem::take(&mut held.events);
            self.chunk.truncate(self.count);
            events.append(&mut self.chunk);
            *self = real;
            return events;
        }
        Vec::new()
    }

    /// Does a little of the work that was put off; `false` when there is none. `look`: the others may have come so far
    /// that there is more.
    pub(crate) fn work(&mut self, look: bool) -> bool {
        match &mut self.target {
            Target::Results(backlog) => {
                if look {
                    backlog.look(self.coordinator.floor(self.channel));
                }
                backlog.work()
            }
            Target::Queue(_) | Target::Direct { .. } | Target::Kept(_) | Target::Held(_) => false,
        }
    }

    /// No other kernel does anything before this time.
    pub(crate) fn all_reached(&mut self, t: i64) {
        if let Target::Results(backlog) = &mut self.target {
            backlog.look(t);
        }
    }

    /// Sends what there is. `upto`: no later event is before this tag.
    #[inline(never)]
    pub fn flush(&mut self, upto: Tag) {
        let count = std::mem::take(&mut self.count);
        let texts = std::mem::take(&mut self.texts);
        self.gone += count as u64;
        let events = self.chunk.get(..count).unwrap_or_default();
        match &mut self.target {
            Target::Direct { merger, sink } => {
                if !merger.pass(self.channel, events, *sink) {
                    self.coordinator.abort();
                }
            }
            Target::Kept(kept) => {
                self.chunk.truncate(count);
                kept.append(&mut self.chunk);
                self.chunk.resize_with(self.size, blank);
            }
            Target::Held(held) => {
                self.chunk.truncate(count);
                held.events.append(&mut self.chunk);
                self.chunk.resize_with(self.size, blank);
                if let Some(real) = &mut held.real {
                    real.flush(held.since);
                }
            }
            Target::Results(backlog) => {
                let floor = || self.coordinator.floor(upto.channel);
                if !backlog.pass(events, floor) {
                    self.chunk.truncate(count);
                    let full = backlog.put(&mut self.chunk, texts, floor);
                    self.chunk.resize_with(self.size, blank);
                    if full {
                        self.coordinator.catch_up(upto);
                    }
                }
            }
            Target::Queue(feeder) => {
                self.chunk.truncate(count);
                let next = feeder.try_empty();
                let empty = next.is_none();
                let events = std::mem::replace(&mut self.chunk, next.unwrap_or_default());
                let _ = feeder.messages.send(Message::Chunk { channel: self.channel, events, upto });
                if empty {
                    self.chunk = self.coordinator.wait_chunk(upto, feeder, Feeder::try_empty, Feeder::wait_empty);
                }
                self.chunk.resize_with(self.size, blank);
            }
        }
    }
}
