//! The fingerprint of a log: equal logs, and only those, have the same digest on every platform.
//!
//! A log is fingerprinted channel by channel: its order is that of the events' times, microsteps and channels, so equal
//! channels make equal logs. Each channel is BLAKE3 over a canonical binary form of its events; the digest of the log
//! is BLAKE3 over the number and the fingerprint of every channel that has events, the master (0) first.
//!
//! The form consists of little-endian words. Each event starts with one word: kind, flags of expected fields, which are
//! omitted, axes that change, and the number of expected blocks before it (the next line of the file, counted on, at
//! the time where the event before ended). `-0.0` counts as `0.0`, texts and lists carry their length (u32), kinds and
//! words their number on the wire, counted from 0. A motion gives the axes whose start differs from the end of the last
//! motion and those whose end differs from the start, and only those. Laws of motions are not part of the form, so the
//! fingerprint is the same with or without them. *Invariant:* every field of every other event can be read from the
//! form; numbers already given to a kind or a state never change.

mod form;

use blake3::Hasher;

use counterpoint_event::event::{BlockEvent, Event, FeedUnit, Kind, MAX_AXES, Motion, MotionKind, Position};
use form::{bits, number, write_kind};

/// Bytes that are hashed at once: a power of two, always whole, keeps the hash function's parallel lanes busy; not so
/// many that another kernel has to wait for it.
const CHUNK: usize = 16 * 1024;

/// Builds the digest of one channel's events.
#[derive(Debug)]
pub struct Digest {
    hasher: Hasher,
    form: CanonicalForm,
    /// Where the words of an event are put together.
    scratch: Scratch,
}

type Scratch = [u64; MOST];

/// The canonical form and the state that it depends on.
#[derive(Debug, Default)]
struct CanonicalForm {
    out: Vec<u8>,
    /// Head of the event before.
    last: EventHead,
    /// Number of the block before.
    number: u64,
    /// Blocks as expected that no word has counted yet.
    blocks: u16,
    /// The motion before.
    motion: Option<MotionFacts>,
    /// Where it ended.
    end: Position,
    /// Its feed.
    feed: f64,
}

/// The fields that every event has; the time is where it ended.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct EventHead {
    over_ns: i64,
    micro: u32,
    file: u16,
    line: u32,
}

/// State that mostly stays the same from motion to motion.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MotionFacts {
    kind: MotionKind,
    feed_unit: FeedUnit,
    moving: u8,
    plane_axes: [u8; 2],
    turns: u16,
}

/// A run of expected blocks with nothing after it.
const ONLY_BLOCKS: u8 = 255;

/// Flags of the word an event begins with.
mod flag {
    /// It begins where the one before ended.
    pub(super) const FOLLOWS: u8 = 1;
    pub(super) const SAME_MICRO: u8 = 2;
    pub(super) const NO_TIME: u8 = 4;
    pub(super) const SAME_FILE: u8 = 8;
    pub(super) const SAME_LINE: u8 = 16;
    /// Feed of the motion before.
    pub(super) const SAME_FEED: u8 = 32;
    /// Facts of the motion before.
    pub(super) const SAME_FACTS: u8 = 64;
    /// A centre is given; it is zero otherwise.
    pub(super) const CENTER: u8 = 128;
}

impl Default for Digest {
    fn default() -> Self {
        Self::new()
    }
}

impl Digest {
    /// Digest of no events.
    #[must_use]
    pub fn new() -> Self {
        let out = Vec::with_capacity(CHUNK + 1024);
        Self { hasher: Hasher::new(), form: CanonicalForm { out, ..CanonicalForm::default() }, scratch: [0; MOST] }
    }

    /// Adds the next event of the channel.
    #[inline]
    pub fn event(&mut self, event: &Event) {
        if self.form.expected(event) || matches!(event.kind, Kind::Law(_)) {
            return;
        }
        self.form.event(event, &mut self.scratch);
        if let Some((whole, _)) = self.form.out.split_at_checked(CHUNK) {
            self.hasher.update(whole);
            self.form.out.drain(..CHUNK);
        }
    }

    /// The fingerprint; `None` without events.
    #[must_use]
    pub fn finish(mut self) -> Option<[u8; 32]> {
        self.form.close();
        self.hasher.update(&self.form.out);
        (self.hasher.count() > 0).then(|| *self.hasher.finalize().as_bytes())
    }
}

/// The digest of a log as 64 hexadecimal digits, from the fingerprints of its channels in ascending order.
pub fn log(channels: impl Iterator<Item = (u16, Digest)>) -> String {
    let mut hasher = Hasher::new();
    for (number, digest) in channels {
        if let Some(fingerprint) = digest.finish() {
            hasher.update(&number.to_le_bytes());
            hasher.update(&fingerprint);
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// Words of one event.
struct EventWords<'s> {
    words: &'s mut Scratch,
    count: usize,
}

/// Words an event has at most: its head, facts, feed, two positions, a centre, a length.
const MOST: usize = 6 + 2 + 2 * MAX_AXES + 2 + 1;

impl EventWords<'_> {
    #[inline(always)]
    fn put(&mut self, word: u64) {
        if let Some(slot) = self.words.get_mut(self.count) {
            *slot = word;
            self.count += 1;
        }
    }

    /// Appends the words, little-endian.
    #[inline(always)]
    fn write(&mut self, out: &mut Vec<u8>) {
        let words = self.words.get_mut(..self.count).unwrap_or_default();
        words.iter_mut().for_each(|word| *word = word.to_le());
        out.extend_from_slice(bytemuck::cast_slice(words));
    }

    #[inline(always)]
    fn put_float(&mut self, value: f64) {
        self.put(bits(value));
    }

    /// Axes that differ, and their values in `now`. A NaN differs from everything.
    #[inline(always)]
    fn changed(&mut self, before: &Position, now: &Position) -> u64 {
        let mut axes = 0_u64;
        for (axis, (a, b)) in before.iter().zip(now).enumerate() {
            axes |= u64::from(a != b) << axis;
        }
        let mut left = axes;
        while left != 0 {
            self.put_float(now.get(left.trailing_zeros() as usize).copied().unwrap_or_default());
            left &= left - 1;
        }
        axes
    }
}

impl CanonicalForm {
    /// A block as expected is only counted.
    #[inline(always)]
    fn expected(&mut self, event: &Event) -> bool {
        let Kind::Block(BlockEvent { number, .. }) = event.kind else { return false };
        let last = &mut self.last;
        let expected = number == self.number.wrapping_add(1)
            && event.line == last.line.wrapping_add(1)
            && event.t_ns == last.over_ns
            && event.micro == last.micro
            && event.file == last.file
            && event.dur_ns == 0
            && self.blocks < u16::MAX;
        if expected {
            self.number = number;
            last.line = event.line;
            self.blocks += 1;
        }
        expected
    }

    fn event(&mut self, event: &Event, scratch: &mut Scratch) {
        let head = EventHead {
            over_ns: event.t_ns.wrapping_add(event.dur_ns),
            micro: event.micro,
            file: event.file,
            line: event.line,
        };
        let last = std::mem::replace(&mut self.last, head);
        let mut flags = 0;
        // The first word is written last.
        let mut words = EventWords { words: scratch, count: 1 };
        if event.t_ns == last.over_ns {
            flags |= flag::FOLLOWS;
        } else {
            words.put(event.t_ns as u64);
        }
        if event.dur_ns == 0 {
            flags |= flag::NO_TIME;
        } else {
            words.put(event.dur_ns as u64);
        }
        if head.micro == last.micro {
            flags |= flag::SAME_MICRO;
        } else {
            words.put(u64::from(head.micro));
        }
        if head.file == last.file {
            flags |= flag::SAME_FILE;
        } else {
            words.put(u64::from(head.file));
        }
        if head.line == last.line {
            flags |= flag::SAME_LINE;
        } else {
            words.put(u64::from(head.line));
        }
        let mut axes = 0;
        match &event.kind {
            Kind::Motion(motion) => axes = self.motion(motion, &mut words, &mut flags),
            Kind::Block(block) => {
                self.number = block.number;
                words.put(block.number);
            }
            _ => {}
        }
        words.words[0] =
            u64::from(number(&event.kind)) | u64::from(flags) << 8 | axes << 16 | u64::from(self.blocks) << 32;
        self.blocks = 0;
        words.write(&mut self.out);
        write_kind(&mut self.out, &event.kind);
    }

    /// The words of a motion; returns the axes that change, of the start and of the end.
    #[inline(always)]
    fn motion(&mut self, motion: &Motion, words: &mut EventWords<'_>, flags: &mut u8) -> u64 {
        let facts = MotionFacts {
            kind: motion.kind,
            feed_unit: motion.feed_unit,
            moving: motion.moving,
            plane_axes: motion.plane_axes,
            turns: motion.turns,
        };
        if self.motion == Some(facts) {
            *flags |= flag::SAME_FACTS;
        } else {
            self.motion = Some(facts);
            words.put(facts.word());
        }
        if motion.feed == self.feed {
            *flags |= flag::SAME_FEED;
        } else {
            self.feed = motion.feed;
            words.put_float(motion.feed);
        }
        let from = words.changed(&self.end, &motion.from);
        let to = words.changed(&motion.from, &motion.to);
        self.end = motion.to;
        if motion.center != [0.0; 2] {
            *flags |= flag::CENTER;
            words.put_float(motion.center[0]);
            words.put_float(motion.center[1]);
        }
        words.put_float(motion.length);
        from | to << 8
    }

    /// Writes the blocks that are only counted so far.
    fn close(&mut self) {
        if self.blocks > 0 {
            let word = u64::from(ONLY_BLOCKS) | u64::from(self.blocks) << 32;
            self.out.extend_from_slice(&word.to_le_bytes());
            self.blocks = 0;
        }
    }
}

impl MotionFacts {
    fn word(self) -> u64 {
        let (kind, unit) = (self.kind.number().wrapping_sub(1), self.feed_unit.number().wrapping_sub(1));
        let [a, b] = self.turns.to_le_bytes();
        u64::from_le_bytes([kind, unit, self.moving, self.plane_axes[0], self.plane_axes[1], a, b, 0])
    }
}

#[cfg(test)]
mod tests;
