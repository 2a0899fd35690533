//! The times of one channel.
//!
//! *Invariant:* the counted times add up to the end of the channel; only its last event can be cut by a stop.

use super::ChannelState;
use crate::tools::ToolTimes;
use counterpoint_event::event::WorkClass;
use counterpoint_event::event::{Event, Phase};

/// Times of one channel while the log goes by.
#[derive(Debug, Default)]
pub struct TimeTally {
    end: Option<(ChannelState, i64)>,
    /// Its program has begun.
    begun: bool,
    /// Blocks read, those of resident programs too.
    read: u64,
    /// Blocks of resident programs.
    resident: u64,
    /// Time of feed moves, ns.
    pub feed_ns: i64,
    /// Time of rapid moves, ns.
    pub rapid_ns: i64,
    /// Time of dwells, tools and functions, ns.
    pub misc_ns: i64,
    /// Time spent waiting, ns.
    pub wait_ns: i64,
    /// Class and end of the last event that took time: the only one that a stop can cut.
    last: Option<(WorkClass, i64)>,
}

impl TimeTally {
    /// The times so far, as those of a tool start and end with them.
    pub fn times(&self) -> ToolTimes {
        let Self { feed_ns, rapid_ns, misc_ns, wait_ns, .. } = *self;
        ToolTimes { feed_ns, rapid_ns, misc_ns, wait_ns }
    }

    /// Blocks of the user's programs.
    pub fn blocks(&self) -> u64 {
        self.read.saturating_sub(self.resident)
    }

    /// A block with its number. `resident`: the user's program has called the program that it belongs to.
    #[inline]
    pub fn block(&mut self, number: u64, resident: bool) {
        self.read = self.read.max(number);
        self.resident += u64::from(resident);
    }

    /// Adds time to its kind of work.
    pub fn add(&mut self, work: WorkClass, ns: i64) {
        let sum = match work {
            WorkClass::Feed => &mut self.feed_ns,
            WorkClass::Rapid => &mut self.rapid_ns,
            WorkClass::Wait => &mut self.wait_ns,
            WorkClass::Tool | WorkClass::Dwell | WorkClass::Misc => &mut self.misc_ns,
        };
        *sum = sum.saturating_add(ns);
    }

    /// An event that took time.
    #[inline]
    pub fn work(&mut self, work: WorkClass, event: &Event) {
        self.add(work, event.dur_ns);
        self.last = Some((work, event.t_ns.saturating_add(event.dur_ns)));
    }

    /// A phase in the life of its kernel.
    pub fn life(&mut self, phase: Phase, t_ns: i64) {
        self.begun |= phase == Phase::ProgramStart;
        if let Some(state) = terminal(phase) {
            self.end = Some((state, t_ns));
        } else if let Some((_, before)) = self.end.take_if(|_| phase == Phase::ProgramStart) {
            // Started again: the time in between was idle.
            self.add(WorkClass::Wait, t_ns.saturating_sub(before));
        }
    }

    /// Whether its kernel has had a program before.
    pub fn has_run(&self) -> bool {
        self.end.is_some_and(|(state, _)| state != ChannelState::NotStarted)
    }

    /// Whether its program has ended or is stopped by an alarm.
    pub fn ended(&self) -> bool {
        matches!(self.end, Some((ChannelState::Ended | ChannelState::Alarmed, _)))
    }

    /// Whether a program has begun and, by the state of its channel, did not reach its end.
    pub fn is_cut_short(&self, state: ChannelState) -> bool {
        self.begun && matches!(state, ChannelState::Alarmed | ChannelState::Blocked | ChannelState::Stopped)
    }

    /// How the channel ended when the log ends at `end_ns`; `since_ns`: it waits since then.
    pub fn close(&mut self, since_ns: Option<i64>, end_ns: i64, cancelled: bool) -> (ChannelState, i64) {
        let (state, end_ns) = match (self.end, since_ns) {
            (Some((ChannelState::Blocked, _)), Some(since)) => return (ChannelState::Blocked, since),
            (Some(end), _) => end,
            (None, Some(since)) if !cancelled => return (ChannelState::Blocked, since),
            (None, _) => (ChannelState::Stopped, end_ns),
        };
        if let Some((work, over)) = self.last.filter(|(_, until)| *until > end_ns) {
            self.add(work, end_ns - over);
        }
        if let Some(since) = since_ns {
            self.add(WorkClass::Wait, (end_ns - since).max(0));
        }
        (state, end_ns)
    }
}

fn terminal(phase: Phase) -> Option<ChannelState> {
    match phase {
        Phase::ProgramEnd => Some(ChannelState::Ended),
        Phase::Alarmed => Some(ChannelState::Alarmed),
        Phase::NotStarted => Some(ChannelState::NotStarted),
        Phase::Stopped => Some(ChannelState::Stopped),
        Phase::Blocked => Some(ChannelState::Blocked),
        Phase::MachineStart | Phase::ProgramStart | Phase::MachineEnd => None,
    }
}
