//! Actions of codes of the local frame.

/// The effect of a code on its part of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameChange {
    /// Sets it.
    On,
    /// Adds to the active frame.
    Add,
    /// Takes it away.
    Off,
}
