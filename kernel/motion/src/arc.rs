//! Circular moves in a plane: centre, sweep, length.
//!
//! Plane coordinates are `(first, second)` axis of the plane in right-handed order (XY, ZX, YZ), radius values.
//! Angles come from `libm`, so that every machine gives the same bits.
//! *Invariant:* an [`PlaneArc`] that exists has a positive radius and a sweep in the asked direction.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{Point2, Vector2};

/// Turns of an arc at most.
pub const MOST_TURNS: f64 = 999.0;

/// An arc from `start` to `end` around `center`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneArc {
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
pub enum ArcError {
    /// Centre and start coincide.
    #[error("the radius is zero")]
    ZeroRadius,
    /// A radius was given but start and end coincide.
    #[error("start and end are the same point, a radius alone does not say which circle")]
    SamePoint,
    /// Three points of an arc lie in a line.
    #[error("its three points lie in a line")]
    Straight,
    /// An angle that no arc has.
    #[error("an angle of {angle} degrees makes no arc")]
    Angle {
        /// Angle given, degrees.
        angle: f64,
    },
    /// The chord is longer than the diameter.
    #[error("the end is {distance:.4} away, more than twice the radius {radius:.4}")]
    RadiusTooSmall {
        /// Length of the chord.
        distance: f64,
        /// Radius given.
        radius: f64,
    },
}

/// Arc by centre. The end point may lie off the circle; [`PlaneArc::end_error`] gives the distance.
///
/// # Errors
/// [`ArcError::ZeroRadius`].
pub fn by_center(start: [f64; 2], end: [f64; 2], center: [f64; 2], clockwise: bool) -> Result<PlaneArc, ArcError> {
    let [from, to, middle] = [start, end, center].map(Point2::from);
    let spoke = from - middle;
    let radius = spoke.norm();
    if radius < 1e-9 {
        return Err(ArcError::ZeroRadius);
    }
    let start_angle = angle(spoke);
    let same = (to - from).amax() < 1e-9;
    let sweep = if same {
        TAU
    } else {
        let raw = angle(to - middle) - start_angle;
        let turn = if clockwise { -raw } else { raw }.rem_euclid(TAU);
        if turn < 1e-9 { TAU } else { turn }
    };
    Ok(PlaneArc { center, radius, start_angle, sweep: if clockwise { -sweep } else { sweep } })
}

fn angle(v: Vector2<f64>) -> f64 {
    libm::atan2(v.y, v.x)
}

/// Arc by radius: a positive radius takes the path of at most 180°, a negative one the longer path. A chord longer than
/// the diameter by no more than `tolerance` counts as the diameter.
///
/// # Errors
/// All variants of [`ArcError`].
pub fn by_radius(
    start: [f64; 2],
    end: [f64; 2],
    radius: f64,
    clockwise: bool,
    tolerance: f64,
) -> Result<PlaneArc, ArcError> {
    let [from, to] = [start, end].map(Point2::from);
    let chord = to - from;
    let distance = chord.norm();
    if distance < 1e-9 {
        return Err(ArcError::SamePoint);
    }
    let size = radius.abs();
    if size < 1e-9 {
        return Err(ArcError::ZeroRadius);
    }
    if distance > 2.0 * size + tolerance {
        return Err(ArcError::RadiusTooSmall { distance, radius: size });
    }
    let half = distance / 2.0;
    let height = (size * size - half * half).max(0.0).sqrt();
    // The centre of the short path lies left of the chord for counter-clockwise, right for clockwise.
    let side = if clockwise == (radius < 0.0) { 1.0 } else { -1.0 };
    let left = Vector2::new(-chord.y, chord.x) / distance;
    let center: [f64; 2] = (from + chord / 2.0 + left * (side * height)).into();
    by_center(start, end, center, clockwise)
}

/// Arc from start to end that goes through `angle` degrees, less than a full turn: the angle determines the radius.
///
/// # Errors
/// [`ArcError::Angle`] for an angle of no turn or of one and more, [`ArcError::SamePoint`].
pub fn by_end_and_angle(start: [f64; 2], end: [f64; 2], angle: f64, clockwise: bool) -> Result<PlaneArc, ArcError> {
    let turn = angle.to_radians();
    if !(turn > 1e-9 && turn < TAU - 1e-9) {
        return Err(ArcError::Angle { angle });
    }
    let distance = (Point2::from(end) - Point2::from(start)).norm();
    let radius = distance / (2.0 * libm::sin(turn / 2.0));
    let radius = if turn > PI { -radius } else { radius };
    by_radius(start, end, radius, clockwise, radius.abs() * 1e-9)
}

/// Arc around `center` through `angle` degrees, which may be more than a turn, and where it ends.
///
/// # Errors
/// [`ArcError::Angle`] for an angle of nothing or of more than [`MOST_TURNS`] turns, [`ArcError::ZeroRadius`].
pub fn by_center_and_angle(
    start: [f64; 2],
    center: [f64; 2],
    angle: f64,
    clockwise: bool,
) -> Result<(PlaneArc, [f64; 2]), ArcError> {
    let turn = angle.to_radians();
    if !(turn > 1e-9 && turn <= TAU * MOST_TURNS) {
        return Err(ArcError::Angle { angle });
    }
    let whole = by_center(start, start, center, clockwise)?;
    let arc = PlaneArc { sweep: if clockwise { -turn } else { turn }, ..whole };
    let rest = turn % TAU;
    if !(1e-9..=TAU - 1e-9).contains(&rest) {
        return Ok((arc, start));
    }
    let at = whole.start_angle + arc.sweep;
    Ok((arc, [center[0] + arc.radius * libm::cos(at), center[1] + arc.radius * libm::sin(at)]))
}

impl PlaneArc {
    /// Whole turns before the last one, which is never empty.
    #[must_use]
    pub fn full_turns(&self) -> u16 {
        ((self.sweep.abs() - 1e-9) / TAU).clamp(0.0, MOST_TURNS) as u16
    }

    /// Length along the circle.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.radius * self.sweep.abs()
    }

    /// Distance of `end` from the circle.
    #[must_use]
    pub fn end_error(&self, end: [f64; 2]) -> f64 {
        (nalgebra::distance(&Point2::from(end), &Point2::from(self.center)) - self.radius).abs()
    }

    /// Adds full turns in the direction of the arc.
    #[must_use]
    pub fn with_turns(mut self, turns: u16) -> Self {
        self.sweep += self.sweep.signum() * TAU * f64::from(turns);
        self
    }

    /// How far a coordinate (0 or 1) goes to and fro along the arc.
    #[must_use]
    pub fn travel(&self, coordinate: usize) -> f64 {
        // From the angle where the coordinate is highest, each half turn is one diameter.
        let lead = if coordinate == 0 { 0.0 } else { FRAC_PI_2 };
        let gone = |angle: f64| {
            let halves = ((angle - lead) / PI).floor();
            (halves * 2.0 + 1.0 - libm::cos(angle - lead - halves * PI)) * self.radius
        };
        let (from, to) = (self.start_angle, self.start_angle + self.sweep);
        gone(from.max(to)) - gone(from.min(to))
    }

    /// The lowest and the highest value of a coordinate (0 or 1) between start and end, where it turns back there.
    #[must_use]
    pub fn turning_points(&self, coordinate: usize) -> [Option<f64>; 2] {
        let lead = if coordinate == 0 { 0.0 } else { FRAC_PI_2 };
        let center = if coordinate == 0 { self.center[0] } else { self.center[1] };
        let passes = |angle: f64| {
            let way = (angle - self.start_angle) * self.sweep.signum();
            way.rem_euclid(TAU) < self.sweep.abs()
        };
        [(lead + PI, -self.radius), (lead, self.radius)].map(|(angle, off)| passes(angle).then_some(center + off))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9
    }

    #[test]
    fn travels_to_and_fro() {
        let arc = by_center([10.0, 0.0], [-10.0, 0.0], [0.0, 0.0], false).unwrap();
        assert!(close(arc.travel(0), 20.0) && close(arc.travel(1), 20.0));
        let arc = by_center([0.0, 10.0], [10.0, 0.0], [0.0, 0.0], false).unwrap();
        assert!(close(arc.travel(0), 30.0) && close(arc.travel(1), 30.0));
        let arc = by_center([10.0, 0.0], [8.0, -6.0], [0.0, 0.0], true).unwrap();
        assert!(close(arc.travel(0), 2.0) && close(arc.travel(1), 6.0));
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
    fn an_angle_takes_the_place_of_the_end_or_of_the_radius() {
        let (arc, end) = by_center_and_angle([10.0, 0.0], [0.0, 0.0], 450.0, false).unwrap();
        assert!(close(end[0], 0.0) && close(end[1], 10.0) && close(arc.sweep, 2.5 * PI));
        assert_eq!(arc.full_turns(), 1);
        let (arc, end) = by_center_and_angle([10.0, 0.0], [0.0, 0.0], 720.0, true).unwrap();
        assert_eq!((end, arc.full_turns()), ([10.0, 0.0], 1));
        for (angle, center) in [(90.0, [0.0, 0.0]), (270.0, [5.0, 5.0])] {
            let arc = by_end_and_angle([5.0, 0.0], [0.0, 5.0], angle, false).unwrap();
            assert!(close(arc.center[0], center[0]) && close(arc.center[1], center[1]), "{arc:?}");
            assert!(close(arc.sweep.to_degrees(), angle));
        }
        for angle in [0.0, -90.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(by_center_and_angle([1.0, 0.0], [0.0; 2], angle, true), Err(ArcError::Angle { .. })));
            assert!(matches!(by_end_and_angle([1.0, 0.0], [0.0; 2], angle, true), Err(ArcError::Angle { .. })));
        }
    }

    #[test]
    fn impossible_circles_are_refused() {
        assert_eq!(by_center([0.0, 0.0], [1.0, 0.0], [0.0, 0.0], true), Err(ArcError::ZeroRadius));
        assert_eq!(by_radius([0.0, 0.0], [0.0, 0.0], 1.0, true, 0.0), Err(ArcError::SamePoint));
        assert!(matches!(by_radius([0.0, 0.0], [3.0, 0.0], 1.0, true, 0.01), Err(ArcError::RadiusTooSmall { .. })));
        assert!(by_radius([0.0, 0.0], [2.005, 0.0], 1.0, true, 0.01).is_ok());
    }
}
