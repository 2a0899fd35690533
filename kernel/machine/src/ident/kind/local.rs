//! What codes of the local frame do.

/// What a code does to its part of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// Sets it.
    On,
    /// Adds to the active frame.
    Add,
    /// Takes it away.
    Off,
}
