//! Directions at the ends of circles.

use super::plane::{Point, left, minus, times};

pub use counterpoint_motion::contour::tangent::{Tangent, tangent};

/// Direction, not of length one, in which a circle about a centre continues at a point.
pub fn heading_on(center: Point, point: Point, clockwise: bool) -> Point {
    let tangent = left(minus(point, center));
    if clockwise { times(tangent, -1.0) } else { tangent }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clockwise_circle_goes_down_on_its_right() {
        assert_eq!(heading_on([0.0, 0.0], [10.0, 0.0], true), [0.0, -10.0]);
    }
}
