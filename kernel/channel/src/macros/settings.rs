//! Settings that all pre-processors have, as macros made them with `$FCEPP`.

/// Values set by macros.
#[derive(Debug)]
pub struct PreprocessorSettings {
    /// Comments and messages are removed from the block.
    pub taken_off: [bool; 2],
}

impl Default for PreprocessorSettings {
    fn default() -> Self {
        Self { taken_off: [true; 2] }
    }
}
