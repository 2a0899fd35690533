//! Data of probing moves. Facts: reference system-variables.md 12.

use counterpoint_event::event::{MAX_AXES, Position};

/// Data of probing moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct Probing {
    /// `$SKIPERR`: 0 none, 1 touched, 2 missed.
    pub result: f64,
    /// Where the last one ended, in the work frame.
    pub end: Position,
    /// Block of the last one.
    pub block: u64,
}

const _: () = assert!(MAX_AXES == 8, "the variables of the end count eight axes");

impl Probing {
    /// Whether a probing move belongs to this block.
    pub fn acts(&self, block: u64) -> bool {
        self.block == block && self.result != 0.0
    }
}
