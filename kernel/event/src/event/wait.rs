//! Waits of channels for each other.

use std::sync::Arc;

use super::declare::{record, words};

words! {
    /// The primitives of channel synchronisation (reference: channel-synchronisation.md 0 and 1.1).
    pub enum Primitive {
        /// All named channels meet.
        Barrier = 1 "BARRIER",
        /// A set flag lets others pass.
        Flag = 2 "FLAG",
        /// Ascending order numbers.
        Order = 3 "ORDER",
        /// The k-th meets the k-th.
        Count = 4 "COUNT",
        /// One sender, one receiver.
        Signal = 5 "SIGNAL",
        /// Waits for the end of others.
        Join = 6 "JOIN",
        /// Owns an axis or a spindle, one channel at a time.
        Lease = 7 "LEASE",
    }
}

record! {
    /// The channel arrived at a sync point and may now have to wait.
    #[derive(Debug, Clone, PartialEq)]
    pub struct WaitArrival {
        /// Mark in messages: `M101`, `M101 P12`.
        pub key: Arc<str> = 1,
        /// Primitive that waits.
        pub primitive: Primitive = 2,
        /// Channels that take part, own one included, ascending.
        pub participants: Arc<[u16]> = 3,
        /// The mark as the listing names it: `101`.
        pub mark: Arc<str> = 4 [wire],
        /// The code does more than wait: it begins or ends balance cutting or a coupling of axes.
        pub acts: bool = 5 [wire],
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(format!("sync mark={} wait", self.mark))
    }
}

record! {
    /// The channel continues after a wait.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Release {
        /// Same text as in [`WaitArrival::key`].
        pub key: Arc<str> = 1,
        /// Primitive that waited.
        pub primitive: Primitive = 2,
        /// When this channel arrived, ns.
        pub since_ns: i64 = 3,
        /// Ordinal of the sync point in the job, from 1, the same in all channels that met there.
        pub meeting: u64 = 4,
        /// Same text as in [`WaitArrival::mark`].
        pub mark: Arc<str> = 5 [wire],
        /// Channel whose operation ended the wait: the last to come, or the one that set the flag or sent the signal.
        pub by: u16 = 6 [wire],
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(format!("sync mark={} go", self.mark))
    }
}
