//! Points and directions of the working plane.
//!
//! *Invariant:* a result that does not exist is none, never a number that is not finite.

use crate::numeric::{cosine, sine};

/// A point or a vector.
pub type Point = [f64; 2];

/// The vector from `b` to `a`.
pub fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// A vector whose length is multiplied.
pub fn times(a: Point, factor: f64) -> Point {
    [a[0] * factor, a[1] * factor]
}

/// A point at a distance from another.
pub fn along(from: Point, direction: Point, way: f64) -> Point {
    [from[0] + direction[0] * way, from[1] + direction[1] * way]
}

/// Turned to the left by a quarter.
pub fn left(a: Point) -> Point {
    [-a[1], a[0]]
}

/// Positive if the second turns to the left of the first.
pub fn turn(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Length of a vector.
pub fn length(a: Point) -> f64 {
    libm::hypot(a[0], a[1])
}

/// Direction of a vector that has one.
pub fn direction(a: Point) -> Option<Point> {
    let length = length(a);
    (length.is_finite() && length > 1e-9).then(|| times(a, 1.0 / length))
}

/// Centre of a circle by its ends and radius; a negative radius takes the longer path.
pub fn center_by_radius(from: Point, to: Point, radius: f64, clockwise: bool) -> Option<Point> {
    let chord = minus(to, from);
    let half = length(chord) / 2.0;
    let across = left(direction(chord)?);
    let rise = libm::sqrt((radius * radius - half * half).max(0.0));
    let rise = if clockwise == (radius < 0.0) { rise } else { -rise };
    Some(along(along(from, chord, 0.5), across, rise)).filter(|center| center.iter().all(|value| value.is_finite()))
}

/// Where a line to a circle touches it so that it continues around its centre.
pub fn touch(from: Point, center: Point, radius: f64, clockwise: bool) -> Option<Point> {
    let way = minus(center, from);
    let distance = length(way);
    if !(distance >= radius && distance > 0.0) {
        return None;
    }
    let open = libm::acos((-radius / distance).clamp(-1.0, 1.0));
    let angle = libm::atan2(way[1], way[0]) + if clockwise { open } else { -open };
    Some(along(center, [libm::cos(angle), libm::sin(angle)], radius))
}

/// A vector turned by degrees, to the left.
pub fn turned(a: Point, degrees: f64) -> Point {
    let (sine, cosine) = (sine(degrees), cosine(degrees));
    [a[0] * cosine - a[1] * sine, a[0] * sine + a[1] * cosine]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Point, b: Point) {
        assert!(length(minus(a, b)) < 1e-9, "{a:?} {b:?}");
    }

    #[test]
    fn centres_lie_on_the_side_of_the_direction() {
        // A quarter from (10,0) to (0,10) about the origin is counter-clockwise.
        near(center_by_radius([10.0, 0.0], [0.0, 10.0], 10.0, false).unwrap(), [0.0, 0.0]);
        near(center_by_radius([10.0, 0.0], [0.0, 10.0], 10.0, true).unwrap(), [10.0, 10.0]);
        near(center_by_radius([10.0, 0.0], [0.0, 10.0], -10.0, true).unwrap(), [0.0, 0.0]);
    }

    #[test]
    fn lines_touch_circles() {
        // From (0,-10) along X the circle about (0,0) is reached counter-clockwise at (0,-10).
        near(touch([-5.0, -10.0], [0.0, 0.0], 10.0, false).unwrap(), [0.0, -10.0]);
        near(touch([-5.0, 10.0], [0.0, 0.0], 10.0, true).unwrap(), [0.0, 10.0]);
        assert_eq!(touch([1.0, 0.0], [0.0, 0.0], 10.0, true), None);
    }
}
