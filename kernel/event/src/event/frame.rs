//! The work frame.

use super::Position;
use super::declare::record;

record! {
    /// The work frame moved: machine position = programmed position + `shift`, axis by axis (axis units).
    #[derive(Debug, Clone, PartialEq)]
    pub struct FrameShift {
        /// Shift from the work frame to the machine base frame.
        pub shift: Box<Position> = 1,
    }
}
