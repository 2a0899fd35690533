//! The order of everything that channels share: superdense time and channel.

/// `(time, microstep, channel)`: shared operations are executed in this order, for any schedule of threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Tag {
    /// Simulated time, ns.
    pub t: i64,
    /// Order among causally related operations of one instant.
    pub micro: u32,
    /// Channel number; 0 is the master.
    pub channel: u16,
}

impl Tag {
    /// Microstep at which a channel looks at data that other channels may still change at the same instant.
    pub const LATE: u32 = 1 << 20;
    /// After everything.
    pub const END: Self = Self { t: i64::MAX, micro: u32::MAX, channel: u16::MAX };
}
