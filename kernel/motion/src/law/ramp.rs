//! The speed along a planned move: acceleration, constant speed, deceleration.

/// The speed along a move of the look-ahead. Lengths in geometry units, times in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRamp {
    /// Length, above zero.
    pub length: f64,
    /// Speed at the start.
    pub entry: f64,
    /// Highest speed, above zero.
    pub top: f64,
    /// Speed at the end.
    pub exit: f64,
    /// Acceleration and deceleration; infinite: speeds change at once.
    pub acceleration: f64,
}

impl SpeedRamp {
    /// A move from standstill to standstill, as fast as the speed and the acceleration allow.
    #[must_use]
    pub fn alone(length: f64, speed: f64, acceleration: f64) -> Self {
        let top = if acceleration.is_finite() { speed.min((acceleration * length).sqrt()) } else { speed };
        Self { length, entry: 0.0, top, exit: 0.0, acceleration }
    }

    /// Seconds of acceleration, constant speed and deceleration.
    fn parts(&self) -> [f64; 3] {
        let Self { length, entry, top, exit, acceleration } = *self;
        let change = |end: f64| if acceleration.is_finite() { (top - end).max(0.0) / acceleration } else { 0.0 };
        let (up, down) = (change(entry), change(exit));
        let ramps = 0.5 * ((top + entry) * up + (top + exit) * down);
        [up, (length - ramps).max(0.0) / top, down]
    }

    /// Seconds of the move.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.parts().iter().sum()
    }

    /// The fraction of the length that is complete after this fraction of the time, both from 0 to 1.
    #[must_use]
    pub fn way(&self, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        if time >= 1.0 {
            return 1.0;
        }
        let Self { length, entry, exit, top, acceleration } = *self;
        let [up, steady, down] = self.parts();
        let elapsed = time * (up + steady + down);
        let left = (1.0 - time) * (up + steady + down);
        let way = if elapsed < up {
            elapsed * (entry + 0.5 * acceleration * elapsed)
        } else if left < down {
            length - left * (exit + 0.5 * acceleration * left)
        } else {
            0.5 * (top + entry) * up + top * (elapsed - up)
        };
        (way / length).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fraction by integration in small time steps.
    fn by_steps(ramp: &SpeedRamp, time: f64) -> f64 {
        const STEPS: u32 = 40_000;
        let step = ramp.seconds() * time / f64::from(STEPS);
        let whole = ramp.seconds();
        let speed = |at: f64| {
            let rising = ramp.entry + ramp.acceleration * at;
            let falling = ramp.exit + ramp.acceleration * (whole - at);
            rising.min(falling).min(ramp.top)
        };
        (0..STEPS).map(|at| speed((f64::from(at) + 0.5) * step) * step).sum::<f64>() / ramp.length
    }

    #[test]
    fn the_way_is_the_integral_of_the_speed() {
        let ramps = [
            SpeedRamp::alone(100.0, 100.0, 1000.0),
            SpeedRamp::alone(2.5, 100.0, 1000.0),
            SpeedRamp { length: 3.0, entry: 20.0, top: 50.0, exit: 35.0, acceleration: 800.0 },
            SpeedRamp { length: 1.0, entry: 40.0, top: 40.0, exit: 10.0, acceleration: 750.0 },
        ];
        for ramp in ramps {
            for time in [0.02, 0.1, 0.3, 0.5, 0.77, 0.95] {
                let (exact, stepped) = (ramp.way(time), by_steps(&ramp, time));
                assert!((exact - stepped).abs() < 1e-6, "{ramp:?} {time}: {exact} {stepped}");
            }
            assert_eq!([ramp.way(0.0), ramp.way(1.0), ramp.way(7.0)], [0.0, 1.0, 1.0]);
        }
    }

    #[test]
    fn times_are_those_of_the_trapezoid() {
        // 100 mm at 6000 mm/min and 1000 mm/s²: 1.0 s + 0.1 s; after the ramp of 0.1 s 5 mm are complete.
        let ramp = SpeedRamp::alone(100.0, 100.0, 1000.0);
        assert!((ramp.seconds() - 1.1).abs() < 1e-12);
        assert!((ramp.way(0.1 / 1.1) - 0.05).abs() < 1e-12);
        let at_once = SpeedRamp::alone(100.0, 100.0, f64::INFINITY);
        assert_eq!((at_once.seconds(), at_once.way(0.25)), (1.0, 0.25));
    }
}
