//! Messages.

use super::declare::record;

record! {
    /// An operator message or comment shown to the operator, or a line that a macro prints.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct OperatorMessage {
        /// Its text.
        pub text: Box<str> = 1,
        /// A macro has printed it (PPRINT): it is a line of the listing.
        pub printed: bool = 2 [added],
    }
}
