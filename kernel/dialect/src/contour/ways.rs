//! Ways to a contour and away from it: straight, along its normal, on a circle, on a line and a circle.
//!
//! *Invariant:* the way touches the contour in the direction of the contour, or is normal to it.

use super::plane::{Point, along, left, minus, times, touch, turn, turned};

/// Form of a way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PathShape {
    /// Along the direction of the contour.
    Straight,
    /// At a right angle to it.
    Normal,
    /// On a circle that touches it.
    Circle,
    /// On a circle that touches it, and a line that touches the circle.
    LineAndCircle,
}

/// How large a way is, and on which side of the contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side {
    /// Length of a straight way, radius of a circle; not negative.
    pub(crate) size: f64,
    /// The tool goes on the left of the contour.
    pub(crate) on_left: bool,
    /// Degrees of a circle.
    pub(crate) angle: f64,
}

impl Side {
    fn of(self, heading: Point) -> Point {
        if self.on_left { left(heading) } else { times(left(heading), -1.0) }
    }
}

/// A way to a contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Approach {
    /// Where its last part begins.
    pub(crate) begin: Point,
    /// Radius of that part, negative for an arc of more than half a circle; none if it is a line.
    pub(crate) radius: Option<f64>,
    /// Direction at its end.
    pub(crate) heading: Point,
}

/// A way from a point to a contour, which begins at a point with a direction; none if the size does not fit.
pub(crate) fn approach(way: PathShape, from: Point, (to, heading): (Point, Point), side: Side) -> Option<Approach> {
    if side.size == 0.0 {
        return None;
    }
    let across = side.of(heading);
    let center = along(to, across, side.size);
    let (begin, heading) = match way {
        PathShape::Straight => return Some(Approach { begin: along(to, heading, -side.size), radius: None, heading }),
        PathShape::Normal => return Some(Approach { begin: center, radius: None, heading: times(across, -1.0) }),
        PathShape::Circle => {
            let back = turned(minus(to, center), if side.on_left { -side.angle } else { side.angle });
            (along(center, back, 1.0), heading)
        }
        PathShape::LineAndCircle => (touch(from, center, side.size, !side.on_left)?, heading),
    };
    let around = turn(minus(begin, center), minus(to, center));
    let longer = if side.on_left { around < 0.0 } else { around > 0.0 };
    Some(Approach { begin, radius: Some(if longer { -side.size } else { side.size }), heading })
}

/// A way from a contour. Radii are negative for arcs of more than half a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Departure {
    Line { to: Point, heading: Point },
    Arc { to: Point, radius: f64, heading: Point },
    ArcAndLine { leave: Point, radius: f64, to: Point },
}

/// A way from the end of a contour and its direction there; only one on a line and a circle goes to `goal`. None if that is
/// inside the circle.
pub(crate) fn depart(way: PathShape, (from, heading): (Point, Point), goal: Point, side: Side) -> Option<Departure> {
    let across = side.of(heading);
    let center = along(from, across, side.size);
    Some(match way {
        PathShape::Straight => Departure::Line { to: along(from, heading, side.size), heading },
        PathShape::Normal => Departure::Line { to: center, heading: across },
        PathShape::Circle => {
            let angle = if side.on_left { side.angle } else { -side.angle };
            let to = along(center, turned(minus(from, center), angle), 1.0);
            let radius = if side.angle > 180.0 { -side.size } else { side.size };
            Departure::Arc { to, radius, heading: turned(heading, angle) }
        }
        PathShape::LineAndCircle => {
            // Seen from the end the same as an approach, the other way round.
            let leave = touch(goal, center, side.size, side.on_left)?;
            let longer = turn(minus(from, center), minus(leave, center)) < 0.0;
            let radius = if longer == side.on_left { -side.size } else { side.size };
            Departure::ArcAndLine { leave, radius, to: goal }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_to_and_from_a_line_along_x() {
        let side = Side { size: 5.0, on_left: true, angle: 90.0 };
        let near = |a: Point, b: Point| assert!(libm::hypot(a[0] - b[0], a[1] - b[1]) < 1e-9, "{a:?} {b:?}");
        let to = approach(PathShape::Circle, [-20.0, 20.0], ([0.0, 0.0], [1.0, 0.0]), side).unwrap();
        near(to.begin, [-5.0, 5.0]);
        assert_eq!((to.radius, to.heading), (Some(5.0), [1.0, 0.0]));
        let Some(Departure::Arc { to, radius, heading }) =
            depart(PathShape::Circle, ([0.0, 0.0], [1.0, 0.0]), [0.0, 0.0], side)
        else {
            panic!("no arc")
        };
        near(to, [5.0, 5.0]);
        near(heading, [0.0, 1.0]);
        assert_eq!(radius, 5.0);
        assert_eq!(
            approach(PathShape::Straight, [0.0, 0.0], ([0.0, 0.0], [1.0, 0.0]), Side { size: 0.0, ..side }),
            None
        );
        assert_eq!(depart(PathShape::LineAndCircle, ([0.0, 0.0], [1.0, 0.0]), [0.0, 4.0], side), None);
    }
}
