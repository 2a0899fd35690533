//! Directions of a tool in space: leaned against a path, and turned along the surface of a cone.
//!
//! Facts: programming manual "job planning" of the SINUMERIK 840D, chapters "three, four and five axis transformation"
//! and "orientation programming along the peripheral surface of a taper". Vectors have the order X, Y, Z and need no
//! length; results have length 1. Angles are degrees. *Invariant:* all directions of a cone have the same angle to its
//! axis.

use nalgebra::Vector3;

/// Lengths and products below this are none.
const NOISE: f64 = 1e-9;
/// How far the ends of a cone may differ along its axis.
const OFF_CONE: f64 = 1e-4;

/// Directions that have the same angle to an axis, from a first one on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    start: Vector3<f64>,
    axis: Vector3<f64>,
    /// Degrees about the axis, right-handed.
    pub turn: f64,
}

fn unit(vector: [f64; 3]) -> Option<Vector3<f64>> {
    Vector3::from(vector).try_normalize(NOISE)
}

/// A vector turned about an axis of length 1.
fn turned(vector: Vector3<f64>, axis: Vector3<f64>, degrees: f64) -> Vector3<f64> {
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    vector * cosine + axis.cross(&vector) * sine + axis * (axis.dot(&vector) * (1.0 - cosine))
}

/// A surface normal that is leaned by `lead` towards the path and then turned by `tilt` about the path, right-handed.
/// None if the normal and the path have no length, or the normal is more than `off` degrees from being perpendicular to
/// the path.
pub fn leaned(normal: [f64; 3], path: [f64; 3], [lead, tilt]: [f64; 2], off: f64) -> Option<[f64; 3]> {
    let (normal, path) = (unit(normal)?, unit(path)?);
    if normal.dot(&path).abs() > libm::sin(off.to_radians()) {
        return None;
    }
    let ahead = (path - normal * normal.dot(&path)).try_normalize(NOISE)?;
    let (sine, cosine) = libm::sincos(lead.to_radians());
    Some(turned(normal * cosine + ahead * sine, ahead, tilt).into())
}

impl Cone {
    /// About an axis, clockwise or counter-clockwise as one looks against it; without an end, or with the start as the
    /// end, once round. None if the ends do not have the same angle to the axis, or the start lies on it.
    pub fn about(axis: [f64; 3], start: [f64; 3], end: Option<[f64; 3]>, clockwise: bool) -> Option<Self> {
        let (axis, start) = (unit(axis)?, unit(start)?);
        let end = end.map_or(Some(start), unit)?;
        if (axis.dot(&start) - axis.dot(&end)).abs() > OFF_CONE || axis.cross(&start).norm() < NOISE {
            return None;
        }
        let angle = libm::atan2(axis.dot(&start.cross(&end)), (start - axis * axis.dot(&start)).dot(&end)).to_degrees();
        let angle = if angle.abs() < 1e-6 { 0.0 } else { angle };
        let turn = match clockwise {
            true if angle >= 0.0 => angle - 360.0,
            false if angle <= 0.0 => angle + 360.0,
            _ => angle,
        };
        Some(Self { start, axis, turn })
    }

    /// With a full opening angle: the path below half a turn if `short`, otherwise the other way. None if the cone is
    /// too narrow for its ends, or they are the same or opposite.
    pub fn opened(opening: f64, [start, end]: [[f64; 3]; 2], clockwise: bool, short: bool) -> Option<Self> {
        let (first, last) = (unit(start)?, unit(end)?);
        let across = first.cross(&last).try_normalize(NOISE)?;
        let middle = (first + last).try_normalize(NOISE)?;
        let along = libm::cos(opening.to_radians() / 2.0) / middle.dot(&first);
        if along.abs() > 1.0 {
            return None;
        }
        // The axis to one side turns counter-clockwise by the short path, the one to the other side by the long path.
        let side = if clockwise == short { -1.0 } else { 1.0 };
        let axis = middle * along + across * (side * libm::sqrt(1.0 - along * along));
        Self::about(axis.into(), start, Some(end), clockwise)
    }

    /// From a direction through another one to a third. None if two of them are the same.
    pub fn through(start: [f64; 3], between: [f64; 3], end: [f64; 3]) -> Option<Self> {
        let [first, middle, last] = [unit(start)?, unit(between)?, unit(end)?];
        let axis = (middle - first).cross(&(last - middle)).try_normalize(NOISE)?;
        Self::about(axis.into(), start, Some(end), false)
    }

    /// From a direction on, at first along `way`, to another one. None if the path is none or the ends are the same.
    pub fn tangential(start: [f64; 3], way: [f64; 3], end: [f64; 3]) -> Option<Self> {
        let (first, last) = (unit(start)?, unit(end)?);
        let way = Vector3::from(way);
        let way = (way - first * first.dot(&way)).try_normalize(NOISE)?;
        let axis = way.cross(&(last - first)).try_normalize(NOISE)?;
        let clockwise = axis.cross(&first).dot(&way) < 0.0;
        Self::about(axis.into(), start, Some(end), clockwise)
    }

    /// The direction at a part of the turn, 0 to 1.
    pub fn at(&self, part: f64) -> [f64; 3] {
        turned(self.start, self.axis, self.turn * part).into()
    }

    /// Where the direction goes at the end.
    pub fn way_at_end(&self) -> [f64; 3] {
        let end = turned(self.start, self.axis, self.turn);
        (self.axis.cross(&end) * self.turn.signum()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: [f64; 3], expected: [f64; 3]) {
        let off = (Vector3::from(found) - Vector3::from(expected)).norm();
        assert!(off < 1e-9, "{found:?} is not {expected:?}");
    }

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn leads_towards_the_path_and_tilts_about_it() {
        let (sine, cosine) = libm::sincos(10_f64.to_radians());
        near(leaned(Z, X, [10.0, 0.0], 1.0).unwrap(), [sine, 0.0, cosine]);
        near(leaned(Z, X, [0.0, 10.0], 1.0).unwrap(), [0.0, -sine, cosine]);
        near(leaned(Z, [0.0, -5.0, 0.0], [10.0, 0.0], 1.0).unwrap(), [0.0, -sine, cosine]);
        assert_eq!(leaned(Z, [1.0, 0.0, 0.1], [0.0, 0.0], 1.0), None);
        assert_eq!(leaned(Z, [0.0; 3], [0.0, 0.0], 1.0), None);
    }

    #[test]
    fn turns_about_an_axis_to_both_sides() {
        let cone = Cone::about(Z, X, Some(Y), false).unwrap();
        assert!((cone.turn - 90.0).abs() < 1e-9);
        near(cone.at(1.0), Y);
        let root = 0.5_f64.sqrt();
        near(cone.at(0.5), [root, root, 0.0]);
        near(cone.way_at_end(), [-1.0, 0.0, 0.0]);
        let cone = Cone::about(Z, X, Some(Y), true).unwrap();
        assert!((cone.turn + 270.0).abs() < 1e-9);
        near(cone.at(1.0), Y);
        assert!((Cone::about(Z, [1.0, 0.0, 1.0], None, true).unwrap().turn + 360.0).abs() < 1e-9);
        assert_eq!(Cone::about(Z, X, Some([1.0, 0.0, 1.0]), true), None);
        assert_eq!(Cone::about(Z, Z, None, true), None);
    }

    #[test]
    fn opens_to_the_side_that_the_sense_asks_for() {
        // 180 degrees is the great circle.
        let cone = Cone::opened(180.0, [X, Y], false, true).unwrap();
        assert!((cone.turn - 90.0).abs() < 1e-9);
        for (clockwise, short) in [(false, true), (true, true), (false, false), (true, false)] {
            let cone = Cone::opened(120.0, [X, Y], clockwise, short).unwrap();
            assert_eq!((cone.turn < 0.0, cone.turn.abs() < 180.0), (clockwise, short));
            near(cone.at(1.0), Y);
            let angle = libm::acos(cone.axis.dot(&Vector3::from(cone.at(0.3)))).to_degrees();
            assert!((angle - 60.0).abs() < 1e-9);
        }
        assert_eq!(Cone::opened(80.0, [X, Y], false, true), None);
    }

    #[test]
    fn goes_through_a_direction_and_on_from_a_way() {
        let root = 0.5_f64.sqrt();
        let cone = Cone::through(X, [root, root, 0.0], Y).unwrap();
        assert!((cone.turn - 90.0).abs() < 1e-9);
        let cone = Cone::through(X, [-root, -root, 0.0], Y).unwrap();
        assert!((cone.turn - 270.0).abs() < 1e-9);
        let cone = Cone::tangential(X, [0.0, 3.0, 0.0], Y).unwrap();
        near(cone.at(0.5), [root, root, 0.0]);
        let cone = Cone::tangential(X, [0.0, -1.0, 0.0], Y).unwrap();
        near(cone.at(0.5), [-root, -root, 0.0]);
    }
}
