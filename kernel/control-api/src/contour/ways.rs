//! Paths to a contour and away from it: straight, along its normal, on a circle, on a line and a circle.
//!
//! *Invariant:* the path touches the contour in the direction of the contour, or is normal to it.

use super::plane::{Point, along, left, minus, times, touch, turn, turned};

/// Form of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathShape {
    /// Along the direction of the contour.
    Straight,
    /// At a right angle to it.
    Normal,
    /// On a circle that touches it.
    Circle,
    /// On a circle that touches it, and a line that touches the circle.
    LineAndCircle,
}

/// How large a path is, and on which side of the contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathDimensions {
    /// Length of a straight path, not negative; radius of a circle of the tool centre, negative on the other side of
    /// its path.
    pub size: f64,
    /// The tool is on the left of the contour.
    pub on_left: bool,
    /// Distance of the tool centre from the contour, not negative.
    pub beside: f64,
    /// Degrees of a circle.
    pub angle: f64,
}

/// The circle of a path about its centre.
struct TangentCircle {
    center: Point,
    /// Radius on the contour; the tool centre moves on a circle with the size of the path.
    radius: f64,
    /// The centre is on the left.
    on_left: bool,
}

impl PathDimensions {
    fn of(self, heading: Point) -> Point {
        if self.on_left { left(heading) } else { times(left(heading), -1.0) }
    }

    /// The circle that is tangent to the path of the tool centre beside a point. None if the compensated tool is larger
    /// than a circle on the other side.
    fn round(self, at: Point, heading: Point) -> Option<TangentCircle> {
        let signed = self.size + self.beside;
        let center = along(at, self.of(heading), signed);
        (signed * self.size > 0.0).then(|| TangentCircle {
            center,
            radius: signed.abs(),
            on_left: self.on_left == (self.size > 0.0),
        })
    }

    /// Where a path that leads the tool centre to a point of its circle is on the contour.
    fn on_contour(self, round: &TangentCircle, point: Point) -> Point {
        along(round.center, minus(point, round.center), round.radius / self.size.abs())
    }
}

impl TangentCircle {
    /// The radius of an arc of its circle, negative for more than half of it.
    fn radius_between(&self, from: Point, to: Point) -> f64 {
        let around = turn(minus(from, self.center), minus(to, self.center));
        let longer = if self.on_left { around < 0.0 } else { around > 0.0 };
        if longer { -self.radius } else { self.radius }
    }
}

/// A path to a contour. Points are those of the contour, which the tool centre passes at its distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ApproachPath {
    /// Where its last part begins.
    pub begin: Point,
    /// The last part, if it is an arc.
    pub arc: Option<RadiusArc>,
    /// The compensation begins with the last part.
    pub begins_plain: bool,
    /// Direction at its end.
    pub heading: Point,
}

/// An arc of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadiusArc {
    /// Negative for more than half a circle.
    pub radius: f64,
    pub clockwise: bool,
}

/// A path from a point of the tool centre to a contour, which begins at a point with a direction; none if the size does
/// not fit.
pub fn approach(
    way: PathShape,
    from: Point,
    (to, heading): (Point, Point),
    side: PathDimensions,
) -> Option<ApproachPath> {
    if side.size == 0.0 {
        return None;
    }
    let straight = |begin, begins_plain, heading| Some(ApproachPath { begin, arc: None, begins_plain, heading });
    let circle = match way {
        PathShape::Straight => return straight(along(to, heading, -side.size), false, heading),
        PathShape::Normal => {
            let across = side.of(heading);
            return straight(along(to, across, side.size + side.beside), true, times(across, -1.0));
        }
        PathShape::Circle | PathShape::LineAndCircle => side.round(to, heading)?,
    };
    let begin = if way == PathShape::Circle {
        let back = turned(minus(to, circle.center), if circle.on_left { -side.angle } else { side.angle });
        along(circle.center, back, 1.0)
    } else {
        side.on_contour(&circle, touch(from, circle.center, side.size.abs(), !circle.on_left)?)
    };
    let arc = RadiusArc { radius: circle.radius_between(begin, to), clockwise: !circle.on_left };
    Some(ApproachPath { begin, arc: Some(arc), begins_plain: false, heading })
}

/// A path from a contour. Points that follow an arc with compensation are those of the contour, others of the tool
/// centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Departure {
    /// A straight line.
    Line {
        /// Where the line ends.
        to: Point,
        /// Direction of the line.
        heading: Point,
    },
    /// A circle.
    Arc {
        /// Where the circle ends.
        to: Point,
        /// The circle.
        arc: RadiusArc,
        /// Direction at the end.
        heading: Point,
    },
    /// A circle, then a straight line tangent to it.
    ArcAndLine {
        /// Where the line begins.
        leave: Point,
        /// The circle.
        arc: RadiusArc,
        /// Where the line ends.
        to: Point,
    },
}

/// A path from the end of a contour and its direction there; only a path on a line and a circle goes to `goal`. None if
/// that is inside the circle, or if the tool is larger than a circle on the other side.
pub fn depart(way: PathShape, (from, heading): (Point, Point), goal: Point, side: PathDimensions) -> Option<Departure> {
    let across = side.of(heading);
    Some(match way {
        PathShape::Straight => {
            Departure::Line { to: along(along(from, across, side.beside), heading, side.size), heading }
        }
        PathShape::Normal => Departure::Line { to: along(from, across, side.size + side.beside), heading: across },
        PathShape::Circle => {
            let circle = side.round(from, heading)?;
            let angle = if circle.on_left { side.angle } else { -side.angle };
            let to = along(circle.center, turned(minus(from, circle.center), angle), 1.0);
            let radius = if side.angle > 180.0 { -circle.radius } else { circle.radius };
            Departure::Arc {
                to,
                arc: RadiusArc { radius, clockwise: !circle.on_left },
                heading: turned(heading, angle),
            }
        }
        PathShape::LineAndCircle => {
            let circle = side.round(from, heading)?;
            // Seen from the end the same as an approach, in the opposite direction.
            let touched = touch(goal, circle.center, side.size.abs(), circle.on_left)?;
            let leave = side.on_contour(&circle, touched);
            let arc = RadiusArc { radius: circle.radius_between(from, leave), clockwise: !circle.on_left };
            Departure::ArcAndLine { leave, arc, to: goal }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const EAST: Point = [1.0, 0.0];

    fn near(a: Point, b: Point) {
        assert!(libm::hypot(a[0] - b[0], a[1] - b[1]) < 1e-9, "{a:?} {b:?}");
    }

    fn arc_to(way: PathShape, from: Point, side: PathDimensions) -> (Point, f64, bool) {
        let to = approach(way, from, ([0.0, 0.0], EAST), side).unwrap();
        let arc = to.arc.unwrap();
        (to.begin, arc.radius, arc.clockwise)
    }

    #[test]
    fn a_quarter_to_and_from_a_line_along_x() {
        let side = PathDimensions { size: 5.0, on_left: true, beside: 0.0, angle: 90.0 };
        let (begin, radius, clockwise) = arc_to(PathShape::Circle, [-20.0, 20.0], side);
        near(begin, [-5.0, 5.0]);
        assert_eq!((radius, clockwise), (5.0, false));
        let Some(Departure::Arc { to, arc, heading }) = depart(PathShape::Circle, ([0.0, 0.0], EAST), [0.0, 0.0], side)
        else {
            panic!("no arc")
        };
        near(to, [5.0, 5.0]);
        near(heading, [0.0, 1.0]);
        assert_eq!((arc.radius, arc.clockwise), (5.0, false));
        let none = PathDimensions { size: 0.0, ..side };
        assert_eq!(approach(PathShape::Straight, [0.0, 0.0], ([0.0, 0.0], EAST), none), None);
        assert_eq!(depart(PathShape::LineAndCircle, ([0.0, 0.0], EAST), [0.0, 4.0], side), None);
    }

    /// The circle of the tool centre has the size of the path, so that of the contour is larger by the tool.
    #[test]
    fn circles_are_those_of_the_tool_centre() {
        let side = PathDimensions { size: 8.0, on_left: true, beside: 6.0, angle: 90.0 };
        let (begin, radius, _) = arc_to(PathShape::Circle, [-40.0, 30.0], side);
        near(begin, [-14.0, 14.0]);
        assert_eq!(radius, 14.0);
        // A line straight down at X-8 touches the circle of the tool centre about (0, 14) at its left.
        let (begin, radius, _) = arc_to(PathShape::LineAndCircle, [-8.0, 40.0], side);
        near(begin, [-14.0, 14.0]);
        assert_eq!(radius, 14.0);
        let Some(Departure::ArcAndLine { leave, arc, to }) =
            depart(PathShape::LineAndCircle, ([0.0, 0.0], EAST), [8.0, 40.0], side)
        else {
            panic!("no arc")
        };
        near(leave, [14.0, 14.0]);
        assert_eq!((arc.radius, to), (14.0, [8.0, 40.0]));
    }

    #[test]
    fn straight_ways_end_beside_the_contour() {
        let side = PathDimensions { size: 15.0, on_left: false, beside: 6.0, angle: 90.0 };
        let to = approach(PathShape::Normal, [0.0, -40.0], ([0.0, 0.0], EAST), side).unwrap();
        assert_eq!((to.begin, to.begins_plain), ([0.0, -21.0], true));
        let to = approach(PathShape::Straight, [0.0, -40.0], ([0.0, 0.0], EAST), side).unwrap();
        assert_eq!((to.begin, to.begins_plain), ([-15.0, 0.0], false));
        let end = |way| depart(way, ([0.0, 0.0], EAST), [0.0, 0.0], side);
        assert_eq!(end(PathShape::Straight), Some(Departure::Line { to: [15.0, -6.0], heading: EAST }));
        assert_eq!(end(PathShape::Normal), Some(Departure::Line { to: [0.0, -21.0], heading: [0.0, -1.0] }));
    }

    /// A negative radius comes from the other side of the path of the tool centre.
    #[test]
    fn a_negative_radius_turns_to_the_other_side() {
        let side = PathDimensions { size: -8.0, on_left: true, beside: 6.0, angle: 90.0 };
        let (begin, radius, clockwise) = arc_to(PathShape::Circle, [-40.0, -30.0], side);
        near(begin, [-2.0, -2.0]);
        assert_eq!((radius, clockwise), (2.0, true));
        let small = PathDimensions { size: -4.0, ..side };
        assert_eq!(approach(PathShape::Circle, [-40.0, -30.0], ([0.0, 0.0], EAST), small), None);
    }
}
