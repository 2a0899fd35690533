//! Smaller parts of the memory of the macros of a kernel.

use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::index::CodeRowId;
use std::sync::Arc;

use counterpoint_lang::host::MacroFolder;
use counterpoint_lang::value::{Elements, MacroValue};
use rustc_hash::FxHashMap;

use super::asked::ExternalRequests;
use super::reused::Reused;
use super::store::SystemVariableStore;
use counterpoint_event::event::{DiagnosticOrigin, FileId, Position};
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_program::scan::LineScanner;

/// Modal codes that macros have saved or bound to data.
#[derive(Debug, Default)]
pub struct MacroModes {
    /// Pushed modal states.
    pub saved: Vec<Vec<(u16, CodeId, Option<CodeRowId>)>>,
    /// Data that fire a modal group.
    pub data_codes: Vec<(DataId, u16)>,
}

/// Global and system variables.
#[derive(Debug, Default)]
pub struct MacroVariables {
    /// System variables that are kept here.
    pub store: SystemVariableStore,
    /// Global variables that this kernel has for itself.
    pub globals: Vec<MacroValue>,
    /// From this index on, global variables belong to all kernels; none if there is no master.
    pub first_shared: Option<u32>,
}

/// Changes of macros to diagnostics.
#[derive(Debug, Default)]
pub struct DiagnosticChanges {
    /// Changed severities and switches by number.
    pub severities: FxHashMap<u32, (u8, bool)>,
    /// How often each diagnostic was raised.
    pub counts: FxHashMap<u32, u32>,
    /// The statement that raised the diagnostic which the diagnostic macro sees.
    pub origin: Option<Box<DiagnosticOrigin>>,
}

/// How texts are read.
#[derive(Debug, Default)]
pub struct ScanState {
    /// The scanner with levels of block skip that a macro has switched.
    pub switched: Option<Arc<LineScanner>>,
    /// Compiled embedded code by text; none where it has errors.
    pub embedded: FxHashMap<String, Option<(u16, bool)>>,
}

/// Values handed to macros.
#[derive(Debug, Default)]
pub struct MacroInputs {
    /// Texts of block macros.
    pub texts: Reused<Arc<String>>,
    /// Positions of event macros.
    pub positions: Reused<Elements>,
    /// Flags of event macros.
    pub flags: Reused<Elements>,
    /// Channel axis of each of the six elements of `$AXES`.
    pub slots: [Option<AxisSlot>; 6],
    /// Start of the last motion.
    pub before: Position,
}

/// The external resources of macros.
#[derive(Debug, Default)]
pub struct ExternalResources {
    /// Requests of macros.
    pub asked: ExternalRequests,
    /// Current folder, temporary files and open stores of values.
    pub folder: MacroFolder,
    /// Whether the kernel is ending: then it only writes its open files.
    pub leaving: bool,
}

/// Where the run continues after the shutdown macro.
#[derive(Debug, Clone, Copy)]
pub struct Restart {
    /// File of the job.
    pub file: FileId,
    /// First line.
    pub line: u32,
    /// As if it were the first file; otherwise counters, tool and modal codes continue.
    pub reset: bool,
}

/// The course of the program.
#[derive(Debug, Default)]
pub struct ProgramContinuation {
    /// Another file that the shutdown macro continues with.
    pub restart: Option<Restart>,
    /// The kernel's program macros are over: NEXT is ignored.
    pub closing: bool,
}
