//! Shared parts of the tests of this crate.

use counterpoint_event::info::{Info, Room};
use counterpoint_event::{Letters, Unit};

use crate::channels::Channels;
use crate::order::idle::Program;
use crate::wait::{Act, Key, Lasts, Marks, Mismatch, Reaction, Rule, Rules, Send, Set, Wait};
use crate::waits::Waits;
use counterpoint_event::event::Primitive;

/// A job without files and channels: nothing has a name.
pub(crate) fn info() -> Info {
    Info {
        machine: String::new(),
        machine_number: 0,
        machine_revision: 0,
        machine_created: String::new(),
        machine_file: String::new(),
        parameters: String::new(),
        unit: Unit::Mm,
        trace: Letters::default(),
        room: Room { path: 0, bars: 0, waiting: 0 },
        channels: Vec::new(),
        files: Vec::new(),
    }
}

/// Waits of channels 1 to `channels`, of a control that refuses barriers with different numbers.
pub(crate) fn waits(channels: u16) -> Waits {
    let refuses: fn(&Wait, &Wait) -> _ = |wait, other| {
        let barriers = wait.primitive == Primitive::Barrier && other.primitive == Primitive::Barrier;
        (barriers && wait.key != other.key).then_some("different numbers")
    };
    let mismatch = Mismatch { refuses, title: "no pair", reaction: Reaction::Alarm };
    let rule = Rule { mismatch: Some(mismatch), ..Rule::plain("M") };
    Waits::new(Channels::new(1..=channels), Rules::new([rule]), 0)
}

fn key(number: u32) -> Key {
    Key { space: 0, number }
}

/// A wait of channels 1 to `channels`; a count needs two of them.
pub(crate) fn wait(primitive: Primitive, number: u32, channels: u16) -> Wait {
    let need = if primitive == Primitive::Count { 2 } else { 0 };
    Wait { primitive, key: key(number), named: None, parts: Set::up_to(channels), need, rule: 0 }
}

/// A wait for a signal that any of channels 1 to `channels` sends to all channels.
pub(crate) fn listening(number: u32, channels: u16) -> Wait {
    Wait { need: 1, ..wait(Primitive::Signal, number, channels) }
}

/// A program that a channel can be started with.
pub(crate) fn program() -> Program {
    Program { file: 0, lines: (1, 1), name: "P".into() }
}

/// Act of a channel for others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Deed {
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

impl Deed {
    /// With this mark, of channels 1 to `channels`.
    pub(crate) fn act(self, number: u32, channels: u16) -> Act {
        let key = key(number);
        match self {
            Self::Set => Act::Set(key),
            Self::Clear => Act::Clear(key),
            Self::Send => Act::Signal(Send { key, to: Set::up_to(channels), broadcast: false, lasts: Lasts::Each }),
            Self::Call => Act::Signal(Send { key, to: Set::up_to(channels), broadcast: true, lasts: Lasts::Each }),
            Self::Share => Act::Signal(Send { key, to: Set::up_to(channels), broadcast: true, lasts: Lasts::Times(1) }),
            Self::Remove => Act::Remove { range: Marks { space: 0, first: number, last: number }, to: None },
            Self::Free => Act::Release(key),
        }
    }
}
