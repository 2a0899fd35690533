//! Time of a thread: feed locked to the spindle, with a lead that may change along the path.
//!
//! The lead changes by the same amount with each revolution, `L(n) = L₀ + c·n`, so the path is `L₀·n + c·n²/2`.
//! *Invariant:* everything is integrated exactly, under constant surface speed too.

use crate::surface_speed::SurfaceSpeed;

/// Lead of a thread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lead {
    /// At the start, length per revolution, above 0.
    pub start: f64,
    /// Change with each revolution.
    pub change: f64,
}

impl Lead {
    /// Revolutions over a path; `None` if the lead falls to nothing before.
    #[must_use]
    pub fn revolutions(&self, way: f64) -> Option<f64> {
        let square = self.start * self.start + 2.0 * self.change * way;
        // Free of cancellation for small changes.
        (square >= 0.0 && self.start > 0.0).then(|| 2.0 * way / (self.start + square.sqrt()))
    }

    /// The lead after a path; nothing where it has fallen to nothing.
    #[must_use]
    pub fn after(&self, way: f64) -> f64 {
        if self.change == 0.0 {
            return self.start;
        }
        (self.start * self.start + 2.0 * self.change * way).max(0.0).sqrt()
    }

    /// Minutes over a path at a steady speed; `None` if the lead falls to nothing before.
    #[must_use]
    pub fn minutes(&self, way: f64, rpm: f64) -> Option<f64> {
        Some(self.revolutions(way)? / rpm)
    }

    /// Minutes over a path under constant surface speed, while the radius goes from `r0` to `r1`.
    #[must_use]
    pub fn surface_minutes(&self, way: f64, speed: &SurfaceSpeed, r0: f64, r1: f64) -> Option<f64> {
        self.revolutions(way)?;
        let at = |n: f64| speed.per_rev(r0 + (r1 - r0) * (self.start * n + self.change * n * n / 2.0) / way);
        let mut sum = 0.0;
        for pair in speed.line_cuts(r0, r1).windows(2) {
            if let [a, b] = *pair
                && b > a
            {
                let (a, b) = (self.revolutions(a * way)?, self.revolutions(b * way)?);
                // Between cuts 1/n is quadratic in the revolutions, so Simpson's rule is exact.
                sum += (b - a) * (at(a) + 4.0 * at(f64::midpoint(a, b)) + at(b)) / 6.0;
            }
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_that_grows_and_one_that_falls() {
        let grows = Lead { start: 2.0, change: 0.5 };
        assert!((grows.revolutions(20.0).unwrap() - (24.0_f64.sqrt() - 2.0) / 0.5).abs() < 1e-12);
        let falls = Lead { start: 2.0, change: -0.2 };
        assert!((falls.revolutions(7.5).unwrap() - 5.0).abs() < 1e-12);
        assert_eq!(falls.revolutions(10.0), Some(10.0));
        assert_eq!(falls.revolutions(10.1), None);
        assert_eq!(Lead { start: 0.0, change: 1.0 }.revolutions(1.0), None);
        assert_eq!(Lead { start: 2.0, change: f64::NAN }.revolutions(1.0), None);
    }

    #[test]
    fn surface_speed_agrees_with_many_pieces() {
        let speed = SurfaceSpeed { surface: 100_000.0, max: 1200.0, min: 0.0 };
        for change in [0.0, 0.3, -0.05] {
            let lead = Lead { start: 2.0, change };
            for (r0, r1) in [(10.0, 20.0), (25.0, 5.0), (8.0, 8.0), (-3.0, 20.0)] {
                let exact = lead.surface_minutes(30.0, &speed, r0, r1).unwrap();
                let whole = lead.revolutions(30.0).unwrap();
                let steps = 100_000;
                let sum: f64 = (0..steps)
                    .map(|k| {
                        let n = whole * (f64::from(k) + 0.5) / f64::from(steps);
                        let s = (2.0 * n + change * n * n / 2.0) / 30.0;
                        whole / f64::from(steps) / speed.rpm(r0 + (r1 - r0) * s)
                    })
                    .sum();
                assert!((exact - sum).abs() / sum < 1e-6, "{change} {r0} {r1}: {exact} {sum}");
            }
        }
    }
}
