//! One kernel: runs the program of one channel block by block.
//!
//! Facts: reference control-emulator.md 2 (processing order). Invariants: the clock never goes back; whatever other
//! channels can see or change goes through a shared operation at the kernel's tag; in the steady state a block
//! allocates nothing.

pub(crate) mod block;
pub(crate) mod burden;
pub(crate) mod carried;
pub(crate) mod codes;
pub(crate) mod custom;
pub(crate) mod custom_calls;
pub(crate) mod custom_codes;
pub(crate) mod custom_life;
pub(crate) mod data;
mod definitions;
mod diagnostics;
mod embedded;
pub(crate) mod emit;
pub(crate) mod events;
pub(crate) mod flow;
pub(crate) mod frames;
mod interpreted;
pub(crate) mod leftover;
mod letter_zero;
pub(crate) mod life;
mod macro_call;
pub(crate) mod macros;
mod modal_call;
mod passes;
pub(crate) mod plan;
mod print;
pub(crate) mod read;
mod refusals;
pub(crate) mod remarks;
pub(crate) mod report;
pub(crate) mod scan;
mod search;
pub(crate) mod state;
pub(crate) mod tape;
mod text;
mod unknown;
pub(crate) mod variables;
mod word_calls;

use std::sync::Arc;

use block::Block;
use emit::Emitter;
use flow::Flow;
use plan::Plan;
use state::{Modal, Place, SpindleState};
use variables::ChannelVariables;

use crate::action::sync::Known;
use crate::control::{Control, Progress};
use crate::dialect::Interpreter;
use crate::files::Files;
use crate::log::event::{FileId, Kind, Stop};
use crate::log::info::Info;
use crate::machine::Machine;
use crate::machine::ident::DataId;
use crate::macros::runtime::Runtime;
use crate::multi::coordinator::switch::Port;
use crate::multi::order::Order;
use crate::multi::tag::Tag;
use crate::options::Options;
use crate::trace::Letters;

/// Why a kernel leaves its program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Halt {
    /// An end code or the end of the text.
    End(Option<Stop>),
    /// An alarm of the control.
    Alarm,
    /// An alarm that the machine goes on from: the rest of the block is dropped. It never leaves the block loop.
    Dropped,
    /// The job was stopped.
    Stopped,
    /// It stands at a wait that will never end.
    Blocked,
}

/// What an action returns.
pub(crate) type Acted = Result<(), Halt>;

/// The kernel of one channel.
pub(crate) struct Kernel<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) info: &'a Info,
    pub(crate) options: &'a Options,
    pub(crate) files: &'a dyn Files,
    pub(crate) plan: &'a Plan,
    pub(crate) coordinator: Port<'a>,
    pub(crate) control: &'a Control,
    pub(crate) progress: &'a Progress,
    pub(crate) emitter: Emitter<'a>,
    /// Channel number.
    pub(crate) rank: u16,
    /// Simulated time, ns.
    pub(crate) clock: i64,
    pub(crate) micro: u32,
    /// File and line of the block being processed.
    pub(crate) file: FileId,
    pub(crate) line: u32,
    pub(crate) block: Block,
    /// Value handed over by the code that is acting.
    pub(crate) as_data: Option<(DataId, f64)>,
    /// The code that is acting was not the active one of its group before.
    pub(crate) mode_changed: bool,
    pub(crate) modal: Modal,
    pub(crate) place: Place,
    pub(crate) spindle: SpindleState,
    pub(crate) flow: Flow,
    pub(crate) variables: ChannelVariables,
    /// Pre-processor of another control than the one whose variables are above.
    pub(crate) interpreter: Option<Box<dyn Interpreter>>,
    /// Secondary units are active.
    pub(crate) secondary: bool,
    /// Blocks read.
    pub(crate) blocks: u64,
    /// Consecutive blocks without time.
    pub(crate) idle_blocks: u64,
    /// Diagnostics logged.
    pub(crate) diagnostics: u32,
    /// Memory and work that it has used up.
    pub(crate) burden: burden::Burden,
    /// Alarms of the control so far.
    pub(crate) alarms: report::Alarms,
    /// Waits it has met.
    pub(crate) meetings: Known,
    /// Macros of the machine, if it has any.
    pub(crate) macros: Option<Box<Runtime>>,
    /// Bytes of the line without comments, for the pre-processor.
    pub(crate) stripped: Vec<u8>,
    /// Letters of the trace, `None` when there is no trace.
    pub(crate) trace: Option<Letters>,
    /// How often numbers with a repeat count were raised.
    pub(crate) raised: rustc_hash::FxHashMap<u32, u32>,
    /// Text of the block, when it is not the line as it stands in the file.
    pub(crate) edited: Option<Arc<[u8]>>,
    /// Canned cycle.
    pub(crate) cycle: crate::action::cycle::State,
    /// What is known about circles to come.
    pub(crate) arcs: crate::action::arc::State,
    /// What is known about threads to come.
    pub(crate) threads: Box<crate::action::thread::State>,
    /// What is known about probing moves.
    pub(crate) skip: Box<crate::action::skip::State>,
    /// What actions remember beyond codes, data and positions.
    pub(crate) states: Box<crate::action::states::States>,
    /// Rules of the tape editor that are on, and the memory of their searches.
    pub(crate) tape: (tape::Rules, counterpoint_lang::pattern::Memory),
}

impl Kernel<'_> {
    /// Where the kernel stands in the order of everything.
    pub(crate) fn tag(&self) -> Tag {
        Tag { t: self.clock, micro: self.micro, rank: self.rank }
    }

    /// Which of the machine's channels this is, counted from 1 in ascending order of their numbers; 0 is the master.
    pub(crate) fn kernel_number(&self) -> u16 {
        let channels = self.machine.channels.iter().zip(1_u16..);
        channels.into_iter().find(|(channel, _)| channel.number == self.rank).map_or(0, |(_, at)| at)
    }

    /// Adds an event of this block at the clock.
    #[inline]
    pub(crate) fn emit(&mut self, dur_ns: i64, kind: Kind) {
        let bytes = kind.text_bytes();
        self.emit_as(dur_ns, |slot| *slot = kind);
        if bytes > 0 && self.emitter.carries(bytes) {
            self.emitter.flush(self.tag());
        }
    }

    /// Adds an event whose kind is written where it stays.
    #[inline(always)]
    pub(crate) fn emit_as(&mut self, dur_ns: i64, write: impl FnOnce(&mut Kind)) {
        let (t_ns, micro) = (self.clock, self.micro);
        if let Some(event) = self.emitter.slot(t_ns, micro) {
            (event.t_ns, event.micro, event.dur_ns) = (t_ns, micro, dur_ns);
            (event.channel, event.file, event.line) = (self.rank, self.file, self.line);
            write(&mut event.kind);
        }
    }

    /// Moves the clock on.
    pub(crate) fn advance(&mut self, ns: i64) {
        if ns > 0 {
            self.clock = self.clock.saturating_add(ns);
            self.micro = 0;
            self.idle_blocks = 0;
        }
    }

    /// Nanoseconds of a duration in seconds, rounded once; never negative, never beyond what a job can hold.
    pub(crate) fn ns(seconds: f64) -> i64 {
        const MOST: f64 = 1e18;
        if seconds.is_nan() || seconds <= 0.0 { 0 } else { ((seconds * 1e9).min(MOST) + 0.5) as i64 }
    }

    /// Runs an operation on what the channels share, in tag order.
    ///
    /// # Errors
    /// When the job was stopped before.
    pub(crate) fn shared<R>(&mut self, operation: impl FnOnce(&mut Order) -> R) -> Result<R, Halt> {
        let coordinator = self.coordinator;
        if self.rank == 0 {
            // The master works while no channel does.
            return Ok(coordinator.unordered(operation));
        }
        if self.emitter.is_late(self.clock) {
            self.settle()?;
        }
        self.control.disturb(self.rank);
        let tag = self.tag();
        let mut turn =
            coordinator.enter(tag, &mut self.emitter, |emitter| emitter.flush(tag)).map_err(|_| Halt::Stopped)?;
        let result = operation(&mut turn);
        drop(turn);
        self.control.disturb(self.rank);
        Ok(result)
    }
}
