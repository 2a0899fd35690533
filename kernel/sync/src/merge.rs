//! From the kernels' own event streams to the one ordered log.
//!
//! Each kernel sends chunks in its own order with a promise `upto`: nothing earlier will follow. An event goes out
//! when no other stream can still produce an earlier one. Invariant: messages about a stream's state are sent under
//! the coordinator's lock, so a release is in the queue before anything that the released partner's releaser does
//! later. A kernel may have only `CREDIT` chunks on the way, each with `TEXTS`
//! bytes of text; beyond that it waits for one to come back.

use std::collections::VecDeque;

use crossbeam_channel::{Receiver, Sender, bounded, unbounded};

use crate::backlog::Chunk;
use crate::sink::Sink;
use crate::tag::Tag;
use counterpoint_event::event::Event;

/// Events in a full chunk.
pub const CHUNK: usize = 512;
/// Chunks a kernel may have on the way, less when the memory of the job has no room for them.
const CREDIT: usize = 8;
/// Bytes of texts after which a chunk goes out though it is not full.
pub const TEXTS: usize = 32 << 10;

/// Messages of the kernels to the merger.
pub enum Message {
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
    /// The stream is complete.
    Done(u16),
    /// Nothing after this tag belongs to the log.
    StopAt(Tag),
}

/// A kernel's end of the merger.
pub struct Feeder {
    /// Number of the channel.
    pub channel: u16,
    messages: Sender<Message>,
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
        let _ = self.messages.send(Message::Chunk { channel: self.channel, events, upto });
    }

    /// As many chunks are on the way as may be: the kernel waits for one to come back.
    pub fn is_full(&self) -> bool {
        self.sent >= self.credit
    }

    /// A chunk that has come back.
    pub fn try_back(&mut self) -> Option<Chunk> {
        let chunk = self.back.try_recv().ok()?;
        self.sent -= 1;
        Some(chunk)
    }

    /// Waits for a chunk to come back.
    pub fn wait_back(&mut self) -> Chunk {
        self.sent -= 1;
        self.back.recv().unwrap_or_default()
    }
}

enum State {
    Active(Tag),
    Blocked,
    Done,
}

struct Stream {
    channel: u16,
    chunks: VecDeque<(Chunk, usize)>,
    state: State,
    /// Where chunks go that are in the log.
    back: Sender<Chunk>,
}

impl Stream {
    fn head(&self) -> Option<Tag> {
        let (events, at) = self.chunks.front()?;
        events.get(*at).map(|e| Tag { t: e.t_ns, micro: e.micro, channel: self.channel })
    }

    /// No event of this stream that is not yet out is before this tag.
    fn floor(&self) -> Tag {
        match (self.head(), &self.state) {
            (Some(head), _) => head,
            (None, State::Active(upto)) => *upto,
            (None, _) => Tag::END,
        }
    }
}

/// The merger: owned by the thread that runs the job.
pub struct Merger {
    streams: Vec<Stream>,
    messages: Receiver<Message>,
    stop: Tag,
    /// Number of the next event.
    pub next_seq: u64,
    /// How the log ended so far.
    end: End,
}

/// Why the merger returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// All streams are complete.
    Complete,
    /// The sink refused events.
    Refused,
}

impl Merger {
    /// A merger for these channels, each with `room` bytes on the way at most, a feeder for each of them, and a sender
    /// for messages about streams.
    pub fn new(channels: impl Iterator<Item = u16>, room: u64) -> (Self, Vec<Feeder>, Sender<Message>) {
        let chunk = (CHUNK * size_of::<Event>() + TEXTS) as u64;
        let credit = usize::try_from(room / chunk).unwrap_or(CREDIT).clamp(2, CREDIT);
        let (sender, messages) = unbounded();
        let mut streams = Vec::new();
        let mut feeders = Vec::new();
        for channel in channels {
            let (back, returned) = bounded(CREDIT);
            let floor = Tag { t: 0, micro: 0, channel };
            streams.push(Stream {
                channel,
                chunks: VecDeque::with_capacity(CREDIT),
                state: State::Active(floor),
                back,
            });
            feeders.push(Feeder { channel, messages: sender.clone(), back: returned, sent: 0, credit });
        }
        (Self { streams, messages, stop: Tag::END, next_seq: 1, end: End::Complete }, feeders, sender)
    }

    /// Passes events of the only stream on. Returns `false` when the log takes nothing more.
    pub fn pass(&mut self, events: &[Event], sink: &mut dyn Sink) -> bool {
        if self.end == End::Complete {
            self.end = self.send(events, sink);
        }
        self.end == End::Complete
    }

    /// How the log ended.
    pub fn end(&self) -> End {
        self.end
    }

    /// Hands events that are next in the log to the sink.
    fn send(&mut self, batch: &[Event], sink: &mut dyn Sink) -> End {
        if !batch.is_empty() && !sink.events(self.next_seq, batch) {
            return End::Refused;
        }
        self.next_seq += batch.len() as u64;
        End::Complete
    }

    /// Receives and merges until all streams are complete. After [`End::Refused`] the streams are still drained
    /// (kernels must end), but nothing more goes to the sink.
    pub fn run(&mut self, sink: &mut dyn Sink, mut on_stop: impl FnMut()) {
        while let Ok(message) = self.messages.recv() {
            self.take(message);
            while let Ok(message) = self.messages.try_recv() {
                self.take(message);
            }
            self.hand_on(sink, &mut on_stop);
            if self.streams.iter().all(|s| matches!(s.state, State::Done) && s.chunks.is_empty()) {
                break;
            }
        }
    }

    /// Takes the events sent so far and passes on those that can be ordered: for kernels that run on this thread in
    /// turns.
    pub fn pump(&mut self, sink: &mut dyn Sink, on_stop: impl FnOnce()) {
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
    fn hand_on(&mut self, sink: &mut dyn Sink, on_stop: impl FnOnce()) {
        if self.end == End::Complete {
            self.end = self.emit(sink);
            if self.end != End::Complete {
                on_stop();
            }
        }
        if self.end != End::Complete {
            self.discard();
        }
    }

    fn stream(&mut self, channel: u16) -> Option<&mut Stream> {
        self.streams.iter_mut().find(|s| s.channel == channel)
    }

    fn take(&mut self, message: Message) {
        match message {
            Message::Chunk { channel, events, upto } => {
                if let Some(stream) = self.stream(channel) {
                    stream.state = State::Active(upto);
                    if events.is_empty() {
                        recycle(stream, events);
                    } else {
                        stream.chunks.push_back((events, 0));
                    }
                }
            }
            Message::Blocked(channel) => self.set(channel, State::Blocked),
            Message::Resumed(channel, tag) => self.set(channel, State::Active(tag)),
            Message::Done(channel) => self.set(channel, State::Done),
            Message::StopAt(tag) => self.stop = self.stop.min(tag),
        }
    }

    fn set(&mut self, channel: u16, state: State) {
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
    fn emit(&mut self, sink: &mut dyn Sink) -> End {
        loop {
            let Some(index) = (0..self.streams.len())
                .filter(|&i| self.streams.get(i).is_some_and(|s| s.head().is_some()))
                .min_by_key(|&i| self.streams.get(i).map(Stream::floor))
            else {
                return End::Complete;
            };
            let bound = self
                .streams
                .iter()
                .enumerate()
                .filter(|&(i, _)| i != index)
                .map(|(_, s)| s.floor())
                .min()
                .unwrap_or(Tag::END);
            let Some(stream) = self.streams.get_mut(index) else { return End::Complete };
            if stream.floor() > self.stop {
                // Everything left is after the stop.
                for stream in &mut self.streams {
                    while let Some((events, _)) = stream.chunks.pop_front() {
                        recycle(stream, events);
                    }
                }
                return End::Complete;
            }
            let (channel, stop) = (stream.channel, self.stop);
            let Some((events, at)) = stream.chunks.pop_front() else { return End::Complete };
            let rest = events.get(at..).unwrap_or_default();
            let run = rest
                .iter()
                .position(|e| {
                    let tag = Tag { t: e.t_ns, micro: e.micro, channel };
                    tag > bound || tag > stop
                })
                .unwrap_or(rest.len());
            let end = self.send(rest.get(..run).unwrap_or_default(), sink);
            let Some(stream) = self.streams.get_mut(index) else { return End::Complete };
            if at + run >= events.len() {
                recycle(stream, events);
            } else {
                stream.chunks.push_front((events, at + run));
            }
            if end != End::Complete || run == 0 {
                return end;
            }
        }
    }
}

/// Gives a chunk back to its kernel.
fn recycle(stream: &Stream, events: Chunk) {
    let _ = stream.back.try_send(events);
}
