//! Coordination of channels by statements: they wait, and let each other continue.

use counterpoint_event::FileId;
use counterpoint_fault::{Acted, Halt};
use counterpoint_program::shape::ProgramRange;

/// The arguments of a statement between channels.
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
    /// Axes.
    Axes,
    /// Pairs of an axis and the channel that gets it.
    AxesAndChannels,
}

/// The data of a statement about a signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Signal {
    /// Its number.
    pub number: f64,
    /// The last number of a range.
    pub last: Option<f64>,
    /// Channels that get it, or that send it; none: all channels, any channel.
    pub channels: Vec<f64>,
    /// How many waits can use it.
    pub uses: Option<f64>,
    /// Values that go with it, by index.
    pub values: Vec<(u8, f64)>,
}

/// Statements between channels. Data of the machine (`[[waits]]`) define the statements and their meaning.
pub trait Coordination {
    /// Operands of the statement with this name; `None` if it is not a statement between channels.
    fn coordinates(&self, statement: &str) -> Option<Operands>;

    /// Number of the channel that the machine gives this name, letter case ignored.
    fn channel_named(&self, name: &str) -> Option<u16>;

    /// Executes a statement for a mark (0 without one) and channels: waits until the others are there, or lets them
    /// continue.
    ///
    /// # Errors
    /// Its mark or its channels are not possible, the control refuses the wait, or the job was stopped.
    fn coordinate(&mut self, statement: &str, mark: i64, channels: &[i64]) -> Acted;

    /// Executes a statement about an axis that channels exchange, and the channel that gets it.
    ///
    /// # Errors
    /// The channel cannot have the axis, another one holds it where that is not possible, or the job was stopped.
    fn exchange(&mut self, statement: &str, axis: &str, channel: Option<i64>) -> Acted;

    /// Sends a signal by the statement with this name.
    ///
    /// # Errors
    /// Its number or its channels are not possible, the control can keep no more signals, or the job was stopped.
    fn send(&mut self, statement: &str, signal: &Signal) -> Acted;

    /// Removes unused signals.
    ///
    /// # Errors
    /// Those of [`Coordination::send`].
    fn remove_signal(&mut self, statement: &str, signal: &Signal) -> Acted;

    /// Waits for a signal, or takes it if it is there: the values that came with it; none if it is not there.
    ///
    /// # Errors
    /// Those of [`Coordination::send`], and no channel is left to send it.
    fn receive(&mut self, statement: &str, signal: &Signal, waits: bool) -> Result<Option<Vec<(u8, f64)>>, Halt>;

    /// Selects the program that a channel runs when it is started; none if there is no such program.
    ///
    /// # Errors
    /// The channel does not exist or runs, or the job was stopped.
    fn select(&mut self, channel: i64, name: &str, program: Option<(FileId, ProgramRange)>) -> Acted;
}
