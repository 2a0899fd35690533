//! Meeting points: who waits where, what matches, and who can never go on.
//!
//! Facts: reference channel-synchronisation.md 1.1, 1.3 (Fanuc), 2.3 (fix-point). Invariant: arrivals come in tag
//! order, so the outcome depends on simulated time alone.

mod start;

use std::fmt::Write as _;

use crate::ranks::Ranks;
use crate::tag::Tag;
use counterpoint_event::event::{FileId, Member, Primitive};

/// Set of channels, bit `n − 1` for channel `n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Set(pub u128);

impl Set {
    /// All channels up to `count`.
    pub fn up_to(count: u16) -> Self {
        (1..=count).collect()
    }

    /// With one more channel; numbers outside 1–128 are ignored.
    pub fn with(self, channel: u16) -> Self {
        if (1..=128).contains(&channel) { Self(self.0 | 1 << (channel - 1)) } else { self }
    }

    /// Membership.
    pub fn has(self, channel: u16) -> bool {
        (1..=128).contains(&channel) && self.0 & (1 << (channel - 1)) != 0
    }

    /// Channels, ascending.
    pub fn iter(self) -> impl Iterator<Item = u16> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let channel = left.trailing_zeros() as u16 + 1;
            left &= left.checked_sub(1)?;
            Some(channel)
        })
    }
}

impl FromIterator<u16> for Set {
    fn from_iter<I: IntoIterator<Item = u16>>(channels: I) -> Self {
        channels.into_iter().fold(Self::default(), Self::with)
    }
}

/// `1, 2 and 3`.
pub fn words(channels: &[u16]) -> String {
    let mut out = String::new();
    for (index, channel) in channels.iter().enumerate() {
        let separator = match index {
            0 => "",
            i if i + 1 == channels.len() => " and ",
            _ => ", ",
        };
        let _ = write!(out, "{separator}{channel}");
    }
    out
}

/// How the channel list was written; Fanuc compares it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Style {
    /// Not at all.
    NoList,
    /// As a list or a sum, which is the same set.
    Listed,
}

/// A wait as programmed.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Spec {
    /// Primitive.
    pub primitive: Primitive,
    /// Letter of the code.
    pub letter: char,
    /// Its number.
    pub number: u32,
    /// Channels as written.
    pub named: Set,
    /// Channels that take part, own one included.
    pub parts: Set,
    /// Form.
    pub style: Style,
}

impl Spec {
    /// The mark as the listing names it: the number alone if a letter is before it.
    pub fn mark(&self) -> String {
        match self.primitive {
            Primitive::Signal => self.text(),
            _ if self.letter.is_ascii_alphabetic() => self.number.to_string(),
            _ => format!("{}{}", self.letter, self.number),
        }
    }

    /// `M101` or `M101 P12`; `START1` for a start by one side.
    pub fn text(&self) -> String {
        if self.primitive == Primitive::Signal {
            return format!("START{}", self.number);
        }
        let mut out = format!("{}{}", self.letter, self.number);
        if self.style == Style::Listed {
            out.push_str(" P");
            for channel in self.named.iter() {
                let _ = write!(out, "{}", if channel == 10 { 0 } else { channel });
            }
        }
        out
    }

    fn matches(&self, other: &Self) -> bool {
        self.primitive == other.primitive
            && self.letter == other.letter
            && self.number == other.number
            && self.style == other.style
            && self.named == other.named
            && self.parts == other.parts
    }

    /// Case of PS0160 when both stand at the same time.
    fn mismatch(&self, other: &Self) -> Option<&'static str> {
        if self.primitive != Primitive::Barrier || other.primitive != Primitive::Barrier {
            return None;
        }
        let same_code = self.letter == other.letter && self.number == other.number;
        match (self.style, other.style) {
            (Style::NoList, Style::NoList) if !same_code => Some("different codes without P"),
            (Style::NoList, Style::Listed) | (Style::Listed, Style::NoList) => Some("one with P, one without"),
            (Style::Listed, Style::Listed) if same_code && self.named != other.named => {
                Some("the same code with different P")
            }
            (Style::Listed, Style::Listed) if !same_code && self.named == other.named => {
                Some("different codes with the same P")
            }
            _ => None,
        }
    }
}

/// A channel that stands at a wait.
#[derive(Debug, Clone, PartialEq)]
pub struct Waiting {
    /// What is waited for.
    pub spec: Spec,
    /// When the channel arrived.
    pub tag: Tag,
    /// File of the block.
    pub file: FileId,
    /// Line of the block.
    pub line: u32,
}

/// How a channel came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terminal {
    /// Its program ended.
    Ended,
    /// An alarm stopped it.
    Alarmed,
    /// It has no program.
    NeverStarted,
    /// It was stopped.
    Stopped,
}

/// The end of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finish {
    /// How it ended.
    pub how: Terminal,
    /// File of its last block.
    pub file: FileId,
    /// Line of its last block.
    pub line: u32,
}

/// What an arrival leads to.
#[derive(Debug, Clone, PartialEq)]
pub enum Arrival {
    /// The meeting is complete: these channels go on at this time.
    Released {
        /// Channels that continue, the arriving one among them.
        channels: Set,
        /// Time of the release, ns.
        t: i64,
        /// Its order at that time.
        micro: u32,
    },
    /// The channel stands.
    Blocked,
    /// The control refuses: these channels (the arriving one included) alarm.
    Mismatch {
        /// Channels whose waits do not match, the arriving one among them.
        channels: Set,
        /// The other waits.
        members: Vec<Member>,
        /// What does not match.
        text: String,
    },
}

/// All waits of the job.
#[derive(Debug, Clone)]
pub struct Waits {
    ranks: Ranks,
    waiting: Vec<Option<Waiting>>,
    finished: Vec<Option<Finish>>,
    release_ns: i64,
    /// Starts that a head has given and the other one has not used yet.
    starts: [u32; 2],
}

/// When a meeting lets go whose last arrival was at this time and microstep.
pub fn after(t: i64, micro: u32, release_ns: i64) -> (i64, u32) {
    if release_ns > 0 { (t + release_ns, 0) } else { (t, micro + 1) }
}

impl Waits {
    /// No channel waits yet; a release takes `release_ns`.
    pub fn new(ranks: Ranks, release_ns: i64) -> Self {
        let channels = ranks.count();
        Self { ranks, waiting: vec![None; channels], finished: vec![None; channels], release_ns, starts: [0; 2] }
    }

    /// The wait of a channel.
    pub fn at(&self, rank: u16) -> Option<&Waiting> {
        self.waiting.get(self.ranks.index(rank)).and_then(Option::as_ref)
    }

    /// How a channel ended.
    pub fn end(&self, rank: u16) -> Option<Finish> {
        self.finished.get(self.ranks.index(rank)).copied().flatten()
    }

    /// All channels, ascending.
    pub fn channels(&self) -> impl Iterator<Item = u16> + use<'_> {
        self.ranks.numbers().iter().copied()
    }

    /// A channel has ended.
    pub fn finish(&mut self, rank: u16, finish: Finish) {
        if let Some(slot) = self.finished.get_mut(self.ranks.index(rank)) {
            *slot = Some(finish);
        }
        self.leave(rank);
    }

    fn leave(&mut self, rank: u16) {
        if let Some(slot) = self.waiting.get_mut(self.ranks.index(rank)) {
            *slot = None;
        }
    }

    /// An arrival that raises no alarm and leaves nobody without hope: all others stand at the same meeting or can
    /// still come by themselves.
    pub fn is_plain(&self, arriving: &Waiting) -> bool {
        let own = arriving.tag.rank;
        self.waiting.iter().flatten().all(|other| arriving.spec.mismatch(&other.spec).is_none())
            && arriving.spec.parts.iter().filter(|&c| c != own).all(|c| match self.at(c) {
                Some(other) => other.spec.matches(&arriving.spec),
                None => self.end(c).is_none() && self.ranks.index(c) < self.waiting.len(),
            })
    }

    /// A channel arrives.
    pub fn arrive(&mut self, arriving: Waiting) -> Arrival {
        let rank = arriving.tag.rank;
        let mut refused = Set::default();
        let mut text = String::new();
        let mut members = Vec::new();
        for other in self.waiting.iter().flatten() {
            if let Some(case) = arriving.spec.mismatch(&other.spec) {
                refused = refused.with(other.tag.rank);
                members.push(Member {
                    channel: other.tag.rank,
                    file: other.file,
                    line: other.line,
                    waiting_for: Vec::new(),
                });
                let _ = write!(
                    text,
                    "{}channel {rank} waits at {}, channel {} at {}: {case}",
                    if text.is_empty() { "" } else { "; " },
                    arriving.spec.text(),
                    other.tag.rank,
                    other.spec.text()
                );
            }
        }
        if refused != Set::default() {
            for channel in refused.iter() {
                self.leave(channel);
            }
            return Arrival::Mismatch { channels: refused.with(rank), members, text };
        }
        let parts = arriving.spec.parts;
        if let Some(slot) = self.waiting.get_mut(self.ranks.index(rank)) {
            *slot = Some(arriving);
        }
        if self.missing(rank) != Set::default() {
            return Arrival::Blocked;
        }
        let (mut t, mut micro) = (0, 0);
        for tag in parts.iter().filter_map(|c| self.at(c)).map(|w| w.tag) {
            (t, micro) = (t, micro).max((tag.t, tag.micro));
        }
        for channel in parts.iter() {
            self.leave(channel);
        }
        (t, micro) = after(t, micro, self.release_ns);
        Arrival::Released { channels: parts, t, micro }
    }

    /// Participants of a channel's wait that have not arrived at the same meeting.
    pub fn missing(&self, rank: u16) -> Set {
        let Some(own) = self.at(rank) else { return Set::default() };
        let mut missing = Set::default();
        for channel in own.spec.parts.iter() {
            if !self.at(channel).is_some_and(|other| other.spec.matches(&own.spec)) {
                missing = missing.with(channel);
            }
        }
        missing
    }

    /// A waiting channel whose missing partners can all still arrive by themselves: no need to look further.
    pub fn hopeful(&self, rank: u16) -> bool {
        self.missing(rank).iter().all(|c| self.at(c).is_none() && self.end(c).is_none())
    }

    /// Channels that wait and can never go on: the complement of the fix-point over what can still arrive.
    pub fn dead(&self) -> Set {
        let mut live = Set::default();
        for channel in self.channels() {
            if self.at(channel).is_none() && self.end(channel).is_none() {
                live = live.with(channel);
            }
        }
        loop {
            let before = live;
            for channel in self.channels() {
                if self.at(channel).is_some() && self.missing(channel).iter().all(|m| live.has(m)) {
                    live = live.with(channel);
                }
            }
            if live == before {
                break;
            }
        }
        let mut dead = Set::default();
        for channel in self.channels() {
            if self.at(channel).is_some() && !live.has(channel) {
                dead = dead.with(channel);
            }
        }
        dead
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waiting(rank: u16, t: i64, number: u32, named: &[u16]) -> Waiting {
        let named_set = named.iter().fold(Set::default(), |s, &c| s.with(c));
        let (parts, style) =
            if named.is_empty() { (Set::up_to(2), Style::NoList) } else { (named_set.with(rank), Style::Listed) };
        let spec = Spec { primitive: Primitive::Barrier, letter: 'M', number, named: named_set, parts, style };
        Waiting { spec, tag: Tag { t, micro: 0, rank }, file: 0, line: 1 }
    }

    #[test]
    fn a_mark_is_the_number_after_a_letter() {
        let spec = |primitive, letter, named: &[u16]| Spec { primitive, letter, ..waiting(1, 0, 205, named).spec };
        assert_eq!(spec(Primitive::Barrier, 'M', &[1, 2]).mark(), "205");
        assert_eq!(spec(Primitive::Barrier, '!', &[]).mark(), "!205");
        assert_eq!(spec(Primitive::Signal, 'M', &[]).mark(), "START205");
    }

    #[test]
    fn a_meeting_releases_at_the_latest_arrival() {
        let mut waits = Waits::new(Ranks::new(1..=3), 0);
        assert_eq!(waits.arrive(waiting(1, 1, 101, &[1, 2, 3])), Arrival::Blocked);
        assert_eq!(waits.arrive(waiting(2, 5, 101, &[1, 2, 3])), Arrival::Blocked);
        let Arrival::Released { channels, t, micro } = waits.arrive(waiting(3, 7, 101, &[1, 2, 3])) else {
            panic!("not released");
        };
        assert_eq!((channels, t, micro), (Set::up_to(3), 7, 1));
    }

    #[test]
    fn fanuc_cases_of_the_alarm() {
        for (first, second, alarm) in [
            (waiting(1, 0, 101, &[]), waiting(2, 0, 102, &[]), true),
            (waiting(1, 0, 101, &[1, 2]), waiting(2, 0, 102, &[1, 2]), true),
            (waiting(1, 0, 101, &[1, 2, 3]), waiting(2, 0, 101, &[1, 2]), true),
            (waiting(1, 0, 101, &[]), waiting(2, 0, 101, &[1, 2]), true),
            (waiting(1, 0, 101, &[1, 2]), waiting(2, 0, 102, &[2, 3]), false),
        ] {
            let mut waits = Waits::new(Ranks::new(1..=3), 0);
            assert_eq!(waits.arrive(first), Arrival::Blocked);
            let arrival = waits.arrive(second.clone());
            assert_eq!(matches!(arrival, Arrival::Mismatch { .. }), alarm, "{second:?}: {arrival:?}");
        }
    }

    #[test]
    fn a_circle_of_three_is_dead_only_when_closed() {
        let mut waits = Waits::new(Ranks::new(1..=3), 0);
        waits.arrive(waiting(1, 1, 101, &[1, 2]));
        waits.arrive(waiting(2, 2, 102, &[2, 3]));
        assert_eq!(waits.dead(), Set::default());
        waits.arrive(waiting(3, 3, 103, &[1, 3]));
        assert_eq!(waits.dead(), Set::up_to(3));
    }
}
