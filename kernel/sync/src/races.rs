//! Races: two accesses to one shared variable, at least one of them a write, that no wait, signal or poll puts in
//! order.
//!
//! Every channel has a vector clock. Its acts for others (an arrival, a flag, a signal, a release, its end) publish its
//! clock under the mark; a wait that ends takes over the clocks that its partners have published there. A poll that
//! sees a value takes over the clock of the channel that wrote it. *Invariant:* accesses and waits come in tag order,
//! so the races of a job depend on simulated time alone; nothing is kept until the first access. Facts: reference
//! channel-synchronisation.md 2.4.

#[cfg(test)]
mod tests;

use crate::wait::MarkSpace;
use std::collections::{BTreeMap, BTreeSet};

use crate::channels::Channels;
use crate::wait::{ChannelSet, Send, Wait, WaitMark, WaitOp};
use counterpoint_event::event::{FileId, Primitive};

/// Most pairs of lines that are reported, and most variables that are followed.
const MOST: usize = 10_000;

/// A variable that channels share.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum RaceVariable {
    /// A numbered common variable.
    Common(u32),
    /// A variable with a name.
    Named(Box<str>),
    /// A GLOBAL variable of macros, by index.
    Global(u32),
}

/// How a variable is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AccessMode {
    /// It is read.
    Read,
    /// It is read by a loop that waits for its value.
    Poll,
    /// It is written.
    Write,
}

/// An access: by whom, in which block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct AccessSite {
    /// Channel.
    pub channel: u16,
    /// File of the block.
    pub file: FileId,
    /// Line of the block, from 1.
    pub line: u32,
}

/// The earlier one of two accesses that race.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Race {
    /// Who it was, and where.
    pub earlier: AccessSite,
    /// It was a write.
    pub wrote: bool,
}

/// By channel: how much of its work has happened before.
type Clock = Box<[u32]>;

/// The last access of a channel, and its clock at that time.
type Last = Option<(AccessSite, u32)>;

/// Data of a variable.
#[derive(Debug, Clone)]
struct History {
    reads: Box<[Last]>,
    writes: Box<[Last]>,
    /// Clock of the last write.
    written: Option<Clock>,
}

/// The races of a job.
#[derive(Debug, Clone)]
pub struct RaceDetector {
    channels: Channels,
    clocks: Vec<Clock>,
    /// By channel, primitive (its number) and mark: its clock when it last did something there for others.
    published: BTreeMap<(u16, u8, WaitMark), Clock>,
    /// By channel: the wait at which it arrived last.
    waits: Vec<Option<Wait>>,
    histories: BTreeMap<RaceVariable, History>,
    /// Pairs of lines that have been reported.
    reported: BTreeSet<(RaceVariable, AccessSite, AccessSite)>,
}

/// The mark under which arrivals at a wait are published. A channel at a barrier has done nothing since; of the other
/// primitives each mark counts for itself.
fn place(primitive: Primitive, key: WaitMark) -> WaitMark {
    match primitive {
        Primitive::Barrier | Primitive::Count | Primitive::Join => WaitMark { space: MarkSpace::Statements, number: 0 },
        Primitive::Flag | Primitive::Order | Primitive::Signal | Primitive::Lease => key,
    }
}

/// Takes over the knowledge of another clock.
fn join(clock: &mut Clock, other: &Clock) {
    for (own, other) in clock.iter_mut().zip(other.iter()) {
        *own = (*own).max(*other);
    }
}

impl RaceDetector {
    /// No variable has been reached yet.
    pub fn new(channels: Channels) -> Self {
        let count = channels.count();
        let clock = |index: usize| (0..count).map(|at| u32::from(at == index)).collect::<Clock>();
        Self {
            clocks: (0..count).map(clock).collect(),
            waits: vec![None; count],
            channels,
            published: BTreeMap::new(),
            histories: BTreeMap::new(),
            reported: BTreeSet::new(),
        }
    }

    fn is_idle(&self) -> bool {
        self.histories.is_empty()
    }

    /// The clock of a channel, for others; later acts of the channel come after it.
    fn publish(&mut self, channel: u16) -> Option<Clock> {
        let index = self.channels.index(channel);
        let clock = self.clocks.get_mut(index)?;
        let published = clock.clone();
        if let Some(own) = clock.get_mut(index) {
            *own = own.saturating_add(1);
        }
        Some(published)
    }

    fn publish_at(&mut self, channel: u16, primitive: Primitive, key: WaitMark) {
        if let Some(clock) = self.publish(channel) {
            self.published.insert((channel, primitive.number(), place(primitive, key)), clock);
        }
    }

    /// A channel arrives at a wait.
    pub(crate) fn arrive(&mut self, channel: u16, wait: &Wait) {
        if let Some(at) = self.waits.get_mut(self.channels.index(channel)) {
            *at = Some(*wait);
        }
        // A channel that waits for signals, ends or leases has no effect on others by that.
        let tells =
            matches!(wait.primitive, Primitive::Barrier | Primitive::Flag | Primitive::Order | Primitive::Count);
        if tells && !self.is_idle() {
            self.publish_at(channel, wait.primitive, wait.key);
        }
    }

    /// A channel does something for others.
    pub(crate) fn act(&mut self, channel: u16, act: WaitOp) {
        if self.is_idle() {
            return;
        }
        match act {
            WaitOp::Set(key) => self.publish_at(channel, Primitive::Flag, key),
            WaitOp::Signal(Send { key, .. }) => self.publish_at(channel, Primitive::Signal, key),
            WaitOp::Release(key) => self.publish_at(channel, Primitive::Lease, key),
            WaitOp::Give { key, .. } => self.publish_at(channel, Primitive::Lease, key),
            WaitOp::Clear(_) | WaitOp::Remove { .. } | WaitOp::Take(_) => {}
        }
    }

    /// The program of a channel ends.
    pub(crate) fn finish(&mut self, channel: u16) {
        if !self.is_idle() {
            self.publish_at(channel, Primitive::Join, WaitMark { space: MarkSpace::Statements, number: 0 });
        }
    }

    /// Records that the waits of these channels are over, by an act of another channel.
    pub(crate) fn release(&mut self, channels: ChannelSet, by: u16) {
        if self.is_idle() {
            return;
        }
        for channel in channels.iter() {
            if let Some(wait) = self.waits.get(self.channels.index(channel)).copied().flatten() {
                self.take_over(channel, &wait);
            }
        }
        let index = self.channels.index(by);
        if !channels.has(by)
            && let Some(clock) = self.publish(by)
        {
            let others = channels.iter().map(|channel| self.channels.index(channel)).filter(|other| *other != index);
            for other in others.collect::<Vec<_>>() {
                self.clocks.get_mut(other).into_iter().for_each(|own| join(own, &clock));
            }
        }
    }

    /// One channel starts others.
    pub(crate) fn start(&mut self, channels: ChannelSet, by: u16) {
        if self.is_idle() {
            return;
        }
        let Some(clock) = self.publish(by) else { return };
        for channel in channels.iter() {
            let index = self.channels.index(channel);
            self.clocks.get_mut(index).into_iter().for_each(|own| join(own, &clock));
        }
    }

    /// A channel need not wait.
    pub(crate) fn pass(&mut self, channel: u16, wait: &Wait) {
        if !self.is_idle() {
            self.take_over(channel, wait);
        }
    }

    /// Records that the wait of a channel is over: the acts of its partners there happened before.
    fn take_over(&mut self, channel: u16, wait: &Wait) {
        let Some(own) = self.clocks.get_mut(self.channels.index(channel)) else { return };
        let (primitive, key) = (wait.primitive.number(), place(wait.primitive, wait.key));
        for partner in wait.parts.without(channel).iter() {
            let published = match wait.primitive {
                // The first number that was large enough.
                Primitive::Order => {
                    let last = WaitMark { number: u32::MAX, ..key };
                    let range = (partner, primitive, key)..=(partner, primitive, last);
                    self.published.range(range).next().map(|(_, clock)| clock)
                }
                _ => self.published.get(&(partner, primitive, key)),
            };
            published.into_iter().for_each(|clock| join(own, clock));
        }
    }

    /// A channel reaches a variable: the races with earlier accesses that have not been reported yet.
    pub fn access(&mut self, variable: &RaceVariable, access: AccessSite, mode: AccessMode) -> Vec<Race> {
        let (index, count) = (self.channels.index(access.channel), self.channels.count());
        if index >= count || self.histories.len() >= MOST && !self.histories.contains_key(variable) {
            return Vec::new();
        }
        let fresh = || History { reads: vec![None; count].into(), writes: vec![None; count].into(), written: None };
        if !self.histories.contains_key(variable) {
            self.histories.insert(variable.clone(), fresh());
        }
        let published = if mode == AccessMode::Write { self.publish(access.channel) } else { None };
        let Self { channels, clocks, histories, reported, .. } = self;
        let (Some(clock), Some(history)) = (clocks.get_mut(index), histories.get_mut(variable)) else {
            return Vec::new();
        };
        if mode == AccessMode::Poll {
            history.written.iter().for_each(|written| join(clock, written));
            // The earlier read at this place was the first look of the poll.
            if let Some(last) = history.reads.get_mut(index) {
                *last = last.filter(|(read, _)| *read != access);
            }
            return Vec::new();
        }
        let before = |last: &Last| last.filter(|(earlier, at)| clock.get(channels.index(earlier.channel)) < Some(at));
        let mut races: Vec<Race> =
            history.writes.iter().filter_map(before).map(|(earlier, _)| Race { earlier, wrote: true }).collect();
        if mode == AccessMode::Write {
            races.extend(history.reads.iter().filter_map(before).map(|(earlier, _)| Race { earlier, wrote: false }));
        }
        races.retain(|race| race.earlier.channel != access.channel);
        races.retain(|race| {
            let pair = (variable.clone(), race.earlier.min(access), race.earlier.max(access));
            reported.len() < MOST && reported.insert(pair)
        });
        let own = if mode == AccessMode::Write { &mut history.writes } else { &mut history.reads };
        // The clock that was published, if this is a write.
        let at = published.as_ref().unwrap_or(clock).get(index).copied().unwrap_or(0);
        if let Some(last) = own.get_mut(index) {
            *last = Some((access, at));
        }
        if published.is_some() {
            history.written = published;
        }
        races
    }
}
