//! The fraction of a path that is complete after a fraction of its planned time, if the feed follows a clock or a
//! spindle.

use super::invert;
use crate::arc::PlaneArc;
use crate::driven_speed::DrivenSpeed;
use crate::surface_speed::SurfaceSpeed;
use crate::thread::Lead;

/// How the spindle turns during a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpindleRotation {
    /// Constant rev/min.
    Fixed(f64),
    /// Driven by the current radius of the move itself.
    Surface(SurfaceSpeed),
    /// Driven by the move of another channel, which started this many minutes earlier.
    Driven(DrivenSpeed, f64),
}

impl SpindleRotation {
    /// Speed in rev/min at the start of the move, while the channel is at this radius.
    #[must_use]
    pub fn rpm(&self, radius: f64) -> f64 {
        match self {
            Self::Fixed(rpm) => *rpm,
            Self::Surface(surface) => surface.rpm(radius),
            Self::Driven(driven, elapsed) => driven.rpm(*elapsed),
        }
    }
}

/// Progress along the path in the planned time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FeedSchedule {
    /// At constant speed.
    Steady,
    /// By revolutions of a spindle along a line, or along a path on which the radius has no effect.
    Turning {
        /// Feed per revolution, or the lead of a thread.
        lead: Lead,
        /// Length along which the lead is measured.
        way: f64,
        /// Radii at the start and at the end.
        radii: [f64; 2],
        /// The spindle.
        spindle: SpindleRotation,
    },
    /// Along an arc at a feed per revolution under constant surface speed.
    SurfaceArc {
        /// The arc.
        arc: PlaneArc,
        /// Coordinate of the plane that is the radius of the part, 0 or 1.
        radial: usize,
        /// The spindle.
        speed: SurfaceSpeed,
    },
}

impl FeedSchedule {
    /// The fraction of the path that is complete after this fraction of the planned time, both from 0 to 1.
    #[must_use]
    pub fn path(&self, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        if time >= 1.0 {
            return 1.0;
        }
        match self {
            Self::Steady => time,
            _ => {
                let whole = self.minutes(1.0);
                if whole > 0.0 && whole.is_finite() { invert(time * whole, |path| self.minutes(path)) } else { time }
            }
        }
    }

    /// Minutes after which this fraction of the path is complete; for a steady schedule the fraction itself.
    fn minutes(&self, path: f64) -> f64 {
        match self {
            Self::Steady => path,
            Self::Turning { lead, way, radii: [from, to], spindle } => {
                let part = way * path;
                match spindle {
                    SpindleRotation::Fixed(rpm) => lead.minutes(part, *rpm),
                    SpindleRotation::Surface(speed) => {
                        lead.surface_minutes(part, speed, *from, from + (to - from) * path).filter(|_| part > 0.0)
                    }
                    SpindleRotation::Driven(driven, elapsed) => {
                        lead.revolutions(part).map(|revolutions| driven.minutes_of(*elapsed, revolutions))
                    }
                }
                .unwrap_or(0.0)
            }
            Self::SurfaceArc { arc, radial, speed } => {
                speed.arc_minutes(&PlaneArc { sweep: arc.sweep * path, ..*arc }, *radial, 1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arc;
    use crate::driven_speed::RadiusProgress;

    const SPEED: SurfaceSpeed = SurfaceSpeed { surface: 200_000.0, max: 3000.0, min: 0.0 };

    /// The path by integration in small time steps: its rate is the lead times the spindle speed.
    fn by_steps(rate: impl Fn(f64, f64) -> f64, minutes: f64, time: f64) -> f64 {
        const STEPS: u32 = 20_000;
        let step = minutes * time / f64::from(STEPS);
        let mut path = 0.0;
        for at in 0..STEPS {
            let now = f64::from(at) * step;
            let half = path + 0.5 * step * rate(path, now);
            path += step * rate(half, now + 0.5 * step);
        }
        path
    }

    #[test]
    fn facing_under_constant_surface_speed_is_not_linear() {
        // From radius 25 to 7 without a limit in between: the square of the radius is linear in time, so at half the
        // time the radius is √((25² + 7²) / 2) = 18.357 and not 16.
        let lead = Lead { start: 0.2, change: 0.0 };
        let facing = FeedSchedule::Turning {
            lead,
            way: 18.0,
            radii: [25.0, 7.0],
            spindle: SpindleRotation::Surface(SurfaceSpeed { max: f64::INFINITY, ..SPEED }),
        };
        let radius = 25.0 - 18.0 * facing.path(0.5);
        assert!((radius - ((25.0_f64.powi(2) + 7.0_f64.powi(2)) / 2.0).sqrt()).abs() < 1e-12, "{radius}");
    }

    #[test]
    fn lines_and_threads_agree_with_small_steps() {
        let driven = DrivenSpeed { speed: SPEED, radii: [30.0, 12.0], minutes: 0.05, progress: RadiusProgress::ByTime };
        let spindles =
            [SpindleRotation::Fixed(800.0), SpindleRotation::Surface(SPEED), SpindleRotation::Driven(driven, 0.01)];
        for spindle in spindles {
            for change in [0.0, 0.05, -0.004] {
                for radii in [[25.0, 3.0], [8.0, 30.0], [10.0, 10.0]] {
                    let (lead, way) = (Lead { start: 0.5, change }, 22.0);
                    let schedule = FeedSchedule::Turning { lead, way, radii, spindle };
                    let minutes = schedule.minutes(1.0);
                    let rate = |path: f64, now: f64| {
                        let radius = radii[0] + (radii[1] - radii[0]) * path;
                        let rpm = match spindle {
                            SpindleRotation::Driven(driven, elapsed) => driven.rpm(elapsed + now),
                            other => other.rpm(radius),
                        };
                        lead.after(way * path) * rpm / way
                    };
                    for time in [0.1, 0.5, 0.85] {
                        let (exact, stepped) = (schedule.path(time), by_steps(rate, minutes, time));
                        assert!((exact - stepped).abs() < 1e-6, "{schedule:?} {time}: {exact} {stepped}");
                    }
                    assert_eq!([schedule.path(0.0), schedule.path(1.0)], [0.0, 1.0]);
                }
            }
        }
    }

    #[test]
    fn arcs_under_constant_surface_speed_agree_with_small_steps() {
        let made = arc::by_center([0.0, 3.0], [20.0, 3.0], [10.0, 6.0], false).unwrap();
        for radial in [0, 1] {
            let schedule = FeedSchedule::SurfaceArc { arc: made, radial, speed: SPEED };
            let minutes = schedule.minutes(1.0);
            let rate = |path: f64, _: f64| {
                let angle = made.start_angle + made.sweep * path;
                let place = [made.center[0] + made.radius * angle.cos(), made.center[1] + made.radius * angle.sin()];
                SPEED.rpm(place[radial]) / made.length()
            };
            for time in [0.2, 0.5, 0.9] {
                let (exact, stepped) = (schedule.path(time), by_steps(rate, minutes, time));
                assert!((exact - stepped).abs() < 1e-6, "{radial} {time}: {exact} {stepped}");
            }
        }
    }
}
