//! Shared parts of the tests of this crate.

use counterpoint_event::event::Primitive;
use counterpoint_event::info::{Info, ResultBudget};
use counterpoint_event::{Letters, MachineUnit};

use crate::channels::Channels;
use crate::order::idle::StartableProgram;
use crate::wait::{
    ChannelSet, Lasts, MarkRange, MarkSpace, MismatchCheck, Reaction, RuleId, Send, Wait, WaitMark, WaitOp, WaitRule,
    WaitRules,
};
use crate::waits::JobWaits;

/// A job without files and channels: nothing has a name.
pub(crate) fn info() -> Info {
    Info {
        machine: String::new(),
        machine_number: 0,
        machine_revision: 0,
        machine_created: String::new(),
        machine_file: String::new(),
        parameters: String::new(),
        unit: MachineUnit::Mm,
        trace: Letters::default(),
        room: ResultBudget { path: 0, bars: 0, waiting: 0 },
        channels: Vec::new(),
        files: Vec::new(),
    }
}

/// Waits of channels 1 to `channels`, of a control that refuses barriers with different numbers.
pub(crate) fn waits(channels: u16) -> JobWaits {
    let refuses: fn(&Wait, &Wait) -> _ = |wait, other| {
        let barriers = wait.primitive == Primitive::Barrier && other.primitive == Primitive::Barrier;
        (barriers && wait.key != other.key).then_some("different numbers")
    };
    let mismatch = MismatchCheck { refuses, title: "no pair", reaction: Reaction::Alarm };
    let rule = WaitRule { mismatch: Some(mismatch), ..WaitRule::plain("M") };
    JobWaits::new(Channels::new(1..=channels), WaitRules::new([(RuleId::Start, rule)]), 0)
}

fn key(number: u32) -> WaitMark {
    WaitMark { space: MarkSpace::Statements, number }
}

/// A wait of channels 1 to `channels`; a count needs two of them.
pub(crate) fn wait(primitive: Primitive, number: u32, channels: u16) -> Wait {
    let need = if primitive == Primitive::Count { 2 } else { 0 };
    Wait { primitive, key: key(number), named: None, parts: ChannelSet::up_to(channels), need, rule: RuleId::Start }
}

/// A wait for a signal that any of channels 1 to `channels` sends to all channels.
pub(crate) fn listening(number: u32, channels: u16) -> Wait {
    Wait { need: 1, ..wait(Primitive::Signal, number, channels) }
}

/// A program that a channel can be started with.
pub(crate) fn program() -> StartableProgram {
    StartableProgram { file: 0, lines: (1, 1), name: "P".into() }
}

/// Act of a channel for others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ScriptedWaitOp {
    /// Sets its flag.
    Set,
    /// Deletes its flag.
    Clear,
    /// Sends a signal of its own to all.
    Send,
    /// Sends a signal to all channels, of which each receiver gets one.
    Call,
    /// Sends a signal to all channels that one wait can use.
    Share,
    /// Removes a signal to all channels.
    Remove,
    /// Gives a lease back.
    Free,
}

impl ScriptedWaitOp {
    /// With this mark, of channels 1 to `channels`.
    pub(crate) fn act(self, number: u32, channels: u16) -> WaitOp {
        let key = key(number);
        match self {
            Self::Set => WaitOp::Set(key),
            Self::Clear => WaitOp::Clear(key),
            Self::Send => {
                WaitOp::Signal(Send { key, to: ChannelSet::up_to(channels), broadcast: false, lasts: Lasts::Each })
            }
            Self::Call => {
                WaitOp::Signal(Send { key, to: ChannelSet::up_to(channels), broadcast: true, lasts: Lasts::Each })
            }
            Self::Share => {
                WaitOp::Signal(Send { key, to: ChannelSet::up_to(channels), broadcast: true, lasts: Lasts::Times(1) })
            }
            Self::Remove => WaitOp::Remove {
                range: MarkRange { space: MarkSpace::Statements, first: number, last: number },
                to: None,
            },
            Self::Free => WaitOp::Release(key),
        }
    }
}
