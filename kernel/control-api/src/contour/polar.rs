//! Points by their distance and angle from a pole.
//!
//! *Invariant:* angles are degrees, and directions at multiples of 90 are exact.

use super::plane::{Point, along, minus};
use crate::numeric::{cosine, sine};

/// Where a point is as seen from a pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarPoint {
    /// Distance from the pole.
    pub radius: f64,
    /// Degrees.
    pub angle: f64,
}

/// The direction of an angle, degrees.
pub fn towards(degrees: f64) -> Point {
    [cosine(degrees), sine(degrees)]
}

impl PolarPoint {
    /// Of a point.
    pub fn of(pole: Point, point: Point) -> Self {
        let from = minus(point, pole);
        Self { radius: libm::hypot(from[0], from[1]), angle: libm::atan2(from[1], from[0]).to_degrees() }
    }

    /// The point.
    pub fn point(self, pole: Point) -> Point {
        along(pole, towards(self.angle), self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_comes_back() {
        assert_eq!(PolarPoint::of([1.0, 2.0], [1.0, 7.0]), PolarPoint { radius: 5.0, angle: 90.0 });
        assert_eq!(PolarPoint { radius: 5.0, angle: 180.0 }.point([1.0, 2.0]), [-4.0, 2.0]);
    }
}
