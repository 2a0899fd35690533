//! One axis of a rapid move in which each axis moves at its own rate.

use super::SpeedRamp;

/// An axis that moves from standstill to standstill at its own rate, by times alone. It holds its position after its
/// arrival.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisRamp {
    /// Seconds until the arrival of the axis; 0: the axis does not move.
    pub arrives: f64,
    /// Seconds of its acceleration and of its deceleration, each at most half of the whole; 0: speeds change at once.
    pub ramp: f64,
}

impl AxisRamp {
    /// For an axis that changes its position by this length, with its rate per second and its acceleration per second
    /// squared, which may be infinite.
    #[must_use]
    pub fn new(change: f64, speed: f64, acceleration: f64) -> Self {
        if change == 0.0 {
            return Self::default();
        }
        let ramp = SpeedRamp::alone(change.abs(), speed, acceleration);
        let seconds = if acceleration.is_finite() { ramp.top / acceleration } else { 0.0 };
        Self { arrives: ramp.seconds(), ramp: seconds }
    }

    /// The fraction of the travel that is complete after this many seconds, from 0 to 1.
    #[must_use]
    pub fn way(&self, seconds: f64) -> f64 {
        let Self { arrives, ramp } = *self;
        if seconds >= arrives {
            return 1.0;
        }
        // The speed between the ramps, as a fraction of the travel per second.
        let top = 1.0 / (arrives - ramp);
        let (elapsed, left) = (seconds.max(0.0), arrives - seconds);
        let way = if elapsed < ramp {
            0.5 * top * elapsed * elapsed / ramp
        } else if left < ramp {
            1.0 - 0.5 * top * left * left / ramp
        } else {
            top * (elapsed - 0.5 * ramp)
        };
        way.clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_that_arrives_early_holds() {
        // 20 mm at 100 mm/s and 1000 mm/s²: 0.2 s at the rate, and 0.1 s for both ramps.
        let axis = AxisRamp::new(-20.0, 100.0, 1000.0);
        assert!((axis.arrives - 0.3).abs() < 1e-12 && (axis.ramp - 0.1).abs() < 1e-12, "{axis:?}");
        assert_eq!([axis.way(0.0), axis.way(axis.arrives), axis.way(9.0)], [0.0, 1.0, 1.0]);
        assert!((axis.way(0.15) - 0.5).abs() < 1e-12);
        assert_eq!(AxisRamp::new(0.0, 100.0, 1000.0).way(0.0), 1.0);
    }

    #[test]
    fn times_alone_give_the_way_of_the_ramp() {
        for (change, speed, acceleration) in [(100.0, 100.0, 1000.0), (2.5, 100.0, 1000.0), (7.0, 50.0, f64::INFINITY)]
        {
            let (axis, ramp) =
                (AxisRamp::new(change, speed, acceleration), SpeedRamp::alone(change, speed, acceleration));
            for at in [0.01, 0.2, 0.5, 0.9] {
                assert!((axis.way(at * axis.arrives) - ramp.way(at)).abs() < 1e-12, "{axis:?} {at}");
            }
        }
    }
}
