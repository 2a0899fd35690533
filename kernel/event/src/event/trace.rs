//! Lines of the trace.

use super::declare::record;

/// Letter of what controls the listing: `on`, `off`, or a number of empty lines. It is no letter that a job may ask
/// for.
pub const LISTING: char = 'L';

/// Begin of the control of the listing that gives the text of the next block, which is not the line of a file.
pub const BLOCK: &str = "block ";

/// Letter of actions. Most are read off the events; what no event tells is a line of its own.
pub const ACTION: char = 'A';

/// Begin of a dwell in revolutions, in place of the seconds of the event that follows.
pub const DWELL: &str = "| dwell rev=";

record! {
    /// A line of the trace.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct Trace {
        /// Its letter.
        pub letter: char = 1,
        /// The whole line.
        pub text: Box<str> = 2,
    }
}
