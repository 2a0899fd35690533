//! A block that is about to act.

use super::declare::record;

record! {
    /// A block was read and is about to act.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct BlockEvent {
        /// Ordinal of the block within its channel, from 1.
        pub number: u64 = 1,
        /// Whether the preceding block selected a unit of length.
        pub unit_named: bool = 2 [wire],
    }
}
