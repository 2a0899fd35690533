//! Settings of the pre-processor that macros made with `$FCEPP`.

use rustc_hash::FxHashMap;

/// What macros have set.
#[derive(Debug)]
pub(crate) struct Settings {
    /// Comments and messages are taken off the block.
    pub(crate) taken_off: [bool; 2],
    /// A variable without a value is vacant; otherwise it, and one that does not exist, is 0.
    pub(crate) null: bool,
    /// The identification macro is asked where to write a system variable; otherwise its value is kept.
    pub(crate) asks: bool,
    /// Values kept for system variables.
    pub(crate) kept: FxHashMap<u32, f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { taken_off: [true; 2], null: true, asks: true, kept: FxHashMap::default() }
    }
}
