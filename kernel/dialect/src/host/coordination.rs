//! What channels do for each other by statements: they wait, and let each other continue.

use counterpoint_fault::Acted;

/// What a statement between channels takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operands {
    /// A mark, then channels.
    MarkAndChannels,
    /// Marks.
    Marks,
    /// Channels.
    Channels,
}

/// Statements between channels. Which there are and what they mean is data of the machine (`[[waits]]`).
pub trait Coordination {
    /// What a statement with this name takes; `None` if it is not one between channels.
    fn coordinates(&self, statement: &str) -> Option<Operands>;

    /// Number of the channel that the machine gives this name, letter case ignored.
    fn channel_named(&self, name: &str) -> Option<u16>;

    /// Executes a statement for a mark (0 without one) and channels: waits until the others are there, or lets them continue.
    ///
    /// # Errors
    /// Its mark or its channels are not possible, the control refuses the wait, or the job was stopped.
    fn coordinate(&mut self, statement: &str, mark: i64, channels: &[i64]) -> Acted;
}
