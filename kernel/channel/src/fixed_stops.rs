//! The moves of a channel that end at fixed stops.
//!
//! *Invariant:* bits of axes are those of the channel; `once` is empty between blocks.

/// The axes whose feed moves end at a stop.
#[derive(Debug, Clone, Copy, Default)]
pub struct FixedStops {
    /// Slides and axes with a known stop, while they move away from home.
    pub modal: bool,
    /// Axes of the current move to a stop, bit by axis.
    pub once: u8,
    /// Axes that the program has named, bit by axis.
    pub named: u8,
    /// Named axes that have met their stops, bit by axis.
    pub met: u8,
    /// Whether a turning cycle makes the current move.
    pub in_turning_cycle: bool,
}

impl FixedStops {
    /// Whether a move may end at a stop.
    #[inline(always)]
    #[must_use]
    pub fn any(self) -> bool {
        self.modal | (self.once | self.named != 0)
    }
}
