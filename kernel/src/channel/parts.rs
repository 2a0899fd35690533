//! The parts of a kernel: what it is given, where it is, what it remembers.
//!
//! Invariant: a part is plain data with methods of its own; none of them knows the kernel.

use std::sync::Arc;

use counterpoint_event::Letters;
use rustc_hash::FxHashMap;

use super::emit::Emitter;
use super::plan::Plan;
use super::state::{Modal, Place, SpindleState};
use super::variables::ChannelVariables;
use super::{report, tape};
use crate::action::states::States;
use crate::action::sync::Known;
use crate::action::{arc, cycle, skip, thread};
use crate::control::{Control, Progress};
use crate::dialect::Interpreter;
use crate::files::Files;
use crate::log::event::FileId;
use crate::log::info::Info;
use crate::machine::Machine;
use crate::machine::ident::DataId;
use crate::machine::model::Channel as MachineChannel;
use crate::mcd::sources::Sources;
use crate::multi::coordinator::switch::Port;
use crate::multi::tag::Tag;
use crate::options::Options;

/// What a run is about; it does not change while the kernel runs.
#[derive(Clone, Copy)]
pub(crate) struct Environment<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) info: &'a Info,
    /// The program files.
    pub(crate) sources: &'a Sources,
    pub(crate) options: &'a Options,
    pub(crate) files: &'a dyn Files,
    /// Letters of the trace, `None` when there is no trace.
    pub(crate) trace: Option<Letters>,
}

/// The ways out of a kernel: to the other kernels, to whoever started the job, to the log.
pub(crate) struct Ports<'a> {
    pub(crate) coordinator: Port<'a>,
    pub(crate) control: &'a Control,
    pub(crate) progress: &'a Progress,
    pub(crate) emitter: Emitter<'a>,
}

/// Where a kernel is: channel, time, and the block in process.
#[derive(Debug, Default)]
pub(crate) struct At {
    /// Number of the channel.
    pub(crate) channel: u16,
    /// Simulated time, ns.
    pub(crate) clock: i64,
    /// Order of shared operations at the same time.
    pub(crate) micro: u32,
    /// File of the block being processed.
    pub(crate) file: FileId,
    /// Line of the block being processed.
    pub(crate) line: u32,
    /// Blocks read.
    pub(crate) blocks: u64,
    /// Consecutive blocks without time.
    pub(crate) idle_blocks: u64,
}

impl At {
    /// The tag of what the kernel does now.
    pub(crate) fn tag(&self) -> Tag {
        Tag { t: self.clock, micro: self.micro, rank: self.channel }
    }

    /// Moves the clock on.
    pub(crate) fn advance(&mut self, ns: i64) {
        if ns > 0 {
            self.clock = self.clock.saturating_add(ns);
            self.micro = 0;
            self.idle_blocks = 0;
        }
    }
}

/// Text of the block in process.
#[derive(Debug, Default)]
pub(crate) struct BlockText {
    /// The text, when it is not the line as it stands in the file.
    pub(crate) edited: Option<Arc<[u8]>>,
    /// Bytes of the line without comments, for the pre-processor.
    pub(crate) stripped: Vec<u8>,
    /// Rules of the tape editor that are on, and the memory of their searches.
    pub(crate) tape: (tape::Rules, counterpoint_lang::pattern::Memory),
}

/// The code that is acting.
#[derive(Debug, Default)]
pub(crate) struct Acting {
    /// Value that the code hands over as data.
    pub(crate) as_data: Option<(DataId, f64)>,
    /// The code was not the active one of its group before.
    pub(crate) mode_changed: bool,
}

/// What a channel remembers from block to block.
#[derive(Debug)]
pub(crate) struct State {
    /// Modal codes and data.
    pub(crate) modal: Modal,
    /// Axes, positions and offsets.
    pub(crate) place: Place,
    /// Spindle of the channel.
    pub(crate) spindle: SpindleState,
    /// Secondary units are active.
    pub(crate) secondary: bool,
    /// Canned cycle.
    pub(crate) cycle: cycle::State,
    /// What is known about circles to come.
    pub(crate) arcs: arc::State,
    /// What is known about threads to come.
    pub(crate) threads: Box<thread::State>,
    /// What is known about probing moves.
    pub(crate) skip: Box<skip::State>,
    /// What other actions remember.
    pub(crate) others: Box<States>,
}

impl State {
    /// The state of a channel at the start of its program.
    pub(crate) fn new(machine: &Machine, channel: &MachineChannel) -> Self {
        let index = channel.spindle.and_then(|number| machine.spindles.iter().position(|s| s.number == number));
        let shared = index.is_some_and(|index| crate::action::spindles::is_shared(machine, index));
        Self {
            modal: Modal::new(machine),
            place: Place::new(machine, channel),
            spindle: SpindleState { index, shared, ..SpindleState::default() },
            secondary: false,
            cycle: cycle::State::new(machine),
            arcs: arc::State::default(),
            threads: Box::new(thread::State::new(machine)),
            skip: Box::default(),
            others: Box::new(States::new(machine, channel)),
        }
    }
}

/// Diagnostics and waits of a channel so far.
#[derive(Debug, Default)]
pub(crate) struct Reports {
    /// Diagnostics logged.
    pub(crate) diagnostics: u32,
    /// Alarms of the control so far.
    pub(crate) alarms: report::Alarms,
    /// How often numbers with a repeat count were raised.
    pub(crate) raised: FxHashMap<u32, u32>,
    /// Waits met so far.
    pub(crate) waits: Known,
}

/// Pre-processor of a channel.
#[derive(Default)]
pub(crate) struct DialectState {
    /// Variables of the custom macros.
    pub(crate) variables: ChannelVariables,
    /// Interpreter of another control than the one whose variables are above.
    pub(crate) interpreter: Option<Box<dyn Interpreter>>,
}

/// What a kernel is given when it is made.
pub(crate) struct Setup<'a> {
    pub(crate) env: Environment<'a>,
    pub(crate) ports: Ports<'a>,
    pub(crate) plan: &'a Plan,
}
