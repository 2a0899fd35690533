//! The events of a kernel that wait to be taken into the results of its channel, on the kernel's own thread.
//!
//! An event is taken when no other kernel can still stop the job before it. *Invariant:* nothing after the stop of the
//! job is taken, however far the kernel ran ahead.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::tag::Tag;
use counterpoint_event::event::{Dwell, Event, Kind, SourcePlace};
use counterpoint_results::channel_results::ChannelResults;

/// Events in order. The log may read them while they wait here.
pub type Chunk = Arc<Vec<Event>>;

/// Events that may wait for other kernels; beyond that the kernel lets them catch up.
const MOST: usize = 16 << 10;
/// Events after which a kernel looks how far the others are: looking slows them down.
const LOOK_EVERY: usize = 128;
/// Events that wait for a moment when the kernel has nothing better to do.
const PUT_OFF: usize = 256;
/// A chunk is sparse that fills less than this part of its room.
const SPARSE: usize = 2;
/// Events that are taken at once: little work for the short time while the kernel waits for another one.
const SLICE: usize = 16;
/// Chunks with little room that are kept.
const MOST_SMALL: usize = 64;

/// An event to be overwritten.
pub fn blank() -> Event {
    Event {
        t_ns: 0,
        micro: 0,
        dur_ns: 0,
        channel: 0,
        file: 0,
        line: 0,
        caller: SourcePlace::NONE,
        kind: Kind::Dwell(Dwell),
    }
}

/// Events that wait, and the results that they will be taken into.
pub struct Backlog {
    /// Number of the channel.
    pub channel: u16,
    /// None: no results are requested, the events are only counted.
    results: Option<ChannelResults>,
    /// Chunks, each with its bytes.
    waiting: VecDeque<(Chunk, u64)>,
    /// Events of the first chunk that have been taken.
    taken: usize,
    /// Events that wait.
    count: usize,
    /// Bytes that may wait.
    room: u64,
    /// Bytes that wait.
    bytes: u64,
    /// Chunks that are no longer read.
    spare: Vec<Chunk>,
    /// Empty ones with little room.
    small: Vec<Chunk>,
    /// Events that have come since the last look at the other kernels.
    unlooked: usize,
    /// No other kernel stops the job before this time.
    floor: i64,
    /// Events taken.
    pub events: u64,
    /// Time and microstep of the last event taken.
    pub last: (i64, u32),
}

impl Backlog {
    /// Feeds the results of a channel, if results are requested. `room`: bytes that may wait for other kernels.
    pub fn new(channel: u16, results: Option<ChannelResults>, room: u64) -> Self {
        let (waiting, spare, small) = (VecDeque::new(), Vec::new(), Vec::new());
        Self {
            channel,
            results,
            waiting,
            taken: 0,
            count: 0,
            room,
            bytes: 0,
            spare,
            small,
            unlooked: 0,
            floor: 0,
            events: 0,
            last: (0, 0),
        }
    }

    /// Takes events at once if no other kernel runs, nor ever will; `false` otherwise: [`put`](Self::put) them.
    /// `floor` gives the time before which no other kernel can stop the job.
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

    /// Makes a chunk of the first `count` events that can be shared, and leaves events that may be overwritten, of an
    /// old chunk or blank. A few events get no more room than they need: at a storm of waits many such chunks may wait
    /// for other kernels.
    pub fn share(&mut self, events: &mut Vec<Event>, count: usize) -> Chunk {
        if self.spare.is_empty() && count < events.capacity() / SPARSE {
            let mut chunk = self.small.pop().unwrap_or_default();
            if let Some(few) = Arc::get_mut(&mut chunk) {
                few.reserve_exact(count);
                few.extend(events.iter_mut().take(count).map(|event| std::mem::replace(event, blank())));
            }
            return chunk;
        }
        events.truncate(count);
        let mut chunk = self.spare.pop().unwrap_or_default();
        if let Some(room) = Arc::get_mut(&mut chunk) {
            std::mem::swap(room, events);
        }
        chunk
    }

    /// Takes a chunk back that the log has read. It is used again unless it waits here; one with little room for a few
    /// events.
    pub fn return_chunk(&mut self, mut chunk: Chunk) {
        if chunk.capacity() >= SLICE {
            if Arc::strong_count(&chunk) == 1 {
                self.spare.push(chunk);
            }
        } else if self.small.len() < MOST_SMALL
            && let Some(few) = Arc::get_mut(&mut chunk)
        {
            few.clear();
            self.small.push(chunk);
        }
    }

    /// Puts a chunk with this many bytes of texts off.
    pub fn put(&mut self, chunk: Chunk, texts: usize) {
        if chunk.is_empty() {
            return self.return_chunk(chunk);
        }
        let bytes = (chunk.len() * size_of::<Event>() + texts) as u64;
        self.bytes += bytes;
        self.count += chunk.len();
        self.unlooked += chunk.len();
        self.waiting.push_back((chunk, bytes));
    }

    /// Takes all events that may be taken.
    pub fn take_all(&mut self, floor: i64) {
        self.look(floor);
        while self.work() {}
    }

    /// Takes events while many wait. Returns `true` when too many of them wait for other kernels.
    pub fn take_most(&mut self, floor: impl Fn() -> i64) -> bool {
        while self.count > PUT_OFF {
            if self.work() {
                continue;
            }
            if self.unlooked < LOOK_EVERY {
                break;
            }
            self.look(floor());
            if !self.work() {
                break;
            }
        }
        self.count >= MOST || self.bytes >= self.room
    }

    /// No other kernel can stop the job before this time.
    pub fn look(&mut self, floor: i64) {
        self.unlooked = 0;
        self.floor = self.floor.max(floor);
    }

    /// Takes a few of the events that wait, if they may be taken; `false` if there are none.
    pub fn work(&mut self) -> bool {
        let floor = self.floor;
        let from = self.taken;
        let few = |chunk: &Chunk| (from + SLICE).min(chunk.len());
        let may = |(chunk, _): &(Chunk, u64)| {
            few(chunk).checked_sub(1).and_then(|last| chunk.get(last)).is_none_or(|last| last.t_ns < floor)
        };
        if !self.waiting.front().is_some_and(may) {
            return false;
        }
        let Some((chunk, bytes)) = self.waiting.pop_front() else { return false };
        let until = few(&chunk);
        self.keep(chunk.get(from..until).unwrap_or_default());
        self.count -= until - from;
        if until < chunk.len() {
            self.taken = until;
            self.waiting.push_front((chunk, bytes));
        } else {
            self.taken = 0;
            self.bytes -= bytes;
            self.return_chunk(chunk);
        }
        true
    }

    /// The job has ended: takes the rest, up to its stop. Gives the results back.
    pub fn close(mut self, stop: Tag) -> BacklogResults {
        let mut from = self.taken;
        for (chunk, _) in std::mem::take(&mut self.waiting) {
            let rest = chunk.get(std::mem::take(&mut from)..).unwrap_or_default();
            let after = |e: &Event| Tag { t: e.t_ns, micro: e.micro, channel: self.channel } > stop;
            let end = rest.iter().position(after).unwrap_or(rest.len());
            self.keep(rest.get(..end).unwrap_or_default());
        }
        BacklogResults { results: self.results, events: self.events, last: self.last }
    }

    fn keep(&mut self, events: &[Event]) {
        if let Some(last) = events.last() {
            self.last = (last.t_ns, last.micro);
            self.events += events.len() as u64;
            if let Some(results) = &mut self.results {
                results.take(events);
            }
        }
    }
}

/// The results of the events of a channel.
pub struct BacklogResults {
    /// Its results, if results are requested.
    pub results: Option<ChannelResults>,
    /// Events up to the stop of the job.
    pub events: u64,
    /// Time and microstep of the last event.
    pub last: (i64, u32),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(times: std::ops::Range<i64>) -> Vec<Event> {
        let event = |t_ns| Event {
            t_ns,
            micro: 0,
            dur_ns: 0,
            channel: 1,
            file: 0,
            line: 0,
            caller: SourcePlace::NONE,
            kind: Kind::Dwell(Dwell),
        };
        times.map(event).collect()
    }

    #[test]
    fn nothing_is_taken_that_another_kernel_can_still_cut_off() {
        let mut backlog = Backlog::new(1, None, u64::MAX);
        let chunk = backlog.share(&mut events(1..101), 100);
        backlog.put(chunk, 0);
        backlog.take_all(40);
        // Whole slices before the floor.
        assert_eq!((backlog.events, backlog.last), (32, (32, 0)));
        assert!(!backlog.take_most(|| 60));
        let closed = backlog.close(Tag { t: 70, micro: 0, channel: 1 });
        assert_eq!((closed.events, closed.last), (70, (70, 0)));
    }

    #[test]
    fn a_chunk_is_used_again_when_neither_the_log_nor_the_results_need_it() {
        let mut backlog = Backlog::new(1, None, u64::MAX);
        let chunk = backlog.share(&mut events(1..21), 20);
        let log = chunk.clone();
        backlog.put(chunk, 0);
        backlog.return_chunk(log);
        assert!(backlog.spare.is_empty());
        backlog.take_all(100);
        assert_eq!(backlog.spare.len(), 1);
    }

    #[test]
    fn a_few_events_take_no_more_room_than_they_need() {
        let mut backlog = Backlog::new(1, None, u64::MAX);
        let mut full = Vec::with_capacity(512);
        full.extend(events(1..513));
        let chunk = backlog.share(&mut full, 3);
        assert_eq!((chunk.len(), chunk.capacity(), full.len(), full.capacity()), (3, 3, 512, 512));
        assert_eq!((chunk[2].t_ns, full[2].t_ns, full[3].t_ns), (3, 0, 4));
        // A chunk with little room keeps only a few events.
        backlog.return_chunk(chunk);
        assert!(backlog.spare.is_empty());
        let chunk = backlog.share(&mut full, 2);
        assert_eq!((chunk.len(), chunk.capacity(), backlog.small.len()), (2, 3, 0));
    }
}
