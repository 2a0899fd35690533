//! The macros of a machine as the kernel runs them: compiled, named, with their triggers.
//!
//! Invariant: every lookup while a program runs uses an index found when the machine was loaded: a hook is a
//! place in an array, the macros of a code or of data are a list by identifier. Facts: reference control-emulator.md 4.

use std::sync::Arc;

use counterpoint_lang::compile::{self, DeclarationStrictness, MacroProgram};

use super::condition::{BlockIdentifier, MacroCondition};
use super::environment::MachineEnvironment;
use crate::ident::{CodeId, DataId};
use crate::index::{CodeMacroId, DataMacroId, IdTable};
use counterpoint_event::Letters;

/// A place of the run where one macro may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Hook {
    /// Declares shared variables and functions, once in every kernel.
    Declaration,
    /// Master kernel, before the channels.
    MachineStartup,
    /// Master kernel, after the channels.
    MachineShutdown,
    /// Before the first block of a channel.
    ProgramStartup,
    /// After the last block of a channel.
    ProgramShutdown,
    /// Before each pass of a subprogram.
    SubprogramStartup,
    /// After each pass of a subprogram.
    SubprogramShutdown,
    /// Before the pre-processor sees a block.
    PreprocessorStartup,
    /// After the pre-processor has seen a block.
    PreprocessorShutdown,
    /// Before a block is split into codes and data.
    BlockStartup,
    /// After the codes of a block.
    BlockShutdown,
    /// A motion is about to take place.
    Motion,
    /// A canned cycle is about to take place.
    Cycle,
    /// A tool is about to be selected or loaded.
    Tool,
    /// A diagnostic is about to be issued.
    Diagnostic,
    /// The pre-processor met a variable or function it does not know.
    Identification,
}

/// Number of hooks.
pub const HOOKS: usize = 16;

/// Second name of the macro of tools, while a tool is only selected.
pub const SELECT_TOOL: &str = "Select Tool Event Macro";

/// Number that `$FMACID` gives the macro of the first hook; the others follow.
pub const FIRST_HOOK_ID: u32 = 9001;

impl Hook {
    /// All hooks in order.
    pub const ALL: [Hook; HOOKS] = [
        Hook::Declaration,
        Hook::MachineStartup,
        Hook::MachineShutdown,
        Hook::ProgramStartup,
        Hook::ProgramShutdown,
        Hook::SubprogramStartup,
        Hook::SubprogramShutdown,
        Hook::PreprocessorStartup,
        Hook::PreprocessorShutdown,
        Hook::BlockStartup,
        Hook::BlockShutdown,
        Hook::Motion,
        Hook::Cycle,
        Hook::Tool,
        Hook::Diagnostic,
        Hook::Identification,
    ];

    /// Key of the machine file.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Hook::Declaration => "declaration",
            Hook::MachineStartup => "machine_startup",
            Hook::MachineShutdown => "machine_shutdown",
            Hook::ProgramStartup => "program_startup",
            Hook::ProgramShutdown => "program_shutdown",
            Hook::SubprogramStartup => "subprogram_startup",
            Hook::SubprogramShutdown => "subprogram_shutdown",
            Hook::PreprocessorStartup => "preprocessor_startup",
            Hook::PreprocessorShutdown => "preprocessor_shutdown",
            Hook::BlockStartup => "block_startup",
            Hook::BlockShutdown => "block_shutdown",
            Hook::Motion => "motion",
            Hook::Cycle => "cycle",
            Hook::Tool => "tool",
            Hook::Diagnostic => "diagnostic",
            Hook::Identification => "preprocessor_identification",
        }
    }

    /// Name for people, as `$FMACID` gives it.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Hook::Declaration => "Declaration Macro",
            Hook::MachineStartup => "Machine Startup Macro",
            Hook::MachineShutdown => "Machine Shutdown Macro",
            Hook::ProgramStartup => "Program Startup Macro",
            Hook::ProgramShutdown => "Program Shutdown Macro",
            Hook::SubprogramStartup => "Subprogram Startup Macro",
            Hook::SubprogramShutdown => "Subprogram Shutdown Macro",
            Hook::PreprocessorStartup => "Pre-Processor Startup Macro",
            Hook::PreprocessorShutdown => "Pre-Processor Shutdown Macro",
            Hook::BlockStartup => "Block Startup Macro",
            Hook::BlockShutdown => "Block Shutdown Macro",
            Hook::Motion => "Motion Event Macro",
            Hook::Cycle => "Cycle Event Macro",
            Hook::Tool => "Load Tool Event Macro",
            Hook::Diagnostic => "Diagnostic Event Macro",
            Hook::Identification => "Pre-Processor Identification Macro",
        }
    }

    /// The logical system variable that switches it, if there is one.
    #[must_use]
    pub const fn switch(self) -> Option<&'static str> {
        Some(match self {
            Hook::SubprogramStartup => "$CESBST",
            Hook::SubprogramShutdown => "$CESBSH",
            Hook::PreprocessorStartup => "$CEPPST",
            Hook::PreprocessorShutdown => "$CEPPSH",
            Hook::BlockStartup => "$CEBKST",
            Hook::BlockShutdown => "$CEBKSH",
            Hook::Motion => "$MTNMAC",
            Hook::Cycle => "$CYCMAC",
            Hook::Tool => "$TCMAC",
            Hook::Diagnostic => "$DIAGMAC",
            Hook::Identification => "$CEPPID",
            _ => return None,
        })
    }
}

/// A code or data macro.
#[derive(Debug, Clone)]
pub struct TriggeredMacro {
    /// Number by which macros switch it, 1 to 8999, unique among code and data macros.
    pub id: u32,
    /// Name for people.
    pub name: String,
    /// On at the start of the run.
    pub enabled: bool,
    /// Index in the program.
    pub code: u16,
    /// Identifiers that fire it, as the machine file lists them.
    pub matches: Vec<BlockIdentifier>,
    /// Conditions besides a matching identifier.
    pub condition: MacroCondition,
}

impl Macros {
    /// Whether it is the macro of a code or of data.
    pub fn is_named(&self, code: u16) -> bool {
        self.codes.iter().chain(&self.data).any(|named| named.code == code)
    }

    /// Name of the macro with this code, for people.
    pub fn name_of(&self, code: u16) -> Option<&str> {
        let hook = Hook::ALL.into_iter().find(|hook| self.hooks.get(*hook as usize) == Some(&Some(code)));
        let named = || self.codes.iter().chain(&self.data).find(|named| named.code == code);
        hook.map(Hook::title).or_else(|| named().map(|named| named.name.as_str()))
    }

    /// The code macro with this code.
    pub fn code_macro(&self, code: u16) -> Option<&TriggeredMacro> {
        self.codes.iter().find(|named| named.code == code)
    }

    /// The program that kernels run: with trace instructions only if macros are to be traced.
    pub fn program_for(&self, mut environment: MachineEnvironment<'_>, letters: Letters) -> Arc<MacroProgram> {
        if !letters.has('M') && !letters.has('H') {
            return Arc::clone(&self.program);
        }
        Arc::new(compile::traced(&self.program, &mut environment))
    }
}

/// All macros of a machine.
#[derive(Debug, Clone, Default)]
pub struct Macros {
    /// Compiled code.
    pub program: Arc<MacroProgram>,
    /// Which names had to be declared.
    pub strong: DeclarationStrictness,
    /// Macro of each hook.
    pub hooks: [Option<u16>; HOOKS],
    /// Code macros in list order.
    pub codes: IdTable<CodeMacroId, TriggeredMacro>,
    /// Data macros in list order.
    pub data: IdTable<DataMacroId, TriggeredMacro>,
    /// Code macros of each code identifier, in list order.
    pub of_code: IdTable<CodeId, Vec<CodeMacroId>>,
    /// Data macros of each data identifier, in list order.
    pub of_data: IdTable<DataId, Vec<DataMacroId>>,
}

impl Macros {
    /// Macro of a hook.
    #[must_use]
    pub fn hook(&self, hook: Hook) -> Option<u16> {
        self.hooks.get(hook as usize).copied().flatten()
    }

    /// Code macros that a code may fire, in list order.
    #[must_use]
    pub fn of_code(&self, id: CodeId) -> &[CodeMacroId] {
        &self.of_code[id]
    }

    /// Data macros of an identifier, in list order.
    #[must_use]
    pub fn of_data(&self, id: DataId) -> &[DataMacroId] {
        &self.of_data[id]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::macros::system;

    #[test]
    fn hooks_stand_at_their_place_and_their_switches_exist() {
        for (place, hook) in Hook::ALL.into_iter().enumerate() {
            assert_eq!(hook as usize, place);
            assert!(hook.switch().is_none_or(|name| system::find(name).is_some()), "{hook:?}");
        }
    }
}
