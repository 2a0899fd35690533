//! Settings that all pre-processors have, as macros made them with `$FCEPP`.

/// Values set by macros.
#[derive(Debug)]
pub(crate) struct Settings {
    /// Comments and messages are removed from the block.
    pub(crate) taken_off: [bool; 2],
}

impl Default for Settings {
    fn default() -> Self {
        Self { taken_off: [true; 2] }
    }
}
