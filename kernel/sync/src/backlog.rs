//! The events of a kernel that wait to be taken into the results of its channel, on the kernel's own thread.
//!
//! An event is taken when no other kernel can still stop the job before it. *Invariant:* nothing after the stop of the
//! job is taken, however far the kernel ran ahead.

use std::collections::VecDeque;

use crate::tag::Tag;
use counterpoint_event::event::Event;
use counterpoint_results::channel_results::ChannelResults;

/// Chunks that may wait for other kernels; beyond that the kernel lets them catch up.
const MOST: usize = 1024;
/// Chunks after which a kernel looks how far the others are: looking slows them down.
const LOOK_EVERY: usize = 8;
/// Chunks that wait for a moment when the kernel has nothing better to do.
const PUT_OFF: usize = 16;

/// Chunks that wait, and the results that they will be taken into.
pub struct Backlog {
    /// Number of the channel.
    pub channel: u16,
    results: ChannelResults,
    /// Chunks, each with its bytes.
    waiting: VecDeque<(Vec<Event>, u64)>,
    /// Bytes that may wait.
    room: u64,
    /// Bytes that wait.
    bytes: u64,
    spare: Vec<Vec<Event>>,
    /// No other kernel stops the job before this time.
    floor: i64,
    /// Events that went in.
    pub events: u64,
    /// Time and microstep of the last one.
    pub last: (i64, u32),
}

impl Backlog {
    /// `room`: bytes that may wait for other kernels.
    pub fn new(channel: u16, results: ChannelResults, room: u64) -> Self {
        let (waiting, spare) = (VecDeque::new(), Vec::new());
        Self { channel, results, waiting, room, bytes: 0, spare, floor: 0, events: 0, last: (0, 0) }
    }

    /// Takes events in at once if nobody else runs, nor ever will; `false` otherwise: [`put`](Self::put) them.
    /// `floor` tells the time before which no other kernel can stop the job.
    pub fn pass(&mut self, events: &[Event], floor: impl Fn() -> i64) -> bool {
        if self.floor == 0 {
            self.floor = floor();
        }
        if self.floor < i64::MAX {
            return false;
        }
        while self.work() {}
        self.keep(events);
        true
    }

    /// Takes a chunk with so many bytes of texts to be worked on later, and gives another one for it, whatever is in it.
    /// Returns `true` when too much is waiting for other kernels.
    pub fn put(&mut self, chunk: &mut Vec<Event>, texts: usize, floor: impl Fn() -> i64) -> bool {
        if chunk.is_empty() {
            return false;
        }
        let next = self.spare.pop().unwrap_or_default();
        let bytes = (chunk.len() * size_of::<Event>() + texts) as u64;
        self.bytes += bytes;
        self.waiting.push_back((std::mem::replace(chunk, next), bytes));
        while self.waiting.len() > PUT_OFF {
            if self.work() {
                continue;
            }
            if !self.waiting.len().is_multiple_of(LOOK_EVERY) {
                break;
            }
            self.look(floor());
            if !self.work() {
                break;
            }
        }
        self.waiting.len() >= MOST || self.bytes >= self.room
    }

    /// No other kernel can stop the job before this time.
    pub fn look(&mut self, floor: i64) {
        self.floor = self.floor.max(floor);
    }

    /// Takes one chunk in that waits, if it may; `false` if there is none.
    pub fn work(&mut self) -> bool {
        let may = |(events, _): &(Vec<Event>, u64)| events.last().map_or(0, |event| event.t_ns) < self.floor;
        if !self.waiting.front().is_some_and(may) {
            return false;
        }
        let Some((front, bytes)) = self.waiting.pop_front() else { return false };
        self.bytes -= bytes;
        self.keep(&front);
        self.spare.push(front);
        true
    }

    /// The job has ended: takes the rest, up to its stop. Gives the results back.
    pub fn close(mut self, stop: Tag) -> (ChannelResults, u64, (i64, u32)) {
        while let Some((events, _)) = self.waiting.pop_front() {
            let after = |e: &Event| Tag { t: e.t_ns, micro: e.micro, channel: self.channel } > stop;
            let end = events.iter().position(after).unwrap_or(events.len());
            self.keep(events.get(..end).unwrap_or_default());
        }
        (self.results, self.events, self.last)
    }

    fn keep(&mut self, events: &[Event]) {
        if let Some(last) = events.last() {
            self.last = (last.t_ns, last.micro);
            self.events += events.len() as u64;
            self.results.take(events);
        }
    }
}
