//! One channel of the control: its inputs, position and memory.
//!
//! *Invariant:* a part is plain data with methods of its own; none of them knows the kernel.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::ChannelMemory;
use super::alarms::Alarms;
use crate::plausible::Plausible;
use crate::swallowed::Swallowed;
use counterpoint_ports::MemoryShares;
use counterpoint_program::block::Block;

use super::at::ExecutionPoint;
use super::block_tables::BlockTables;
use super::burden::Burden;
use super::context::BlockContext;
use super::emitter::Emitter;
use super::waits::KnownWaits;
use counterpoint_event::Letters;
use counterpoint_event::event::{Kind, RaceWith, Unrecognised};
use counterpoint_event::info::Info;
use counterpoint_fault as diag;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::index::DataRowId;
use counterpoint_ports::files::JobFiles;
use counterpoint_ports::options::JobOptions;
use counterpoint_program::sources::SeenSources;
use counterpoint_program::tape;
use counterpoint_sync::tag::Tag;
use counterpoint_sync::wait::WaitRules;

/// One channel of the control: its inputs, its position, its memory.
pub struct ChannelContext<'a> {
    /// The subject of the run.
    pub env: RunEnvironment<'a>,
    /// Channel, time and block.
    pub at: ExecutionPoint,
    /// The block being processed.
    pub block: Block,
    /// The text of the block, where it differs from its line.
    pub text: BlockText,
    /// The block as macros have changed it.
    pub context: BlockContext,
    /// Machine data that blocks need.
    pub tables: &'a BlockTables,
    /// The code that is acting.
    pub acting: Acting,
    /// The memory of the channel from block to block.
    pub state: ChannelMemory,
    /// Diagnostics and waits so far.
    pub reports: Reports,
    /// Memory and work used up.
    pub burden: Burden,
    /// Sends the events to the log.
    pub emitter: Emitter<'a>,
}

/// Inputs of a run; while the kernel runs, only the component changes.
#[derive(Clone, Copy)]
pub struct RunEnvironment<'a> {
    /// Definition of the control: the checked machine, or the component with which a channel of a composite works.
    pub machine: &'a Machine,
    /// The machine of the job.
    pub whole: &'a Machine,
    /// The description of the job.
    pub info: &'a Info,
    /// The program files, as the channel sees them.
    pub sources: SeenSources<'a>,
    /// The choices of the job.
    pub options: &'a JobOptions,
    /// The files of the job.
    pub files: &'a dyn JobFiles,
    /// Letters of the trace, `None` when there is no trace.
    pub trace: Option<Letters>,
}

/// Text of the block in process.
#[derive(Debug, Default)]
pub struct BlockText {
    /// The text, when it is not the line as it is in the file.
    pub edited: Option<Arc<[u8]>>,
    /// Rules of the tape editor that are on, and the memory of their searches.
    pub tape: (tape::TapeRuleSet, counterpoint_lang::pattern::SearchMemory),
}

/// A value that a code hands over as data.
#[derive(Debug, Clone, Copy)]
pub struct Handed {
    /// As this data.
    pub id: DataId,
    /// The value of the code, with its factor.
    pub raw: f64,
    /// The row of the data table that it passes, if there is one.
    pub row: Option<DataRowId>,
}

/// The code that is acting.
#[derive(Debug, Default)]
pub struct Acting {
    /// Value that the code hands over as data.
    pub as_data: Option<Handed>,
    /// The code was not the active one of its group before.
    pub mode_changed: bool,
}

/// Diagnostics and waits of a channel so far.
#[derive(Debug)]
pub struct Reports {
    /// Diagnostics logged.
    pub diagnostics: u32,
    /// Alarms of the control so far.
    pub alarms: Alarms,
    /// How often numbers with a repeat count were raised.
    pub raised: FxHashMap<u32, u32>,
    /// Waits met so far.
    pub waits: KnownWaits,
    /// Unrecognised text of the diagnostic that is about to be logged.
    pub unrecognised: Option<Box<Unrecognised>>,
    /// The access that the block of the current diagnostic races with.
    pub race: Option<Box<RaceWith>>,
    /// The operator has reset the channel.
    pub reset: bool,
    /// Improbable blocks reported in this program.
    pub plausible: Plausible,
    /// M functions that had no effect in this program.
    pub swallowed: Swallowed,
    /// A code has selected a unit of length since the last event of a block.
    pub unit_named: bool,
}

impl Reports {
    /// Unrecognised text of a diagnostic, unless the machine has given it another text.
    pub fn take_unrecognised(&mut self, number: u32, text: &str) -> Option<Box<Unrecognised>> {
        self.unrecognised.take_if(|about| number == diag::NOT_RECOGNISED.number && about.to_string() == text)
    }

    /// The access that the block of a diagnostic races with.
    pub fn take_race(&mut self, number: u32) -> Option<Box<RaceWith>> {
        self.race.take_if(|_| number == diag::SHARED_RACE.number)
    }
}

impl Reports {
    /// None so far, on a machine with these rules of waits.
    pub fn new(rules: WaitRules) -> Self {
        let (diagnostics, alarms, raised) = (0, Alarms::default(), FxHashMap::default());
        let (waits, unrecognised, race, reset) = (KnownWaits::new(rules), None, None, false);
        let (plausible, swallowed) = (Plausible::default(), Swallowed::default());
        let unit_named = false;
        Self { diagnostics, alarms, raised, waits, unrecognised, race, reset, plausible, swallowed, unit_named }
    }
}

/// The time of the channel, and its events.
impl ChannelContext<'_> {
    /// This channel's current tag, at rest.
    pub fn tag(&mut self) -> Tag {
        self.come_to_rest();
        self.at.tag()
    }

    /// The known time, ns; the final time may be later while moves are not timed.
    #[inline(always)]
    pub fn now(&self) -> i64 {
        self.at.clock + self.emitter.late()
    }

    /// Advances the clock by something other than a move at feed: the path stops before it.
    pub fn advance(&mut self, ns: i64) {
        if ns > 0 {
            self.emitter.stop_path();
        }
        self.at.advance(ns);
    }

    /// Adds an event of this block at the current time.
    #[inline]
    pub fn emit(&mut self, dur_ns: i64, kind: Kind) {
        self.emitter.emit(&self.at, dur_ns, kind);
    }

    /// Sends the collected events, except those held back.
    pub fn flush(&mut self) {
        let upto = self.emitter.promise(&self.at);
        self.emitter.flush(upto);
    }

    /// Stops the path here: times all moves and sets the clock.
    #[inline(always)]
    pub fn come_to_rest(&mut self) {
        if self.emitter.has_moves() {
            self.rest_now();
        }
    }

    #[cold]
    #[inline(never)]
    fn rest_now(&mut self) {
        let late = self.emitter.rest(&mut self.at, &mut self.state.move_times());
        self.state.place.delay_waiting_moves(late);
    }

    /// Times the moves that can be timed, before a block; sets the clock if no move is left.
    #[inline(always)]
    pub fn keep_pace(&mut self) {
        if self.emitter.has_moves() {
            self.set_pace();
        }
    }

    #[inline(never)]
    fn set_pace(&mut self) {
        let late = self.emitter.keep_pace(&mut self.at, &mut self.state.move_times());
        self.state.place.delay_waiting_moves(late);
    }
}

impl RunEnvironment<'_> {
    /// Position of the channel with this number, counted from 1 in ascending order; 0 is the master.
    pub fn kernel_number(&self, channel: u16) -> u16 {
        let channels = self.machine.channels.iter().zip(1_u16..);
        channels.into_iter().find(|(one, _)| one.number == channel).map_or(0, |(_, at)| at)
    }

    /// The shares of the channels in the memory of the job.
    pub fn shares(&self) -> MemoryShares {
        MemoryShares::of_channels(&self.options.limits, self.machine.channels.len())
    }
}
