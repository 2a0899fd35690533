//! Lines of the trace.

use super::declare::record;

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
