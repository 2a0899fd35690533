//! The path of a kernel's events: into the results of its channel, and into the log if one is requested.
//!
//! *Invariant:* the log is the merge of the chunks that results are made of; whether there is a log changes no result.

use crate::backlog::Backlog;
use crate::coordinator::switch::Port;
use crate::merge::{CHUNK, Feeder, Merger};
use crate::sink::LogSink;
use crate::tag::Tag;
use counterpoint_event::event::Event;

/// Events in a chunk that stays on this thread: small enough for the cache of the core that made them.
pub const NEAR_CHUNK: usize = 64;
/// Events in such a chunk when there are other kernels: little work for the short time while this one waits.
const SHORT_CHUNK: usize = 16;

/// A kernel's end of the log.
enum LogRoute<'a> {
    /// The merger puts the events of all kernels in order.
    Merged(Feeder),
    /// The only kernel of a job needs no merging.
    Only {
        /// Numbers the events.
        merger: &'a mut Merger,
        /// Receives them.
        sink: &'a mut dyn LogSink,
    },
}

/// The path of a kernel's events.
pub struct EventStream<'a> {
    backlog: &'a mut Backlog,
    log: Option<LogRoute<'a>>,
}

impl<'a> EventStream<'a> {
    /// From a kernel to the results of its channel, and to the merger if there is one.
    pub fn new(backlog: &'a mut Backlog, feeder: Option<Feeder>) -> Self {
        Self { backlog, log: feeder.map(LogRoute::Merged) }
    }

    /// From the only kernel of a job to the results of its channel, and straight to the sink.
    pub fn only(backlog: &'a mut Backlog, merger: &'a mut Merger, sink: &'a mut dyn LogSink) -> Self {
        Self { backlog, log: Some(LogRoute::Only { merger, sink }) }
    }

    /// Events of a full chunk.
    pub fn chunk_size(&self, coordinator: Port<'_>) -> usize {
        match self.log {
            Some(LogRoute::Merged(_)) => CHUNK,
            None if !coordinator.is_single() => SHORT_CHUNK,
            Some(LogRoute::Only { .. }) | None => NEAR_CHUNK,
        }
    }

    /// Sends the first `count` events of a chunk, with this many bytes of texts; no later event is before `upto`. The
    /// chunk may be replaced by another one of any length, whose events are overwritten.
    pub fn send(&mut self, chunk: &mut Vec<Event>, (count, texts): (usize, usize), upto: Tag, coordinator: Port<'_>) {
        let events = chunk.get(..count).unwrap_or_default();
        if let Some(LogRoute::Only { merger, sink }) = &mut self.log
            && !merger.pass(events, *sink)
        {
            coordinator.abort();
        }
        let floor = || coordinator.floor(upto.channel);
        let taken = self.backlog.pass(events, floor);
        let merged = matches!(self.log, Some(LogRoute::Merged(_)));
        if taken && !merged {
            return;
        }
        let shared = self.backlog.share(chunk, count);
        if let Some(LogRoute::Merged(feeder)) = &mut self.log {
            feeder.send(shared.clone(), upto);
        }
        if !taken {
            self.backlog.put(shared, texts);
        }
        match &mut self.log {
            Some(LogRoute::Merged(feeder)) => {
                while let Some(chunk) = feeder.try_back() {
                    self.backlog.return_chunk(chunk);
                }
                if feeder.is_full() {
                    let chunk = coordinator.wait_chunk(upto, feeder);
                    self.backlog.return_chunk(chunk);
                }
                // Chunks that the merger returns are before the floor, so no more chunks wait than may be on the way to
                // it.
                self.backlog.take_all(floor());
            }
            Some(LogRoute::Only { .. }) | None => {
                if self.backlog.take_most(floor) {
                    coordinator.catch_up(upto);
                }
            }
        }
    }

    /// Does a little of the deferred work; `false` when there is none. `look`: the other kernels may have advanced so
    /// far that there is more.
    pub fn work(&mut self, look: bool, (channel, coordinator): (u16, Port<'_>)) -> bool {
        if look {
            self.backlog.look(coordinator.floor(channel));
        }
        self.backlog.work()
    }

    /// No other kernel does anything before this time.
    pub fn all_reached(&mut self, t: i64) {
        self.backlog.look(t);
    }
}
