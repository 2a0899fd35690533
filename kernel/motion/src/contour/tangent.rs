//! Circles that continue in the direction of the preceding element.
//!
//! *Invariant:* a circle that exists ends at its end point.

use super::element::{Spot, cross, dot, plus};

/// The path from a point in a direction to another point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tangent {
    /// The point lies straight ahead.
    Line,
    /// The point lies straight behind: no circle leads there.
    Back,
    /// A circle.
    Arc {
        /// Its centre.
        center: Spot,
        /// Its radius; negative for an arc of more than half a circle.
        radius: f64,
        /// It is clockwise.
        clockwise: bool,
    },
}

/// The circle from a point in a direction of length one to another point.
#[must_use]
pub fn tangent(start: Spot, heading: Spot, to: Spot) -> Tangent {
    let chord = plus(to, start, -1.0);
    let (across, length) = (cross(heading, chord), dot(chord, chord));
    let back = dot(chord, heading) < 0.0;
    if across.abs() <= 1e-9 * length.max(1e-9) {
        return if back { Tangent::Back } else { Tangent::Line };
    }
    let radius = length / (2.0 * across);
    let center = plus(start, [-heading[1], heading[0]], radius);
    Tangent::Arc { center, radius: if back { -radius.abs() } else { radius.abs() }, clockwise: radius < 0.0 }
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
    }
}
