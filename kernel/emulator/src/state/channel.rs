//! One channel of the control: its inputs, position and memory.
//!
//! *Invariant:* a part is plain data with methods of its own; none of them knows the kernel.

use counterpoint_event::SourcePlace;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::State;
use super::alarms::Alarms;
use crate::state::plausible::Plausible;
use crate::state::swallowed::Swallowed;
use counterpoint_ports::Shares;
use counterpoint_program::block::Block;

use super::burden::Burden;
use super::cutter::Held;
use super::pace::Pace;
use super::waits::KnownWaits;
use counterpoint_event::Letters;
use counterpoint_event::event::{FileId, RaceWith, Unrecognised};
use counterpoint_event::info::Info;
use counterpoint_fault as diag;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::index::DataRowId;
use counterpoint_ports::files::Files;
use counterpoint_ports::options::Options;
use counterpoint_program::sources::SeenSources;
use counterpoint_program::tape;
use counterpoint_sync::tag::Tag;
use counterpoint_sync::wait::Rules;

/// One channel of the control: its inputs, its position, its memory.
pub struct Channel<'a> {
    /// The subject of the run.
    pub env: Environment<'a>,
    /// Channel, time and block.
    pub at: At,
    /// The block being processed.
    pub(crate) block: Block,
    pub(crate) text: BlockText,
    pub(crate) acting: Acting,
    pub(crate) state: State,
    pub(crate) reports: Reports,
    /// Memory and work used up.
    pub(crate) burden: Burden,
    /// The effects that compensation holds back.
    pub(crate) held: Option<Held>,
    /// Moves at feed whose times later ones decide; none where speeds change at once.
    pub(crate) pace: Option<Box<Pace>>,
}

/// Inputs of a run; while the kernel runs, only the component changes.
#[derive(Clone, Copy)]
pub struct Environment<'a> {
    /// Definition of the control: the checked machine, or the component with which a channel of a composite works.
    pub machine: &'a Machine,
    /// The machine of the job.
    pub whole: &'a Machine,
    /// The description of the job.
    pub info: &'a Info,
    /// The program files, as the channel sees them.
    pub sources: SeenSources<'a>,
    /// The choices of the job.
    pub options: &'a Options,
    /// The files of the job.
    pub files: &'a dyn Files,
    /// Letters of the trace, `None` when there is no trace.
    pub trace: Option<Letters>,
}

/// Where a kernel is: channel, time, and the block in process.
#[derive(Debug, Default)]
pub struct At {
    /// Number of the channel.
    pub channel: u16,
    /// Simulated time, ns.
    pub clock: i64,
    /// Order of shared operations at the same time.
    pub micro: u32,
    /// File of the block being processed.
    pub(crate) file: FileId,
    /// Line of the block being processed.
    pub(crate) line: u32,
    /// Where the user's program called the resident program of the block; none in the user's own programs.
    pub(crate) caller: SourcePlace,
    /// Blocks read.
    pub(crate) blocks: u64,
    /// Blocks of the user's programs among them.
    pub(crate) user_blocks: u64,
    /// Blocks among them that the control has made of a cycle; the block that calls it stands for them in events.
    pub(crate) made_blocks: u64,
    /// Consecutive blocks without time.
    pub(crate) idle_blocks: u64,
    /// The innermost place in the user's programs of the last block that took time.
    pub(crate) timed: SourcePlace,
}

/// Where a block is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BlockPlace {
    pub(crate) file: FileId,
    pub(crate) line: u32,
    /// Where the user's program called the resident program of the block.
    pub(crate) caller: SourcePlace,
}

impl At {
    /// The innermost place of the block in the programs of the user.
    pub(crate) fn user_place(&self) -> SourcePlace {
        self.caller.or(SourcePlace::new(self.file, self.line))
    }

    /// Where the block is, to come back to it.
    pub(crate) fn block_place(&self) -> BlockPlace {
        BlockPlace { file: self.file, line: self.line, caller: self.caller }
    }

    /// Goes to a block.
    #[inline(always)]
    pub(crate) fn go_to(&mut self, place: BlockPlace) {
        (self.file, self.line, self.caller) = (place.file, place.line, place.caller);
    }

    /// The tag of the kernel's current operation.
    pub(crate) fn tag(&self) -> Tag {
        Tag { t: self.clock, micro: self.micro, channel: self.channel }
    }

    /// Moves the clock on.
    pub(crate) fn advance(&mut self, ns: i64) {
        if ns > 0 {
            self.clock = self.clock.saturating_add(ns);
            self.micro = 0;
            self.idle_blocks = 0;
            self.timed = self.user_place();
        }
    }
}

/// Text of the block in process.
#[derive(Debug, Default)]
pub(crate) struct BlockText {
    /// The text, when it is not the line as it is in the file.
    pub(crate) edited: Option<Arc<[u8]>>,
    /// Rules of the tape editor that are on, and the memory of their searches.
    pub(crate) tape: (tape::Rules, counterpoint_lang::pattern::Memory),
}

/// A value that a code hands over as data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Handed {
    /// As this data.
    pub(crate) id: DataId,
    /// The value of the code, with its factor.
    pub(crate) raw: f64,
    /// The row of the data table that it passes, if there is one.
    pub(crate) row: Option<DataRowId>,
}

/// The code that is acting.
#[derive(Debug, Default)]
pub(crate) struct Acting {
    /// Value that the code hands over as data.
    pub(crate) as_data: Option<Handed>,
    /// The code was not the active one of its group before.
    pub(crate) mode_changed: bool,
}

/// Diagnostics and waits of a channel so far.
#[derive(Debug)]
pub(crate) struct Reports {
    /// Diagnostics logged.
    pub(crate) diagnostics: u32,
    /// Alarms of the control so far.
    pub(crate) alarms: Alarms,
    /// How often numbers with a repeat count were raised.
    pub(crate) raised: FxHashMap<u32, u32>,
    /// Waits met so far.
    pub(crate) waits: KnownWaits,
    /// Unrecognised text of the diagnostic that is about to be logged.
    pub(crate) unrecognised: Option<Box<Unrecognised>>,
    /// The access that the block of the current diagnostic races with.
    pub(crate) race: Option<Box<RaceWith>>,
    /// The operator has reset the channel.
    pub(crate) reset: bool,
    /// Improbable blocks reported in this program.
    pub(crate) plausible: Plausible,
    /// M functions that had no effect in this program.
    pub(crate) swallowed: Swallowed,
    /// A code of the unit of length has acted since the last event of a block.
    pub(crate) unit_named: bool,
}

impl Reports {
    /// Unrecognised text of a diagnostic, unless the machine has given it another text.
    pub(crate) fn take_unrecognised(&mut self, number: u32, text: &str) -> Option<Box<Unrecognised>> {
        self.unrecognised.take_if(|about| number == diag::NOT_RECOGNISED.number && about.to_string() == text)
    }

    /// The access that the block of a diagnostic races with.
    pub(crate) fn take_race(&mut self, number: u32) -> Option<Box<RaceWith>> {
        self.race.take_if(|_| number == diag::SHARED_RACE.number)
    }
}

impl Reports {
    /// None so far, on a machine with these rules of waits.
    pub(crate) fn new(rules: Rules) -> Self {
        let (diagnostics, alarms, raised) = (0, Alarms::default(), FxHashMap::default());
        let (waits, unrecognised, race, reset) = (KnownWaits::new(rules), None, None, false);
        let (plausible, swallowed) = (Plausible::default(), Swallowed::default());
        let unit_named = false;
        Self { diagnostics, alarms, raised, waits, unrecognised, race, reset, plausible, swallowed, unit_named }
    }
}

impl Channel<'_> {
    /// Advances the clock by something other than a move at feed: the path stops before it.
    pub(crate) fn advance(&mut self, ns: i64) {
        if ns > 0 {
            self.stop_path();
        }
        self.at.advance(ns);
    }

    /// Which of the machine's channels this is, counted from 1 in ascending order of their numbers; 0 is the master.
    pub(crate) fn kernel_number(&self) -> u16 {
        let channels = self.env.machine.channels.iter().zip(1_u16..);
        channels.into_iter().find(|(channel, _)| channel.number == self.at.channel).map_or(0, |(_, at)| at)
    }

    /// The shares of the memory of the job.
    pub(crate) fn shares(&self) -> Shares {
        Shares::of_channels(&self.env.options.limits, self.env.machine.channels.len())
    }

    /// Whether a free data word of one of these registers is in the block.
    pub(crate) fn has_any(&self, registers: u128) -> bool {
        self.block.present & registers != 0
    }
}

/// Nanoseconds of a duration in seconds, rounded once; never negative, never beyond the maximum duration of a job.
pub(crate) fn nanoseconds(seconds: f64) -> i64 {
    const MOST: f64 = 1e18;
    if seconds.is_nan() || seconds <= 0.0 { 0 } else { ((seconds * 1e9).min(MOST) + 0.5) as i64 }
}
