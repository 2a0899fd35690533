//! Heads that codes raise.

/// The event of a code: `$P1` of the tool macro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeadEvent {
    /// A head is made ready.
    Select,
    /// It is loaded, changed or put back.
    Load,
}
