//! Speed of a spindle under constant surface speed while the move of another channel drives it.
//!
//! A channel that feeds or dwells by revolutions of such a spindle needs the time of a number of revolutions.
//! *Invariant:* minutes increase with revolutions, and after the end of the move the speed stays at its final value.

use std::f64::consts::TAU;

use crate::surface_speed::SurfaceSpeed;

/// Bisection steps that determine a share of the move to the last bit.
const HALVINGS: usize = 60;

/// Radii closer to the axis than this count as this radius; also a relative change that counts as none.
const AXIS: f64 = 1e-9;

/// Change of the radius along the move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RadiusProgress {
    /// Linear in revolutions: the move itself has a feed per revolution.
    ByRevolution,
    /// Linear in time.
    ByTime,
}

/// A move that drives the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenSpeed {
    /// Surface speed of the spindle and its limits.
    pub speed: SurfaceSpeed,
    /// Radii at the start and at the end of the move.
    pub radii: [f64; 2],
    /// Minutes of the move, above 0.
    pub minutes: f64,
    /// Change of the radius.
    pub progress: RadiusProgress,
}

impl DrivenSpeed {
    fn radius(&self, share: f64) -> f64 {
        let [from, to] = self.radii;
        from + (to - from) * share
    }

    /// Speed in rev/min this many minutes after the start of the move.
    #[must_use]
    pub fn rpm(&self, elapsed: f64) -> f64 {
        self.speed.rpm(self.radius(self.share(elapsed)))
    }

    /// Minutes of this many revolutions that start this many minutes after the start of the move.
    #[must_use]
    pub fn minutes_of(&self, elapsed: f64, revolutions: f64) -> f64 {
        let begin = self.share(elapsed);
        let left = self.revolutions(begin, 1.0);
        if revolutions >= left {
            let rest = (self.minutes - elapsed).max(0.0);
            return rest + (revolutions - left) * self.speed.per_rev(self.radius(1.0));
        }
        let end = bisect(begin, |share| self.revolutions(begin, share) < revolutions);
        self.elapsed(end) - self.elapsed(begin)
    }

    /// Share of the move that is complete after this many minutes.
    fn share(&self, elapsed: f64) -> f64 {
        if elapsed <= 0.0 {
            0.0
        } else if elapsed >= self.minutes {
            1.0
        } else {
            match self.progress {
                RadiusProgress::ByTime => elapsed / self.minutes,
                RadiusProgress::ByRevolution => bisect(0.0, |share| self.elapsed(share) < elapsed),
            }
        }
    }

    /// Minutes after which this share of the move is complete.
    fn elapsed(&self, share: f64) -> f64 {
        match self.progress {
            RadiusProgress::ByTime => share * self.minutes,
            RadiusProgress::ByRevolution => self.revolutions(0.0, 1.0) * self.evenly(share),
        }
    }

    /// Minutes for this share of the move if the whole move took one revolution.
    fn evenly(&self, share: f64) -> f64 {
        self.speed.line_minutes(self.radii[0], self.radius(share), share, 1.0)
    }

    /// Revolutions between two shares of the move.
    fn revolutions(&self, from: f64, to: f64) -> f64 {
        match self.progress {
            RadiusProgress::ByRevolution => (to - from) * self.minutes / self.evenly(1.0),
            RadiusProgress::ByTime => {
                let cuts = self.speed.line_cuts(self.radii[0], self.radii[1]);
                let pieces = cuts.windows(2).filter_map(|piece| match *piece {
                    [a, b] => Some((a.max(from), b.min(to))).filter(|(a, b)| b > a),
                    _ => None,
                });
                self.minutes * pieces.map(|(a, b)| self.turns_of_piece(a, b)).sum::<f64>()
            }
        }
    }

    /// Mean speed in a piece of the move, times its share: between the limits of the speed, the speed is `v / (2π·r)`.
    fn turns_of_piece(&self, from: f64, to: f64) -> f64 {
        let middle = self.speed.rpm(self.radius(f64::midpoint(from, to)));
        let [start, end] = [from, to].map(|share| self.radius(share).abs().max(AXIS));
        if middle >= self.speed.max || middle <= self.speed.min || (end / start - 1.0).abs() < AXIS {
            return middle * (to - from);
        }
        let mean = self.speed.surface / TAU * libm::log(end / start) / (end - start);
        mean * (to - from)
    }
}

/// The share between `low` and 1 up to which a condition holds that holds at `low`.
fn bisect(low: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (low, 1.0);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if holds(middle) { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same in small steps of time: minutes of the revolutions, and the speed at their start.
    fn by_steps(driven: &DrivenSpeed, elapsed: f64, revolutions: f64) -> (f64, f64) {
        const STEPS: f64 = 20_000.0;
        let step = driven.minutes / STEPS;
        let total = driven.minutes
            / (0..1000)
                .map(|at| driven.speed.per_rev(driven.radius((f64::from(at) + 0.5) / 1000.0)) / 1000.0)
                .sum::<f64>();
        let (mut time, mut share, mut left, mut began) = (0.0, 0.0_f64, revolutions, None);
        while left > 0.0 {
            let rpm = driven.speed.rpm(driven.radius(share.min(1.0)));
            if time >= elapsed {
                began.get_or_insert((time, rpm));
                left -= rpm * step;
            }
            share += match driven.progress {
                RadiusProgress::ByTime => step / driven.minutes,
                RadiusProgress::ByRevolution => rpm * step / total,
            };
            time += step;
        }
        let (begin, rpm) = began.unwrap();
        (time - begin, rpm)
    }

    #[test]
    fn time_of_revolutions_is_that_of_small_steps() {
        let mut checked = 0;
        for progress in [RadiusProgress::ByTime, RadiusProgress::ByRevolution] {
            for radii in [[32.0, 1.0], [32.0, -0.5], [5.0, 60.0], [20.0, 20.0]] {
                for (max, min) in [(2500.0, 0.0), (1200.0, 600.0)] {
                    let speed = SurfaceSpeed { surface: 180_000.0, max, min };
                    let driven = DrivenSpeed { speed, radii, minutes: 0.2, progress };
                    for elapsed in [0.0, 0.07, 0.19, 0.2, 0.5] {
                        for revolutions in [1.0, 40.0, 150.0, 800.0] {
                            let (minutes, rpm) = by_steps(&driven, elapsed, revolutions);
                            let near = |one: f64, other: f64| (one - other).abs() < 4e-3 * other + 1e-4;
                            let said = driven.minutes_of(elapsed, revolutions);
                            assert!(near(said, minutes), "{driven:?} {elapsed} {revolutions}: {said} {minutes}");
                            assert!(near(driven.rpm(elapsed), rpm), "{driven:?} {elapsed}: {rpm}");
                            checked += 1;
                        }
                    }
                }
            }
        }
        assert_eq!(checked, 320);
    }
}
