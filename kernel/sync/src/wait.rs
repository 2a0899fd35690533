//! A wait as data: its mark, its channels, and the rule of its control.
//!
//! *Invariant:* nothing here depends on a control. The relation of two waits beyond their primitive, and their written
//! form, are in their [`WaitRule`], which the machine gives. Facts: reference channel-synchronisation.md 1.1.

mod set;

pub use crate::mark::{MarkRange, MarkSpace, RuleId, WaitMark};

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_event::event::{FileId, Primitive};

use crate::channels::Channels;
use crate::tag::Tag;

pub use set::{ChannelSet, words};

/// A wait as programmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Wait {
    /// Primitive.
    pub primitive: Primitive,
    /// Its mark.
    pub key: WaitMark,
    /// Channels as written; `None` without a list.
    pub named: Option<ChannelSet>,
    /// Channels that take part, the own one included.
    pub parts: ChannelSet,
    /// How many of them must have come; 0: all. [`Primitive::Count`] counts the own one, [`Primitive::Signal`] senders.
    pub need: u16,
    /// Its rule.
    pub rule: RuleId,
}

/// A signal that is sent to each of these channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Send {
    /// Its mark.
    pub key: WaitMark,
    /// Channels that get one.
    pub to: ChannelSet,
    /// It is for all channels: waits for any sender use it, those for named senders do not.
    pub broadcast: bool,
    /// When it is used up.
    pub lasts: Lasts,
}

/// How many waits a signal is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Lasts {
    /// One of each receiver.
    Each,
    /// This many: of each receiver, or of all of them together if it is for all channels.
    Times(u32),
    /// All, until it is removed; only for all channels.
    Always,
}

/// An act of a channel for others at once, without waiting itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WaitOp {
    /// Sets the own flag of a mark.
    Set(WaitMark),
    /// Deletes the own flag of a mark.
    Clear(WaitMark),
    /// Sends a signal.
    Signal(Send),
    /// Removes unused signals: of a single number the oldest one, of several numbers all.
    Remove {
        /// Their marks.
        range: MarkRange,
        /// Senders of the signals; none: those that were sent to all channels.
        to: Option<ChannelSet>,
    },
    /// Releases a resource that the channel holds.
    Release(WaitMark),
    /// Takes a resource that another channel holds.
    Take(WaitMark),
    /// Passes on a resource that the channel holds.
    Give {
        /// The resource.
        key: WaitMark,
        /// Channels that get it.
        to: u16,
    },
}

/// Meaning for a wait of a partner that has ended or has no program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absent {
    /// The wait never ends.
    Missed,
    /// It counts as arrived.
    Counts,
}

/// The control's reaction to two waits that it refuses to pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reaction {
    /// All of them are alarms.
    Alarm,
    /// It shows a warning; the waits continue.
    Warning,
}

/// Pairs of waits that a control refuses.
#[derive(Debug, Clone, Copy)]
pub struct MismatchCheck {
    /// Why these two cannot stand at the same time, if so.
    pub refuses: fn(&Wait, &Wait) -> Option<&'static str>,
    /// How the message about that begins.
    pub title: &'static str,
    /// Its consequences.
    pub reaction: Reaction,
}

/// The wait rules of a control.
#[derive(Debug, Clone)]
pub struct WaitRule {
    /// Word in front of the number.
    pub word: Box<str>,
    /// The number is written.
    pub numbered: bool,
    /// Text before the list of channels; empty if the list is not shown.
    pub list: Box<str>,
    /// How number and channels are written.
    pub style: WaitNotation,
    /// Pairs that it refuses; none: waits that do not match wait.
    pub mismatch: Option<MismatchCheck>,
    /// The meaning of an absent partner.
    pub absent: Absent,
    /// A partner that waits at a wait of this primitive counts as arrived.
    pub met_by: Option<Primitive>,
    /// The rules of the control for signals.
    pub signals: SignalRules,
    /// Names of the marks, by their numbers; empty: marks are numbers.
    pub names: Arc<[Box<str>]>,
    /// Whether the code does more than wait.
    pub acts: bool,
}

/// The signal rules of a control.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SignalRules {
    /// Word with which a partner sends the signal of this wait, if it is another word.
    pub sent_by: Option<Box<str>>,
    /// A channel may send signals to itself.
    pub to_itself: bool,
    /// The control warns of a wait while an older signal of the same sender has not been used.
    pub in_order: bool,
    /// Most signals and waits for signals that are kept at one time.
    pub most: Option<u32>,
}

/// How a wait is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WaitNotation {
    /// A word, its number, and the list of channels: `M101 P12`.
    Word,
    /// A statement, with number and channels in parentheses: `WAITM(1,1,2)`.
    Statement,
    /// A mark, the channels, and L with the number: `!12L1`.
    LineUp,
    /// A statement with keywords in brackets: `#WAIT [ID7 CH1 CH2]`.
    Keys,
    /// A word with the numbers of two axes, 15 bits each, of which the first may be missing: `G51.4 P102 Q202`, `G50.4
    /// Q202`.
    Axes,
}

impl WaitRule {
    /// Waits of a word that the control pairs freely.
    #[must_use]
    pub fn plain(word: &str) -> Self {
        Self {
            word: word.into(),
            numbered: true,
            list: "".into(),
            style: WaitNotation::Word,
            mismatch: None,
            absent: Absent::Missed,
            met_by: None,
            signals: SignalRules::default(),
            names: Arc::default(),
            acts: false,
        }
    }

    /// The mark with this number, as the program writes it.
    pub(crate) fn marked(&self, number: u32) -> String {
        self.names.get(number as usize).map_or_else(|| number.to_string(), |name| name.to_string())
    }
}

impl WaitRule {
    /// The word with the numbers of two axes.
    fn axes(&self, number: u32) -> String {
        match (number >> 15, number & 0x7fff) {
            (0, second) => format!("{} Q{second}", self.word),
            (first, second) => format!("{} P{first} Q{second}", self.word),
        }
    }
}

/// The rules of a machine, in the order of [`RuleId`].
#[derive(Debug, Clone)]
pub struct WaitRules(Arc<[(RuleId, WaitRule)]>);

impl WaitRules {
    /// The rules with their identifiers, in any order.
    pub fn new(rules: impl IntoIterator<Item = (RuleId, WaitRule)>) -> Self {
        let mut rules: Vec<_> = rules.into_iter().collect();
        rules.sort_by_key(|(id, _)| *id);
        Self(rules.into())
    }

    /// The rule of a wait.
    pub fn of(&self, wait: &Wait) -> Option<&WaitRule> {
        let at = self.0.binary_search_by_key(&wait.rule, |(id, _)| *id).ok()?;
        self.0.get(at).map(|(_, rule)| rule)
    }

    /// Whether the code of a wait does more than wait.
    pub fn acts(&self, wait: &Wait) -> bool {
        self.of(wait).is_some_and(|rule| rule.acts)
    }

    /// Absent partners count as arrived.
    pub(crate) fn counts_absent(&self, wait: &Wait) -> bool {
        self.of(wait).is_some_and(|rule| rule.absent == Absent::Counts)
    }

    /// Whether a channel may send the signal of this wait to itself.
    pub(crate) fn is_to_itself(&self, wait: &Wait) -> bool {
        self.of(wait).is_some_and(|rule| rule.signals.to_itself)
    }

    /// Most signals that the control keeps, if it has a limit.
    pub(crate) fn most_signals(&self) -> Option<usize> {
        self.0.iter().find_map(|(_, rule)| rule.signals.most).map(|most| most as usize)
    }

    /// Channels that wait at a wait of this primitive count as arrived at a wait.
    pub(crate) fn met_by(&self, wait: &Wait) -> Option<Primitive> {
        self.of(wait)?.met_by
    }

    /// The mark as the listing names it: `101` of `M101`, otherwise the word with its number.
    pub fn mark(&self, wait: &Wait) -> String {
        let number = wait.key.number;
        match self.of(wait) {
            None => number.to_string(),
            Some(rule) if rule.numbered && rule.word.len() == 1 && wait.primitive != Primitive::Signal => {
                number.to_string()
            }
            Some(rule) if rule.style == WaitNotation::Axes => rule.axes(number),
            Some(rule) if !rule.names.is_empty() => rule.marked(number),
            Some(rule) if rule.numbered => format!("{}{number}", rule.word),
            Some(rule) => rule.word.to_string(),
        }
    }

    /// The wait as people write it: `M101`, `M101 P12`, `START1`, `WAITM(10,1,2)`.
    pub fn text(&self, wait: &Wait) -> String {
        let Some(rule) = self.of(wait) else { return wait.key.number.to_string() };
        if rule.style == WaitNotation::LineUp {
            let channels: String = wait.parts.iter().map(|channel| channel.to_string()).collect();
            return format!("{}{channels}L{}", rule.word, wait.key.number);
        }
        if rule.style == WaitNotation::Statement {
            let mark = rule.numbered.then(|| rule.marked(wait.key.number));
            let channels = wait.named.into_iter().flat_map(ChannelSet::iter).map(|channel| channel.to_string());
            let arguments: Vec<String> = mark.into_iter().chain(channels).collect();
            return format!("{}({})", rule.word, arguments.join(","));
        }
        if rule.style == WaitNotation::Axes {
            return rule.axes(wait.key.number);
        }
        if rule.style == WaitNotation::Keys {
            let mut out = format!("{} [ID{}", rule.word, wait.key.number);
            for channel in wait.named.into_iter().flat_map(ChannelSet::iter) {
                let _ = write!(out, " CH{channel}");
            }
            out.push(']');
            return out;
        }
        let mut out = rule.word.to_string();
        if rule.numbered {
            let _ = write!(out, "{}", wait.key.number);
        }
        if let Some(named) = wait.named.filter(|_| !rule.list.is_empty()) {
            out.push_str(&rule.list);
            for channel in named.iter() {
                let _ = write!(out, "{}", if channel == 10 { 0 } else { channel });
            }
        }
        out
    }
}

/// A channel that has arrived at a wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaitingChannel {
    /// The wait.
    pub wait: Wait,
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

/// Channels that a wait still needs: `need` of `channels`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MissingChannels {
    /// Who can bring it about.
    pub channels: ChannelSet,
    /// How many of them must; 0: the wait is over.
    pub need: u16,
}

impl MissingChannels {
    /// All of these.
    #[must_use]
    pub fn all(channels: ChannelSet) -> Self {
        Self { channels, need: channels.count() }
    }

    /// Any one of these. Without any the wait never ends.
    #[must_use]
    pub fn any(channels: ChannelSet) -> Self {
        Self { channels, need: 1 }
    }

    /// Whether no channel is missing.
    #[must_use]
    pub fn is_none(self) -> bool {
        self.need == 0
    }

    /// Enough of these channels are missing ones.
    #[must_use]
    pub fn is_met_by(self, able: ChannelSet) -> bool {
        self.channels.and(able).count() >= self.need
    }
}

/// Where all channels are: at which wait, or at their end.
#[derive(Debug, Clone)]
pub struct ChannelPlaces {
    channels: Channels,
    waiting: Vec<Option<WaitingChannel>>,
    finished: Vec<Option<Finish>>,
    /// Channels without a running program, which others may start.
    idle: ChannelSet,
    /// The wait that each channel has passed last, and when it continued.
    passed: Vec<Option<(WaitingChannel, i64)>>,
}

impl ChannelPlaces {
    /// No channel waits yet.
    #[must_use]
    pub fn new(channels: Channels) -> Self {
        let count = channels.count();
        let (waiting, finished, passed) = (vec![None; count], vec![None; count], vec![None; count]);
        Self { channels, waiting, finished, idle: ChannelSet::default(), passed }
    }

    /// The wait of a channel.
    pub fn at(&self, channel: u16) -> Option<&WaitingChannel> {
        self.waiting.get(self.channels.index(channel)).and_then(Option::as_ref)
    }

    /// How a channel ended.
    pub fn end(&self, channel: u16) -> Option<Finish> {
        self.finished.get(self.channels.index(channel)).copied().flatten()
    }

    /// Whether the channel ended, or never ran: it brings nothing about any more and no alarm holds it.
    pub fn is_absent(&self, channel: u16) -> bool {
        self.end(channel).is_some_and(|end| matches!(end.how, Terminal::Ended | Terminal::NeverStarted))
    }

    /// Whether the channel executes blocks.
    pub fn runs(&self, channel: u16) -> bool {
        let index = self.channels.index(channel);
        matches!((self.waiting.get(index), self.finished.get(index)), (Some(None), Some(None)))
    }

    /// All channels, ascending.
    pub fn channels(&self) -> impl Iterator<Item = u16> + use<'_> {
        self.channels.numbers().iter().copied()
    }

    /// All that wait, ascending by channel.
    pub fn waiting(&self) -> impl Iterator<Item = &WaitingChannel> {
        self.waiting.iter().flatten()
    }

    /// Records that a channel is at a wait.
    pub(crate) fn stand(&mut self, waiting: WaitingChannel) {
        if let Some(slot) = self.waiting.get_mut(self.channels.index(waiting.tag.channel)) {
            *slot = Some(waiting);
        }
    }

    /// The wait that a channel has passed last, and when it continued, ns.
    pub fn passed(&self, channel: u16) -> Option<&(WaitingChannel, i64)> {
        self.passed.get(self.channels.index(channel)).and_then(Option::as_ref)
    }

    /// A channel continues after a wait at this time.
    pub(crate) fn pass(&mut self, waiting: WaitingChannel, t: i64) {
        if let Some(slot) = self.passed.get_mut(self.channels.index(waiting.tag.channel)) {
            *slot = Some((waiting, t));
        }
    }

    /// A channel waits no longer.
    pub(crate) fn leave(&mut self, channel: u16) -> Option<WaitingChannel> {
        self.waiting.get_mut(self.channels.index(channel)).and_then(Option::take)
    }

    /// Channels without a running program, which others may start.
    pub(crate) fn idle(&self) -> ChannelSet {
        self.idle
    }

    /// A channel that has ended, or never ran, may be started.
    pub(crate) fn rest(&mut self, channel: u16) {
        self.idle = self.idle.with(channel);
    }

    /// An idle channel executes blocks again.
    pub(crate) fn start(&mut self, channel: u16) {
        self.idle = self.idle.without(channel);
        if let Some(slot) = self.finished.get_mut(self.channels.index(channel)) {
            *slot = None;
        }
    }

    /// Records that a channel has ended.
    pub(crate) fn finish(&mut self, channel: u16, finish: Finish) {
        if let Some(slot) = self.finished.get_mut(self.channels.index(channel)) {
            *slot = Some(finish);
        }
    }
}
