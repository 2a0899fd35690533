//! Circles that continue in the direction of what is before them.
//!
//! *Invariant:* a circle that exists ends at its end point.

use super::plane::{Point, along, dot, left, minus, times};

/// What leads from a point in a direction to another point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tangent {
    /// The point lies straight ahead.
    Line,
    /// The point lies straight behind: no circle leads there.
    Back,
    Arc {
        center: Point,
        /// Negative for an arc of more than half a circle.
        radius: f64,
        clockwise: bool,
    },
}

/// The circle from a point in a direction to another point.
pub(crate) fn tangent(start: Point, heading: Point, to: Point) -> Tangent {
    let chord = minus(to, start);
    let (across, length) = (chord[1] * heading[0] - chord[0] * heading[1], dot(chord, chord));
    let back = dot(chord, heading) < 0.0;
    if across.abs() <= 1e-9 * length.max(1e-9) {
        return if back { Tangent::Back } else { Tangent::Line };
    }
    let radius = length / (2.0 * across);
    let center = along(start, left(heading), radius);
    Tangent::Arc { center, radius: if back { -radius.abs() } else { radius.abs() }, clockwise: radius < 0.0 }
}

/// Direction, not of length one, in which a circle about a centre goes on at a point.
pub(crate) fn heading_on(center: Point, point: Point, clockwise: bool) -> Point {
    let tangent = left(minus(point, center));
    if clockwise { times(tangent, -1.0) } else { tangent }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_goes_on_in_the_direction_before_it() {
        let along_x = [1.0, 0.0];
        let quarter = tangent([0.0, 0.0], along_x, [10.0, 10.0]);
        assert_eq!(quarter, Tangent::Arc { center: [0.0, 10.0], radius: 10.0, clockwise: false });
        let three_quarters = tangent([0.0, 0.0], along_x, [-10.0, -10.0]);
        assert_eq!(three_quarters, Tangent::Arc { center: [0.0, -10.0], radius: -10.0, clockwise: true });
        assert_eq!(tangent([0.0, 0.0], along_x, [5.0, 0.0]), Tangent::Line);
        assert_eq!(tangent([0.0, 0.0], along_x, [-5.0, 0.0]), Tangent::Back);
        assert_eq!(heading_on([0.0, 0.0], [10.0, 0.0], true), [0.0, -10.0]);
    }
}
