//! Which macros are on.

use counterpoint_machine::index::{CodeMacroId, DataMacroId, IdTable};
use counterpoint_machine::macros::model::{HOOKS, Hook, Macros};

/// Hooks, code macros and data macros that are on.
#[derive(Debug, Default)]
pub struct Hooks {
    /// Macro of each hook that is on.
    pub on: [Option<u16>; HOOKS],
    /// Code macros that are on.
    pub codes: IdTable<CodeMacroId, bool>,
    /// Data macros that are on.
    pub data: IdTable<DataMacroId, bool>,
    /// Whether the text in process may match code and data macros.
    pub matching: bool,
}

impl Hooks {
    /// All that the machine has on at the start of a run.
    pub fn new(macros: &Macros) -> Self {
        Self {
            on: macros.hooks,
            codes: macros.codes.map(|_, one| one.enabled),
            data: macros.data.map(|_, one| one.enabled),
            matching: true,
        }
    }

    /// The macro of a hook, if it is on.
    #[inline]
    pub fn of(&self, hook: Hook) -> Option<u16> {
        self.on.get(hook as usize).copied().flatten()
    }

    /// Whether a code macro is on.
    pub fn has_code(&self, at: CodeMacroId) -> bool {
        self.codes[at]
    }

    /// Whether a data macro is on.
    pub fn has_data(&self, at: DataMacroId) -> bool {
        self.data[at]
    }
}
