//! The memory of the macros of one running kernel.
//!
//! *Invariant:* plain data with methods of its own; a kernel without macros has it empty, with no macro on.

use std::sync::Arc;

use counterpoint_lang::compile::MacroProgram;

use super::books::Books;
use super::calls::{OutputTask, RunningMacros};
use super::hooks::Hooks;
use super::issued::Issued;
use super::parts::{
    DiagnosticChanges, ExternalResources, MacroInputs, MacroModes, MacroVariables, ProgramContinuation, ScanState,
};
use super::store::SystemVariableStore;
use super::tool_table::ToolTable;
use counterpoint_machine::macros::model::{Hook, Macros};
use counterpoint_sync::races::RaceVariable;

/// Macros of one kernel.
#[derive(Debug, Default)]
pub struct Runtime {
    /// The machine's program, or a longer copy with the embedded code compiled so far.
    pub program: Arc<MacroProgram>,
    /// The macros of the steps of a block.
    pub hooks: Hooks,
    /// Macros that are running.
    pub calls: RunningMacros,
    /// Blocks that macros left for later.
    pub issued: Issued,
    /// Modes that macros have set.
    pub modes: MacroModes,
    /// Tables of operations and of travel.
    pub books: Books,
    /// The tool table.
    pub tools: ToolTable,
    /// System variables and globals of the kernel.
    pub variables: MacroVariables,
    /// Changes of diagnostics by macros.
    pub diagnostics: DiagnosticChanges,
    /// Scans by macros.
    pub reading: ScanState,
    /// Arguments of the hooks.
    pub arguments: MacroInputs,
    /// Files, dialogs and other things outside the kernel.
    pub outside: ExternalResources,
    /// How far the program has come, as macros see it.
    pub course: ProgramContinuation,
}

impl Runtime {
    /// The start of a run; `kernels` > 1 means that there is a master.
    pub fn new(macros: &Macros, program: &Arc<MacroProgram>, kernel: u16, (kernels, memory): (usize, u64)) -> Self {
        let mut runtime = Self {
            program: Arc::clone(program),
            hooks: Hooks::new(macros),
            calls: RunningMacros::new(kernel, kernels, memory),
            variables: MacroVariables {
                store: SystemVariableStore::new(),
                first_shared: (kernels > 1).then_some(100),
                ..MacroVariables::default()
            },
            ..Self::default()
        };
        runtime.measure();
        runtime
    }

    /// Follows the program after it has grown.
    pub fn measure(&mut self) {
        self.calls.measure(&self.program);
    }

    /// The macro of a hook, if it may run now.
    #[inline]
    pub fn ready(&self, hook: Hook) -> Option<u16> {
        self.hooks.of(hook).filter(|&code| !self.calls.is_busy(code))
    }

    /// Notes that a macro starts; returns whether macros matched before.
    pub fn begin_macro(&mut self, code: u16, task: OutputTask) -> bool {
        self.calls.begin(code, task);
        std::mem::replace(&mut self.hooks.matching, true)
    }

    /// Whether macros match the blocks and codes that the running macro issues from here on.
    pub fn match_macros(&mut self, on: bool) {
        if let Some(call) = self.calls.innermost() {
            call.matching = on;
        }
    }

    /// A variable as programs call it.
    pub fn variable_name(&self, variable: &RaceVariable) -> String {
        match variable {
            RaceVariable::Common(index) => format!("#{index}"),
            RaceVariable::Named(name) => name.to_string(),
            RaceVariable::Global(index) => {
                let name = self.program.globals.get(*index as usize);
                name.cloned().unwrap_or_else(|| format!("GLOBAL {index}"))
            }
        }
    }

    /// Whether comments, messages fire codes: where no pre-processor takes them off.
    pub fn remarks_fire(&self, preprocessed: bool) -> [bool; 2] {
        self.variables.store.preprocessor.taken_off.map(|off| !(off && preprocessed))
    }
}
