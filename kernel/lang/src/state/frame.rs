//! The registers of macros.

use crate::value::MacroValue;

/// Which macros have registers, and which are active.
#[derive(Debug, Default)]
pub(crate) struct FrameTable {
    /// Frame of every macro, none while it runs.
    pub(crate) frames: Vec<Option<Box<MacroFrame>>>,
    /// Names of the active macros, if they are traced.
    pub(crate) names: Vec<String>,
}

/// A running macro, or waits for a function. It stays allocated, constants included, from run to run.
#[derive(Debug, Default)]
pub(crate) struct MacroFrame {
    /// Its registers, followed by unused ones up to the size of a window.
    pub(crate) registers: Vec<MacroValue>,
    /// Which macro it is.
    pub(crate) index: u16,
    /// The frame that waits for it, none for the outermost macro; at which instruction, and the register for the
    /// result.
    pub(crate) caller: Option<Box<MacroFrame>>,
    pub(crate) at: usize,
    pub(crate) to: u16,
}

impl MacroFrame {
    /// Records the frame that waits for this macro.
    #[inline]
    pub(crate) fn wait(&mut self, caller: Box<MacroFrame>, at: usize, to: u16) {
        if let Some(other) = self.caller.replace(caller) {
            drop(other);
        }
        self.at = at;
        self.to = to;
    }
}
