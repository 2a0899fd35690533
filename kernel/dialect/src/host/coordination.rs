//! What channels do for each other by statements: they wait, and let each other continue.

use counterpoint_event::FileId;
use counterpoint_fault::Acted;
use counterpoint_program::shape::Range;

/// What a statement between channels takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operands {
    /// A mark, then channels.
    MarkAndChannels,
    /// Marks.
    Marks,
    /// Channels.
    Channels,
    /// A channel, and the program that it is to run.
    Program,
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

    /// Selects the program that a channel runs when it is started; none if there is no such program.
    ///
    /// # Errors
    /// The channel does not exist or runs, or the job was stopped.
    fn select(&mut self, channel: i64, name: &str, program: Option<(FileId, Range)>) -> Acted;
}
