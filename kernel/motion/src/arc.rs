//! Circular moves in a plane: centre, sweep, length.
//!
//! Plane coordinates are `(first, second)` axis of the plane in right-handed order (XY, ZX, YZ), radius values.
//! Invariant: an [`Arc`] that exists has a positive radius and a sweep in the asked direction.

use std::f64::consts::TAU;

/// An arc from `start` to `end` around `center`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Centre.
    pub center: [f64; 2],
    /// Radius at the start.
    pub radius: f64,
    /// Angle of the start point.
    pub start_angle: f64,
    /// Signed sweep: negative clockwise. Never zero; a full circle is ±2π.
    pub sweep: f64,
}

/// Why a circle cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Error {
    /// Centre and start coincide.
    #[error("the radius is zero")]
    ZeroRadius,
    /// A radius was given but start and end coincide.
    #[error("start and end are the same point, a radius alone does not say which circle")]
    SamePoint,
    /// The chord is longer than the diameter.
    #[error("the end is {distance:.4} away, more than twice the radius {radius:.4}")]
    RadiusTooSmall {
        /// Length of the chord.
        distance: f64,
        /// Radius given.
        radius: f64,
    },
}

/// Arc by centre. The end point may lie off the circle; [`Arc::end_error`] tells how far.
///
/// # Errors
/// [`Error::ZeroRadius`].
pub fn by_center(start: [f64; 2], end: [f64; 2], center: [f64; 2], clockwise: bool) -> Result<Arc, Error> {
    let (sx, sy) = (start[0] - center[0], start[1] - center[1]);
    let radius = sx.hypot(sy);
    if radius < 1e-9 {
        return Err(Error::ZeroRadius);
    }
    let start_angle = sy.atan2(sx);
    let same = (end[0] - start[0]).abs() < 1e-9 && (end[1] - start[1]).abs() < 1e-9;
    let sweep = if same {
        TAU
    } else {
        let raw = (end[1] - center[1]).atan2(end[0] - center[0]) - start_angle;
        let raw = if clockwise { -raw } else { raw };
        let turn = raw.rem_euclid(TAU);
        if turn < 1e-9 { TAU } else { turn }
    };
    Ok(Arc { center, radius, start_angle, sweep: if clockwise { -sweep } else { sweep } })
}

/// Arc by radius: a positive radius takes the way of at most 180°, a negative one the longer way. A chord longer
/// than the diameter by no more than `tolerance` counts as the diameter.
///
/// # Errors
/// All variants of [`Error`].
pub fn by_radius(start: [f64; 2], end: [f64; 2], radius: f64, clockwise: bool, tolerance: f64) -> Result<Arc, Error> {
    let (dx, dy) = (end[0] - start[0], end[1] - start[1]);
    let distance = dx.hypot(dy);
    if distance < 1e-9 {
        return Err(Error::SamePoint);
    }
    let size = radius.abs();
    if size < 1e-9 {
        return Err(Error::ZeroRadius);
    }
    if distance > 2.0 * size + tolerance {
        return Err(Error::RadiusTooSmall { distance, radius: size });
    }
    let half = distance / 2.0;
    let height = (size * size - half * half).max(0.0).sqrt();
    // The centre of the short way lies left of the chord for counter-clockwise, right for clockwise.
    let side = if clockwise == (radius < 0.0) { 1.0 } else { -1.0 };
    let center =
        [start[0] + dx / 2.0 - side * dy / distance * height, start[1] + dy / 2.0 + side * dx / distance * height];
    by_center(start, end, center, clockwise)
}

impl Arc {
    /// Length along the circle.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.radius * self.sweep.abs()
    }

    /// Distance of `end` from the circle.
    #[must_use]
    pub fn end_error(&self, end: [f64; 2]) -> f64 {
        ((end[0] - self.center[0]).hypot(end[1] - self.center[1]) - self.radius).abs()
    }

    /// Adds full turns in the direction of the arc.
    #[must_use]
    pub fn with_turns(mut self, turns: u16) -> Self {
        self.sweep += self.sweep.signum() * TAU * f64::from(turns);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn quarter_by_center() {
        let arc = by_center([10.0, 0.0], [0.0, 10.0], [0.0, 0.0], false).unwrap();
        assert!(close(arc.sweep, PI / 2.0) && close(arc.length(), 5.0 * PI));
        let arc = by_center([10.0, 0.0], [0.0, 10.0], [0.0, 0.0], true).unwrap();
        assert!(close(arc.sweep, -1.5 * PI));
    }

    #[test]
    fn same_point_by_center_is_a_full_circle() {
        let arc = by_center([1.0, 0.0], [1.0, 0.0], [0.0, 0.0], true).unwrap();
        assert!(close(arc.sweep, -TAU));
    }

    #[test]
    fn radius_takes_the_short_way_and_negative_the_long_way() {
        for (clockwise, radius, center, sweep) in [
            (false, 5.0, [0.0, 0.0], PI / 2.0),
            (true, -5.0, [0.0, 0.0], -1.5 * PI),
            (true, 5.0, [5.0, 5.0], -PI / 2.0),
            (false, -5.0, [5.0, 5.0], 1.5 * PI),
        ] {
            let arc = by_radius([5.0, 0.0], [0.0, 5.0], radius, clockwise, 0.0).unwrap();
            assert!(close(arc.sweep, sweep), "{clockwise} {radius}: {arc:?}");
            assert!(
                close(arc.center[0], center[0]) && close(arc.center[1], center[1]),
                "{clockwise} {radius}: {arc:?}"
            );
        }
    }

    #[test]
    fn impossible_circles_are_refused() {
        assert_eq!(by_center([0.0, 0.0], [1.0, 0.0], [0.0, 0.0], true), Err(Error::ZeroRadius));
        assert_eq!(by_radius([0.0, 0.0], [0.0, 0.0], 1.0, true, 0.0), Err(Error::SamePoint));
        assert!(matches!(by_radius([0.0, 0.0], [3.0, 0.0], 1.0, true, 0.01), Err(Error::RadiusTooSmall { .. })));
        assert!(by_radius([0.0, 0.0], [2.005, 0.0], 1.0, true, 0.01).is_ok());
    }
}
