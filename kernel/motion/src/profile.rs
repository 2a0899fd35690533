//! Time of a move from standstill to standstill.

use crate::lookahead::LookAheadMove;

/// Seconds for `distance` at `speed` (per second) with `acceleration` (per second squared) at both ends; `None` =
/// speed changes take no time. Zero distance takes no time; a speed of zero or less gives infinity.
///
/// Trapezoid: `L ≥ v²/a ? L/v + v/a : 2·√(L/a)` (reference channel-synchronisation.md 3).
#[must_use]
pub fn stop_to_stop(distance: f64, speed: f64, acceleration: Option<f64>) -> f64 {
    let distance = distance.abs();
    if distance <= 0.0 {
        return 0.0;
    }
    if speed <= 0.0 {
        return f64::INFINITY;
    }
    match acceleration {
        Some(a) if a > 0.0 => {
            if distance >= speed * speed / a {
                distance / speed + speed / a
            } else {
                2.0 * (distance / a).sqrt()
            }
        }
        _ => distance / speed,
    }
}

/// The same; a `jerk` (per second cubed) makes it longer by the time in which the acceleration changes.
#[must_use]
pub fn stop_to_stop_smoothly(distance: f64, speed: f64, acceleration: Option<f64>, jerk: Option<f64>) -> f64 {
    let length = distance.abs();
    match (acceleration, jerk) {
        (Some(acceleration), Some(jerk)) if length > 0.0 && speed > 0.0 => {
            LookAheadMove { length, speed, acceleration, jerk, corner: 0.0 }.alone()
        }
        _ => stop_to_stop(distance, speed, acceleration),
    }
}

#[cfg(test)]
mod tests {
    use super::{stop_to_stop, stop_to_stop_smoothly};

    #[test]
    fn jerk_adds_its_rise() {
        assert!((stop_to_stop_smoothly(100.0, 100.0, Some(1000.0), Some(50_000.0)) - 1.12).abs() < 1e-12);
        assert_eq!(stop_to_stop_smoothly(0.0, 100.0, Some(1000.0), Some(50_000.0)), 0.0);
        assert_eq!(stop_to_stop_smoothly(100.0, 100.0, None, Some(50_000.0)), 1.0);
    }

    #[test]
    fn constant_speed_without_acceleration() {
        assert_eq!(stop_to_stop(100.0, 50.0, None), 2.0);
        assert_eq!(stop_to_stop(0.0, 0.0, None), 0.0);
        assert_eq!(stop_to_stop(1.0, 0.0, None), f64::INFINITY);
    }

    #[test]
    fn trapezoid_and_triangle() {
        // 100 mm at 6000 mm/min and 1000 mm/s²: 1.0 s + 0.1 s
        assert!((stop_to_stop(100.0, 100.0, Some(1000.0)) - 1.1).abs() < 1e-12);
        assert!((stop_to_stop(2.5, 100.0, Some(1000.0)) - 0.1).abs() < 1e-12);
    }
}
