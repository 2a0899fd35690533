//! Which macros are on.

use counterpoint_machine::macros::model::{HOOKS, Hook, Macros};

/// Hooks, code macros and data macros that are on.
#[derive(Debug, Default)]
pub(crate) struct Hooks {
    /// Macro of each hook that is on.
    pub(crate) on: [Option<u16>; HOOKS],
    /// Code macros that are on.
    pub(crate) codes: Vec<bool>,
    /// Data macros that are on.
    pub(crate) data: Vec<bool>,
    /// What is processed now may match code and data macros.
    pub(crate) matching: bool,
}

impl Hooks {
    /// All that the machine has on at the start of a run.
    pub(crate) fn new(macros: &Macros) -> Self {
        Self {
            on: macros.hooks,
            codes: macros.codes.iter().map(|one| one.enabled).collect(),
            data: macros.data.iter().map(|one| one.enabled).collect(),
            matching: true,
        }
    }

    /// The macro of a hook, if it is on.
    #[inline]
    pub(crate) fn of(&self, hook: Hook) -> Option<u16> {
        self.on.get(hook as usize).copied().flatten()
    }

    /// A code macro is on.
    pub(crate) fn has_code(&self, at: usize) -> bool {
        self.codes.get(at).copied().unwrap_or(false)
    }

    /// A data macro is on.
    pub(crate) fn has_data(&self, at: usize) -> bool {
        self.data.get(at).copied().unwrap_or(false)
    }
}
