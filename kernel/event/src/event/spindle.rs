//! Spindles.

use super::declare::{record, words};
use super::work::WorkClass;

words! {
    /// Rotation of a spindle.
    pub enum SpindleDirection {
        /// Not turning.
        Off = 1 "off",
        /// M3.
        Clockwise = 2 "clockwise",
        /// M4.
        CounterClockwise = 3 "counter_clockwise",
        /// Oriented, M19.
        Oriented = 4 "oriented",
        /// Held in its place.
        Locked = 5 "locked",
        /// Free to be turned by hand.
        Neutral = 6 "neutral",
    }
}

record! {
    /// State of a spindle after a spindle code; the duration of the event is run-up time if the machine has any.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SpindleChange {
        /// Spindle number of the machine.
        pub spindle: u16 = 1,
        /// Rotation.
        pub direction: SpindleDirection = 2,
        /// `true` = constant surface speed.
        pub css: bool = 3,
        /// Revolutions per minute, or surface speed in m/min (ft/min in inch) when `css`.
        pub speed: f64 = 4,
        /// Speed limit in rev/min; infinite when none.
        pub limit: f64 = 5,
        /// Angle of an oriented stop, degrees; 0 otherwise.
        pub angle: f64 = 6 [if SpindleChange::is_oriented],
    }

    fn work(&self) -> Option<WorkClass> {
        Some(WorkClass::Misc)
    }
}

impl SpindleChange {
    fn is_oriented(&self) -> bool {
        self.direction == SpindleDirection::Oriented
    }
}
