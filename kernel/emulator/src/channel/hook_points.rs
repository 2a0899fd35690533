//! The points at which the macros of a machine take part in the work of a kernel.
//!
//! *Invariant:* the kernel knows its hooks by these points only. A machine without macros has none (`Plan::hooks` is
//! `None`): its blocks go the same way and pay one comparison at each point. Facts: reference control-emulator.md 2.

use counterpoint_fault::{Acted, Halt};

use counterpoint_channel::cycle::CycleHole;
use counterpoint_control_api::IdentificationAnswer;
use counterpoint_lang::value::MacroValue;

use super::Kernel;
use counterpoint_channel::flow::CallRecord;
use counterpoint_event::event::{FileId, Motion, ToolAction};
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_program::block::PendingCode;
use counterpoint_program::block::RetrievedValue;
use counterpoint_program::shape::ProgramRange;

/// Where the codes and data of a block come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockOrigin {
    /// Its text.
    Text,
    /// EXEC with identifiers.
    Items,
}

/// Treatment of a block after it has been edited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockTreatment {
    /// Nothing is left of it.
    Dropped,
    /// It is split into words without the pre-processor.
    Plain,
    /// It goes to the pre-processor.
    Preprocess,
}

/// Where a called subprogram is, if anywhere.
pub type Found = Option<(FileId, ProgramRange)>;

/// All points.
pub struct HookPoints {
    /// Around the text of a block.
    pub block: BlockHooks,
    /// Around its codes and data.
    pub codes: CodeHooks,
    /// Around programs and calls.
    pub program: ProgramHooks,
    /// Executes a motion and its duration in seconds.
    pub motion: fn(&mut Kernel<'_>, f64, &Motion) -> Acted,
    /// Selects or loads a tool, or changes its offset, through the macro of tools; the duration is in ns.
    pub tool: fn(&mut Kernel<'_>, ToolAction, u32, u32, i64) -> Acted,
    /// Selects (1) or loads (2) a head, through the macro of tools.
    pub head: fn(&mut Kernel<'_>, f64, u32) -> Acted,
    /// A tool has been loaded in place of another tool.
    pub loaded: fn(&mut Kernel<'_>, u32, u32),
    /// Makes a hole, through the macro of cycles.
    pub cycle: fn(&mut Kernel<'_>, &CycleHole) -> Acted,
    /// Asks the identification macro about an unknown text and the value assigned to it.
    pub identify: fn(&mut Kernel<'_>, &str, MacroValue) -> Result<IdentificationAnswer, Halt>,
    /// Logs a diagnostic (number and severity) with the changes of macros. `true`: it stops the channel.
    pub diagnostic: fn(&mut Kernel<'_>, (u32, u8), String, bool),
    /// Writes a motion and its duration in seconds down for the tables of tools and operations.
    pub moved: fn(&mut Kernel<'_>, f64, &Motion),
}

/// Around the text of a block.
pub struct BlockHooks {
    /// Processes a block that EXEC/NEXT left, in place of reading one; none if nothing was left.
    pub next: fn(&mut Kernel<'_>) -> Option<Acted>,
    /// A line of a file becomes the block.
    pub begin: fn(&mut Kernel<'_>),
    /// Block delete around embedded code, embedded code, Pre-Processor Startup.
    pub edit: fn(&mut Kernel<'_>) -> Result<BlockTreatment, Halt>,
    /// Pre-Processor Shutdown.
    pub preprocessed: fn(&mut Kernel<'_>) -> Acted,
    /// Pre-Processor Shutdown for words that the pre-processor made.
    pub made: fn(&mut Kernel<'_>) -> Acted,
    /// Whether a macro may read the words that the pre-processor leaves of the block.
    pub reads_left: fn(&Kernel<'_>) -> bool,
    /// Comments and messages of a statement, before it is executed.
    pub statement: fn(&mut Kernel<'_>, &[u8]) -> Acted,
    /// Pre-Processor Shutdown after a statement that left no words.
    pub consumed: fn(&mut Kernel<'_>) -> Acted,
    /// Embedded code and Block Startup before the codes; false if the block is dropped.
    pub words: fn(&mut Kernel<'_>) -> Result<bool, Halt>,
    /// Comments and messages, before the codes.
    pub remarks: fn(&mut Kernel<'_>) -> Acted,
}

/// Around the codes and data of a block.
pub struct CodeHooks {
    /// Sequence numbers and data of the block that macros can ask for.
    pub begin: fn(&mut Kernel<'_>, BlockOrigin),
    /// Codes that data fire.
    pub implied: fn(&mut Kernel<'_>),
    /// Lets a code act: its macro, otherwise its action.
    pub act: fn(&mut Kernel<'_>, PendingCode, CodeId) -> Acted,
    /// A code has acted.
    pub acted: fn(&mut Kernel<'_>) -> Acted,
    /// Takes data off the block.
    pub take: fn(&mut Kernel<'_>, DataId) -> Option<RetrievedValue>,
    /// Block Shutdown.
    pub end: fn(&mut Kernel<'_>, BlockOrigin) -> Acted,
    /// Data that macros added and nothing took.
    pub dropped: fn(&mut Kernel<'_>) -> Acted,
}

/// Around programs, calls and variables.
pub struct ProgramHooks {
    /// Declaration and Program Startup.
    pub start: fn(&mut Kernel<'_>) -> Acted,
    /// Subprogram Startup for the first pass, at a level: none if the call is ignored, otherwise where the subprogram
    /// is.
    pub call: fn(&mut Kernel<'_>, &CallRecord, Found) -> Result<Option<Found>, Halt>,
    /// Subprogram Shutdown and Startup between two passes.
    pub next_pass: fn(&mut Kernel<'_>) -> Acted,
    /// Subprogram Shutdown after the last pass.
    pub returned: fn(&mut Kernel<'_>, &CallRecord, (FileId, ProgramRange)) -> Acted,
    /// Program Startup of a program that begins after another program.
    pub start_again: fn(&mut Kernel<'_>) -> Acted,
    /// Program Shutdown, and the programs that it starts; returns how the last program ended.
    pub end: fn(&mut Kernel<'_>, Halt) -> Halt,
    /// Closes the files of macros at the end of the kernel.
    pub close: fn(&mut Kernel<'_>, Halt),
}
