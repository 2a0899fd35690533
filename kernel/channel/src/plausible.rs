//! Blocks that a channel has reported as possible but improbable: each cause once in a program.
//!
//! *Invariant:* nothing here changes the effect of a block.

use counterpoint_machine::index::SpindleId;

/// A dwell longer than this is improbable, seconds.
pub const LONGEST_DWELL: f64 = 3600.0;

/// A move at feed that takes longer is improbable, seconds.
pub const LONGEST_MOVE: f64 = 3600.0;

/// Causes that have been reported.
#[derive(Debug, Clone, Copy, Default)]
pub struct Plausible {
    /// A long dwell.
    pub dwell: bool,
    /// A thread that is too fast for the axis.
    pub thread: bool,
    /// An improbable feed.
    pub feed: bool,
    /// A feed per revolution while the spindle is stopped.
    pub spindle: bool,
    /// Spindle and speed of the last report of a speed above the maximum, until the spindle has another speed.
    pub over_speed: Option<(SpindleId, f64)>,
    /// Another channel changed the speed of a spindle during a move that was timed with it.
    pub changed_speed: bool,
    /// Feeds per minute above this need a look: all of them until the spindle has been seen to turn.
    pub look_above: f64,
    /// The same for the rate that a feed per revolution comes to.
    pub look_above_revolutions: f64,
    /// A long move at feed.
    pub long_move: bool,
}

/// Hours and minutes of a time in seconds, for messages.
pub fn hours(seconds: f64) -> String {
    let minutes = (seconds / 60.0).floor();
    let hours = (minutes / 60.0).floor();
    format!("{hours} h {} min", minutes - hours * 60.0)
}

#[cfg(test)]
mod tests {
    #[test]
    fn times_in_hours_and_minutes() {
        assert_eq!(super::hours(3600.0), "1 h 0 min");
        assert_eq!(super::hours(90_061.0), "25 h 1 min");
    }
}
