//! From the kernels' own event streams to the one ordered log.
//!
//! Each kernel sends chunks in its own order with a promise `upto`: nothing earlier will follow. An event goes out
//! when no other stream can still produce an earlier one. Invariant: messages about a stream's state are sent under
//! the coordinator's lock, so a release is in the queue before anything that the released partner's releaser does
//! later. A kernel may have only `CREDIT` chunks on the way, each with `TEXTS`
//! bytes of text; beyond that it waits for one to come back. If the log waits for events that a sleeping kernel keeps
//! back, the kernels that it waits for get further chunks in advance, or no kernel would ever continue.

use std::collections::VecDeque;

use crossbeam_channel::{Receiver, Sender, bounded, unbounded};

use crate::backlog::Chunk;
use crate::sink::LogSink;
use crate::tag::Tag;
use counterpoint_event::event::Event;

/// Events in a full chunk.
pub const CHUNK: usize = 512;
/// Chunks a kernel may have on the way, less when the memory of the job has no room for them.
const CREDIT: usize = 8;
/// Bytes of texts after which a chunk goes out though it is not full.
pub const TEXTS: usize = 32 << 10;

/// Messages of the kernels to the merger.
pub enum MergerMessage {
    /// Events of a stream, and the promise that later ones are not before `upto`.
    Chunk {
        /// Stream.
        channel: u16,
        /// Events in order.
        events: Chunk,
        /// Promise.
        upto: Tag,
    },
    /// The stream produces nothing until it is resumed.
    Blocked(u16),
    /// The stream continues, not before the tag.
    Resumed(u16, Tag),
    /// The kernel of the stream sleeps until others have advanced, and keeps events back: a move whose time is not known.
    Asleep(u16),
    /// It sleeps no longer.
    Awake(u16),
    /// The kernel of the stream has taken a chunk in advance.
    Advanced(u16),
    /// The stream is complete.
    Done(u16),
    /// Nothing after this tag belongs to the log.
    StopAt(Tag),
}

/// A kernel's end of the merger.
pub struct Feeder {
    /// Number of the channel.
    pub channel: u16,
    messages: Sender<MergerMessage>,
    back: Receiver<Chunk>,
    /// Chunks on the way.
    sent: usize,
    /// Chunks that may be on the way.
    credit: usize,
}

impl Feeder {
    /// Sends events; no later event is before `upto`.
    pub fn send(&mut self, events: Chunk, upto: Tag) {
        self.sent += 1;
        let _ = self.messages.send(MergerMessage::Chunk { channel: self.channel, events, upto });
    }

    /// As many chunks are on the way as may be: the kernel waits for one to come back.
    pub fn is_full(&self) -> bool {
        self.sent >= self.credit
    }

    /// Tells when chunks have come back.
    #[must_use]
    pub fn returned(&self) -> Returned {
        Returned(self.back.clone())
    }

    /// A chunk that has come back.
    pub fn try_back(&mut self) -> Option<Chunk> {
        let chunk = self.back.try_recv().ok()?;
        self.sent -= 1;
        Some(chunk)
    }

    /// A chunk in advance of those that come back.
    pub fn advance(&mut self) -> Chunk {
        self.sent -= 1;
        let _ = self.messages.send(MergerMessage::Advanced(self.channel));
        Chunk::default()
    }

    /// Waits for a chunk to come back.
    pub fn wait_back(&mut self) -> Chunk {
        self.sent -= 1;
        self.back.recv().unwrap_or_default()
    }
}

/// Chunks that have come back to a kernel.
pub struct Returned(Receiver<Chunk>);

impl Returned {
    /// Whether there are some.
    #[must_use]
    pub fn any(&self) -> bool {
        !self.0.is_empty()
    }
}

enum StreamState {
    Active(Tag),
    Blocked,
    Done,
}

struct MergeStream {
    channel: u16,
    chunks: VecDeque<(Chunk, usize)>,
    state: StreamState,
    /// Its kernel sleeps and keeps events back.
    asleep: bool,
    /// Chunks of these that its kernel has got back in advance.
    advanced: usize,
    /// Where chunks go that are in the log.
    back: Sender<Chunk>,
}

impl MergeStream {
    fn head(&self) -> Option<Tag> {
        let (events, at) = self.chunks.front()?;
        events.get(*at).map(|e| Tag { t: e.t_ns, micro: e.micro, channel: self.channel })
    }

    /// No event of this stream that is not yet out is before this tag.
    fn floor(&self) -> Tag {
        match (self.head(), &self.state) {
            (Some(head), _) => head,
            (None, StreamState::Active(upto)) => *upto,
            (None, _) => Tag::END,
        }
    }
}

/// The merger: owned by the thread that runs the job.
pub struct Merger {
    streams: Vec<MergeStream>,
    messages: Receiver<MergerMessage>,
    /// Chunks that a kernel may have on the way.
    credit: usize,
    stop: Tag,
    /// Number of the next event.
    pub next_seq: u64,
    /// How the log ended so far.
    end: MergeEnd,
}

/// Why the merger returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MergeEnd {
    /// All streams are complete.
    Complete,
    /// The sink refused events.
    Refused,
}

impl Merger {
    /// A merger for these channels, each with `room` bytes on the way at most, a feeder for each of them, and a sender
    /// for messages about streams.
    pub fn new(channels: impl Iterator<Item = u16>, room: u64) -> (Self, Vec<Feeder>, Sender<MergerMessage>) {
        let chunk = (CHUNK * size_of::<Event>() + TEXTS) as u64;
        let credit = usize::try_from(room / chunk).unwrap_or(CREDIT).clamp(2, CREDIT);
        let (sender, messages) = unbounded();
        let mut streams = Vec::new();
        let mut feeders = Vec::new();
        for channel in channels {
            let (back, returned) = bounded(CREDIT);
            let floor = Tag { t: 0, micro: 0, channel };
            streams.push(MergeStream {
                channel,
                chunks: VecDeque::with_capacity(CREDIT),
                state: StreamState::Active(floor),
                asleep: false,
                advanced: 0,
                back,
            });
            feeders.push(Feeder { channel, messages: sender.clone(), back: returned, sent: 0, credit });
        }
        (Self { streams, messages, credit, stop: Tag::END, next_seq: 1, end: MergeEnd::Complete }, feeders, sender)
    }

    /// Passes events of the only stream on. Returns `false` when the log takes nothing more.
    pub fn pass(&mut self, events: &[Event], sink: &mut dyn LogSink) -> bool {
        if self.end == MergeEnd::Complete {
            self.end = self.send(events, sink);
        }
        self.end == MergeEnd::Complete
    }

    /// How the log ended.
    pub fn end(&self) -> MergeEnd {
        self.end
    }

    /// Hands events that are next in the log to the sink.
    fn send(&mut self, batch: &[Event], sink: &mut dyn LogSink) -> MergeEnd {
        if !batch.is_empty() && !sink.events(self.next_seq, batch) {
            return MergeEnd::Refused;
        }
        self.next_seq += batch.len() as u64;
        MergeEnd::Complete
    }

    /// Receives and merges until all streams are complete. After [`MergeEnd::Refused`] the streams are still drained
    /// (kernels must end), but nothing more goes to the sink.
    pub fn run(&mut self, sink: &mut dyn LogSink, mut on_stop: impl FnMut()) {
        while let Ok(message) = self.messages.recv() {
            self.take(message);
            while let Ok(message) = self.messages.try_recv() {
                self.take(message);
            }
            self.hand_on(sink, &mut on_stop);
            if self.streams.iter().all(|s| matches!(s.state, StreamState::Done) && s.chunks.is_empty()) {
                break;
            }
        }
    }

    /// Takes the events sent so far and passes on those that can be ordered: for kernels that run on this thread in
    /// turns.
    pub fn pump(&mut self, sink: &mut dyn LogSink, on_stop: impl FnOnce()) {
        let mut any = false;
        while let Ok(message) = self.messages.try_recv() {
            self.take(message);
            any = true;
        }
        if any {
            self.hand_on(sink, on_stop);
        }
    }

    /// Passes on the events that can be ordered; once the sink has refused events, discards them.
    fn hand_on(&mut self, sink: &mut dyn LogSink, on_stop: impl FnOnce()) {
        if self.end == MergeEnd::Complete {
            self.end = self.emit(sink);
            if self.end != MergeEnd::Complete {
                on_stop();
            }
        }
        if self.end != MergeEnd::Complete {
            self.discard();
        }
        self.advance_chunks();
    }

    /// If the log waits for events that a sleeping kernel keeps back, gives chunks in advance to the kernels that have
    /// none left.
    fn advance_chunks(&mut self) {
        let first = self.streams.iter().min_by_key(|stream| stream.floor());
        if !first.is_some_and(|first| first.asleep && first.chunks.is_empty()) {
            return;
        }
        for stream in &mut self.streams {
            while stream.chunks.len() >= self.credit + stream.advanced && stream.back.try_send(Chunk::default()).is_ok()
            {
                stream.advanced += 1;
            }
        }
    }

    fn stream(&mut self, channel: u16) -> Option<&mut MergeStream> {
        self.streams.iter_mut().find(|s| s.channel == channel)
    }

    fn take(&mut self, message: MergerMessage) {
        match message {
            MergerMessage::Chunk { channel, events, upto } => {
                if let Some(stream) = self.stream(channel) {
                    stream.state = StreamState::Active(upto);
                    if events.is_empty() {
                        recycle(stream, events);
                    } else {
                        stream.chunks.push_back((events, 0));
                    }
                }
            }
            MergerMessage::Asleep(channel) | MergerMessage::Awake(channel) => {
                let asleep = matches!(message, MergerMessage::Asleep(_));
                if let Some(stream) = self.stream(channel) {
                    stream.asleep = asleep;
                }
            }
            MergerMessage::Advanced(channel) => {
                if let Some(stream) = self.stream(channel) {
                    stream.advanced += 1;
                }
            }
            MergerMessage::Blocked(channel) => self.set(channel, StreamState::Blocked),
            MergerMessage::Resumed(channel, tag) => self.set(channel, StreamState::Active(tag)),
            MergerMessage::Done(channel) => self.set(channel, StreamState::Done),
            MergerMessage::StopAt(tag) => self.stop = self.stop.min(tag),
        }
    }

    fn set(&mut self, channel: u16, state: StreamState) {
        if let Some(stream) = self.stream(channel) {
            stream.state = state;
        }
    }

    fn discard(&mut self) {
        for stream in &mut self.streams {
            while let Some((events, _)) = stream.chunks.pop_front() {
                recycle(stream, events);
            }
        }
    }

    /// Emits every event whose position in the log is final.
    fn emit(&mut self, sink: &mut dyn LogSink) -> MergeEnd {
        loop {
            let Some(index) = (0..self.streams.len())
                .filter(|&i| self.streams.get(i).is_some_and(|s| s.head().is_some()))
                .min_by_key(|&i| self.streams.get(i).map(MergeStream::floor))
            else {
                return MergeEnd::Complete;
            };
            let bound = self
                .streams
                .iter()
                .enumerate()
                .filter(|&(i, _)| i != index)
                .map(|(_, s)| s.floor())
                .min()
                .unwrap_or(Tag::END);
            let Some(stream) = self.streams.get_mut(index) else { return MergeEnd::Complete };
            if stream.floor() > self.stop {
                // Everything left is after the stop.
                for stream in &mut self.streams {
                    while let Some((events, _)) = stream.chunks.pop_front() {
                        recycle(stream, events);
                    }
                }
                return MergeEnd::Complete;
            }
            let (channel, stop) = (stream.channel, self.stop);
            let Some((events, at)) = stream.chunks.pop_front() else { return MergeEnd::Complete };
            let rest = events.get(at..).unwrap_or_default();
            let run = rest
                .iter()
                .position(|e| {
                    let tag = Tag { t: e.t_ns, micro: e.micro, channel };
                    tag > bound || tag > stop
                })
                .unwrap_or(rest.len());
            let end = self.send(rest.get(..run).unwrap_or_default(), sink);
            let Some(stream) = self.streams.get_mut(index) else { return MergeEnd::Complete };
            if at + run >= events.len() {
                recycle(stream, events);
            } else {
                stream.chunks.push_front((events, at + run));
            }
            if end != MergeEnd::Complete || run == 0 {
                return end;
            }
        }
    }
}

/// Gives a chunk back to its kernel, unless the kernel has got another one in advance.
fn recycle(stream: &mut MergeStream, events: Chunk) {
    match stream.advanced.checked_sub(1) {
        Some(advanced) => stream.advanced = advanced,
        None => drop(stream.back.try_send(events)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_event::event::{Dwell, Kind, SourcePlace};

    /// The channels and times of a log.
    #[derive(Default)]
    struct Seen(Vec<(u16, i64)>);

    impl LogSink for Seen {
        fn events(&mut self, _: u64, events: &[Event]) -> bool {
            self.0.extend(events.iter().map(|event| (event.channel, event.t_ns)));
            true
        }
    }

    fn chunk(channel: u16, t_ns: i64) -> Chunk {
        Chunk::new(vec![Event {
            t_ns,
            micro: 0,
            dur_ns: 0,
            channel,
            file: 0,
            line: 0,
            caller: SourcePlace::NONE,
            kind: Kind::Dwell(Dwell),
        }])
    }

    #[test]
    fn a_kernel_goes_on_that_a_sleeping_one_waits_for_with_an_event_kept_back() {
        let (mut merger, mut feeders, sender) = Merger::new(1..=2, 0);
        let (mut late, mut sleeper) = (feeders.pop().unwrap(), feeders.pop().unwrap());
        let mut seen = Seen::default();
        let tag = |t, channel| Tag { t, micro: 0, channel };
        let pump = |merger: &mut Merger, seen: &mut Seen| merger.pump(seen, || ());
        sleeper.send(Chunk::default(), tag(5, 1));
        let mut t = 10;
        while !late.is_full() {
            late.send(chunk(2, t), tag(t, 2));
            t += 1;
        }
        pump(&mut merger, &mut seen);
        assert!(late.try_back().is_none() && seen.0.is_empty(), "the log waits for the event that is kept back");
        sender.send(MergerMessage::Asleep(1)).unwrap();
        for _ in 0..20 {
            pump(&mut merger, &mut seen);
            assert!(late.try_back().is_some(), "a chunk in advance");
            late.send(chunk(2, t), tag(t, 2));
            t += 1;
        }
        sender.send(MergerMessage::Awake(1)).unwrap();
        sleeper.send(chunk(1, 5), tag(100, 1));
        late.send(Chunk::default(), Tag::END);
        pump(&mut merger, &mut seen);
        let expected: Vec<_> = std::iter::once((1, 5)).chain((10..t).map(|t| (2, t))).collect();
        assert_eq!(seen.0, expected);
        // Every chunk comes back once.
        let back = std::iter::from_fn(|| late.try_back()).count();
        assert!(back > 0 && late.sent == 0, "{back} {}", late.sent);
    }
}
