//! The law of a move: its progress along the path at each instant.
//!
//! Two steps lead from time to path. The planner determines the progress of the *planned* time: speeds change at once,
//! or with a [`SpeedRamp`] at the acceleration of the axes. The feed determines the fraction of the path that is
//! complete after a fraction of the planned time: a [`FeedSchedule`]. Moves in which each axis moves at its own rate
//! have an [`AxisRamp`] for each axis instead. *Invariants:* every function here increases with time, is 0 at the start
//! and 1 at the end, bit by bit.

mod axis;
mod ramp;
mod schedule;

pub use axis::AxisRamp;
pub use ramp::SpeedRamp;
pub use schedule::{FeedSchedule, SpindleRotation};

/// The law of a move along one path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLaw {
    /// Progress of the planned time; `None`: speeds change at once.
    pub ramp: Option<SpeedRamp>,
    /// Progress along the path in the planned time.
    pub schedule: FeedSchedule,
}

impl PathLaw {
    /// The fraction of the path that is complete after this fraction of the time, both from 0 to 1.
    #[must_use]
    pub fn path(&self, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        if time >= 1.0 {
            return 1.0;
        }
        let planned = self.ramp.map_or(time, |ramp| ramp.way(time));
        self.schedule.path(planned).clamp(0.0, 1.0)
    }
}

/// Bisection steps that determine a number between 0 and 1 to the last bit.
const HALVINGS: usize = 60;

/// The number between 0 and 1 up to which an increasing function stays below a value.
fn invert(value: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if function(middle) < value { low = middle } else { high = middle }
    }
    high
}
