//! The points at which the macros of a machine take part in the work of a kernel.
//!
//! *Invariant:* the kernel knows its hooks by these points only. A machine without macros has none (`Plan::hooks` is
//! `None`): its blocks go the same way and pay one comparison at each point. Facts: reference control-emulator.md 2.

use counterpoint_fault::{Acted, Halt};

use super::Kernel;
use super::flow::CallRecord;
use counterpoint_event::event::{FileId, Motion};
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_program::block::PendingCode;
use counterpoint_program::block::RetrievedValue;
use counterpoint_program::shape::ProgramRange;

/// Where the codes and data of a block come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BlockOrigin {
    /// Its text.
    Text,
    /// EXEC with identifiers.
    Items,
}

/// Treatment of a block after it has been edited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BlockTreatment {
    /// Nothing is left of it.
    Dropped,
    /// It is split into words without the pre-processor.
    Plain,
    /// It goes to the pre-processor.
    Preprocess,
}

/// Where a called subprogram is, if anywhere.
pub(crate) type Found = Option<(FileId, ProgramRange)>;

/// All points.
pub struct HookPoints {
    pub(crate) block: BlockHooks,
    pub(crate) codes: CodeHooks,
    pub(crate) program: ProgramHooks,
    /// Executes a motion and its duration in seconds.
    pub(crate) motion: fn(&mut Kernel<'_>, f64, &Motion) -> Acted,
    /// Writes a motion and its duration in seconds down for the tables of tools and operations.
    pub(crate) moved: fn(&mut Kernel<'_>, f64, &Motion),
}

/// Around the text of a block.
pub(crate) struct BlockHooks {
    /// Processes a block that EXEC/NEXT left, in place of reading one; none if nothing was left.
    pub(crate) next: fn(&mut Kernel<'_>) -> Option<Acted>,
    /// A line of a file becomes the block.
    pub(crate) begin: fn(&mut Kernel<'_>),
    /// Block delete around embedded code, embedded code, Pre-Processor Startup.
    pub(crate) edit: fn(&mut Kernel<'_>) -> Result<BlockTreatment, Halt>,
    /// Pre-Processor Shutdown.
    pub(crate) preprocessed: fn(&mut Kernel<'_>) -> Acted,
    /// Pre-Processor Shutdown for words that the pre-processor made.
    pub(crate) made: fn(&mut Kernel<'_>) -> Acted,
    /// Whether a macro may read the words that the pre-processor leaves of the block.
    pub(crate) reads_left: fn(&Kernel<'_>) -> bool,
    /// Comments and messages of a statement, before it is executed.
    pub(crate) statement: fn(&mut Kernel<'_>, &[u8]) -> Acted,
    /// Pre-Processor Shutdown after a statement that left no words.
    pub(crate) consumed: fn(&mut Kernel<'_>) -> Acted,
    /// Embedded code and Block Startup before the codes; false if the block is dropped.
    pub(crate) words: fn(&mut Kernel<'_>) -> Result<bool, Halt>,
    /// Comments and messages, before the codes.
    pub(crate) remarks: fn(&mut Kernel<'_>) -> Acted,
}

/// Around the codes and data of a block.
pub(crate) struct CodeHooks {
    /// Sequence numbers and data of the block that macros can ask for.
    pub(crate) begin: fn(&mut Kernel<'_>, BlockOrigin),
    /// Codes that data fire.
    pub(crate) implied: fn(&mut Kernel<'_>),
    /// Lets a code act: its macro, otherwise its action.
    pub(crate) act: fn(&mut Kernel<'_>, PendingCode, CodeId) -> Acted,
    /// A code has acted.
    pub(crate) acted: fn(&mut Kernel<'_>) -> Acted,
    /// Takes data off the block.
    pub(crate) take: fn(&mut Kernel<'_>, DataId) -> Option<RetrievedValue>,
    /// Block Shutdown.
    pub(crate) end: fn(&mut Kernel<'_>, BlockOrigin) -> Acted,
    /// Data that macros added and nothing took.
    pub(crate) dropped: fn(&mut Kernel<'_>) -> Acted,
}

/// Around programs, calls and variables.
pub(crate) struct ProgramHooks {
    /// Declaration and Program Startup.
    pub(crate) start: fn(&mut Kernel<'_>) -> Acted,
    /// Subprogram Startup for the first pass, at a level: none if the call is ignored, otherwise where the subprogram
    /// is.
    pub(crate) call: fn(&mut Kernel<'_>, &CallRecord, Found) -> Result<Option<Found>, Halt>,
    /// Subprogram Shutdown and Startup between two passes.
    pub(crate) next_pass: fn(&mut Kernel<'_>) -> Acted,
    /// Subprogram Shutdown after the last pass.
    pub(crate) returned: fn(&mut Kernel<'_>, &CallRecord, (FileId, ProgramRange)) -> Acted,
}
