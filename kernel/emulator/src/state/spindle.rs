//! Spindles of a channel: the one in work, and those that it can put into work.
//!
//! *Invariant:* a spindle that several channels command has no state of its own here but a copy.

use super::channel::Channel;
use super::modal::group;
use counterpoint_motion::surface_speed::Speed;

use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::model::{Channel as MachineChannel, Machine};
use counterpoint_sync::shared::Command;

/// Spindle of the channel: its own state, or a copy of the shared one.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SpindleState {
    /// Index in the machine's spindle list, `None` = channel without spindle.
    pub(crate) index: Option<usize>,
    /// Other channels command it too.
    pub(crate) shared: bool,
    /// Last known command.
    pub(crate) command: Command,
    /// Speed now when another channel drives it.
    pub(crate) now: f64,
}

/// How the spindle turns during a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Turning {
    /// Steady rev/min.
    Fixed(f64),
    /// By this channel's own X.
    Surface(Speed),
}

/// Spindles of one channel by index of the machine's list, and what they are in work for.
#[derive(Debug, Default)]
pub(crate) struct Spindles {
    pub(crate) front: Option<usize>,
    pub(crate) rear: Option<usize>,
    pub(crate) mill: Option<usize>,
    /// Commands of spindles that are not in work.
    pub(crate) kept: Vec<Command>,
    /// Milling mode.
    pub(crate) milling: bool,
    /// Head that drives constant surface speed, when a code has said so.
    pub(crate) driver: Option<u16>,
    /// A speed that waits for the next spindle code.
    pub(crate) waiting: Option<f64>,
}

impl Spindles {
    pub(crate) fn new(machine: &Machine, channel: &MachineChannel) -> Self {
        let index = |number: Option<u16>| index_of(machine, number?);
        Self {
            front: index(channel.spindle),
            rear: index(channel.rear),
            mill: index(channel.milling),
            kept: vec![Command::default(); machine.spindles.len()],
            milling: false,
            driver: None,
            waiting: None,
        }
    }
}

pub(crate) fn index_of(machine: &Machine, number: u16) -> Option<usize> {
    machine.spindles.iter().position(|spindle| spindle.number == number)
}

/// The machine commands this spindle by codes of its number.
fn has_codes(machine: &Machine, number: u16) -> bool {
    machine.codes.iter().any(|row| {
        row.enable && matches!(row.id.kind(), CodeKind::Spindle { number: of, .. } if of == number && of > 0)
    })
}

/// More than one channel can command the spindle.
pub(crate) fn is_shared(machine: &Machine, index: usize) -> bool {
    let Some(number) = machine.spindles.get(index).map(|spindle| spindle.number) else { return false };
    let uses = |channel: &&MachineChannel| [channel.spindle, channel.rear, channel.milling].contains(&Some(number));
    let users = machine.channels.iter().filter(uses).count();
    users > 1 || machine.channels.len() > 1 && has_codes(machine, number)
}

impl Channel<'_> {
    /// The spindle of codes without a number: not a milling one that has codes of its own.
    pub(crate) fn plain_spindle(&self) -> Option<usize> {
        let spindles = &self.state.others.spindles;
        let mill = spindles.mill.filter(|_| spindles.milling && self.milling_code() == 0);
        mill.or_else(|| self.turning_spindle())
    }

    /// The spindle that turns the part.
    pub(crate) fn turning_spindle(&self) -> Option<usize> {
        let spindles = &self.state.others.spindles;
        let rear = spindles.rear.filter(|_| self.state.modal.code(group::SPINDLES) == Some(codes::SPINDLE_REAR));
        rear.or(spindles.front)
    }

    /// The spindle in work.
    pub(crate) fn working_spindle(&self) -> Option<usize> {
        let spindles = &self.state.others.spindles;
        spindles.mill.filter(|_| spindles.milling).or_else(|| self.turning_spindle())
    }

    pub(crate) fn number_in_codes(&self, index: Option<usize>) -> u16 {
        let number = index.and_then(|index| self.env.machine.spindles.get(index)).map_or(0, |spindle| spindle.number);
        if has_codes(self.env.machine, number) { number } else { 0 }
    }

    /// `$STID`
    pub(crate) fn turning_code(&self) -> u16 {
        self.number_in_codes(self.turning_spindle())
    }

    /// `$SMID`
    pub(crate) fn milling_code(&self) -> u16 {
        self.number_in_codes(self.state.others.spindles.mill)
    }

    /// Puts into work what the codes say.
    pub(crate) fn follow_spindle(&mut self) {
        let wanted = self.working_spindle();
        self.select_spindle(wanted);
    }

    /// Puts a spindle into work.
    pub(crate) fn select_spindle(&mut self, index: Option<usize>) {
        if index == self.state.spindle.index {
            return;
        }
        let old = self.state.spindle;
        let kept = &mut self.state.others.spindles.kept;
        if let Some(slot) = old.index.filter(|_| !old.shared).and_then(|at| kept.get_mut(at)) {
            *slot = old.command;
        }
        let command = index.and_then(|at| kept.get(at)).copied().unwrap_or_default();
        let shared = index.is_some_and(|at| is_shared(self.env.machine, at));
        self.state.spindle = SpindleState { index, shared, command, now: 0.0 };
    }
}
