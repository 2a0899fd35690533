//! What actions remember of a channel beyond modal codes, data and positions.
//!
//! Invariant: one box a kernel; the block loop never looks into it for what a machine does not use.

/// States of one channel.
#[derive(Debug, Default)]
pub(crate) struct States {
    /// Coolant.
    pub(crate) coolant: super::coolant::State,
}
