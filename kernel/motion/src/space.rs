//! Arcs in space: a circle through three points.
//!
//! Coordinates are radius values in one unit. *Invariant:* a [`SpaceArc`] that exists has a positive radius and a sweep
//! of more than nothing and less than a turn, counter-clockwise about its normal. Angles come from `libm`, so that
//! every machine gives the same bits.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Vector3};

use crate::arc::ArcError;

/// An arc in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceArc {
    /// Centre.
    pub center: [f64; 3],
    /// Unit vector about which the arc turns counter-clockwise.
    pub normal: [f64; 3],
    /// Radius.
    pub radius: f64,
    /// Angle gone through.
    pub sweep: f64,
    /// Unit vectors in the plane of the arc: to its start, and a quarter turn further.
    start: [f64; 3],
    quarter: [f64; 3],
}

impl SpaceArc {
    /// The arc from `from` by way of `via` to `to`.
    ///
    /// # Errors
    /// [`ArcError::SamePoint`] if start and end coincide, [`ArcError::Straight`] if the three points lie in a line.
    pub fn through(from: [f64; 3], via: [f64; 3], to: [f64; 3]) -> Result<Self, ArcError> {
        let [from, via, to] = [from, via, to].map(Point3::from);
        let (a, b) = (via - from, to - from);
        let chord = b.norm();
        if chord < 1e-9 {
            return Err(ArcError::SamePoint);
        }
        let across = a.cross(&b);
        let height = across.norm() / chord;
        if height < 1e-9 || !height.is_finite() {
            return Err(ArcError::Straight);
        }
        let normal = across.normalize();
        // In the plane of the arc: along the chord, and away from it on the side of `via`.
        let along = b / chord;
        let up = normal.cross(&along) * -1.0;
        let (x, y) = (a.dot(&along), a.dot(&up));
        // The centre is on the middle of the chord: |centre − from| = |centre − via|.
        let rise = (x * x + y * y - chord * x) / (2.0 * y);
        let center = from + along * (chord / 2.0) + up * rise;
        let spoke = from - center;
        let radius = spoke.norm();
        if !radius.is_finite() {
            return Err(ArcError::Straight);
        }
        let start = spoke / radius;
        let quarter = normal.cross(&start);
        let last = to - center;
        let sweep = libm::atan2(last.dot(&quarter), last.dot(&start)).rem_euclid(TAU);
        let list = |v: Vector3<f64>| -> [f64; 3] { v.into() };
        Ok(Self {
            center: center.into(),
            normal: list(normal),
            radius,
            sweep,
            start: list(start),
            quarter: list(quarter),
        })
    }

    /// The same arc by the place of its middle over the chord, as [`SpaceArc::bulge`] gives it.
    ///
    /// # Errors
    /// As [`SpaceArc::through`].
    pub fn bulging(from: [f64; 3], to: [f64; 3], bulge: [f64; 2]) -> Result<Self, ArcError> {
        let [u, v] = across(from, to).ok_or(ArcError::SamePoint)?;
        let [a, b] = [from, to].map(Point3::from);
        let middle = nalgebra::center(&a, &b) + u * bulge[0] + v * bulge[1];
        Self::through(from, middle.into(), to)
    }

    /// Offset of the middle of the arc from the middle of the chord from `from` to `to`, as components along two
    /// directions across the chord that the chord alone determines.
    #[must_use]
    pub fn bulge(&self, from: [f64; 3], to: [f64; 3]) -> [f64; 2] {
        let Some([u, v]) = across(from, to) else { return [0.0; 2] };
        let [a, b] = [from, to].map(Point3::from);
        let away = Point3::from(self.at(0.5)) - nalgebra::center(&a, &b);
        [away.dot(&u), away.dot(&v)]
    }

    /// Length along the circle.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.radius * self.sweep
    }

    /// Point at a share (0 to 1) of the arc.
    #[must_use]
    pub fn at(&self, share: f64) -> [f64; 3] {
        let angle = self.sweep * share;
        let (cos, sin) = (libm::cos(angle), libm::sin(angle));
        let mut point = self.center;
        for (slot, (a, b)) in point.iter_mut().zip(self.start.iter().zip(&self.quarter)) {
            *slot += self.radius * (a * cos + b * sin);
        }
        point
    }

    /// How a coordinate goes along the arc: its centre, its largest distance from there, and the angle from where it is
    /// furthest to the start.
    #[must_use]
    pub fn swing(&self, coordinate: usize) -> (f64, f64, f64) {
        let of = |list: &[f64; 3]| list.get(coordinate).copied().unwrap_or(0.0);
        let (a, b) = (of(&self.start), of(&self.quarter));
        (of(&self.center), self.radius * (a * a + b * b).sqrt(), -libm::atan2(b, a))
    }

    /// Shares (ascending, ends excluded) at which a coordinate turns back.
    #[must_use]
    pub fn turning_points(&self, coordinate: usize) -> [Option<f64>; 2] {
        let (_, reach, start) = self.swing(coordinate);
        if reach < 1e-12 {
            return [None; 2];
        }
        let first = (-start).rem_euclid(PI) / self.sweep;
        let inside = |share: f64| (share > 1e-12 && share < 1.0 - 1e-12).then_some(share);
        [inside(first), inside(first + PI / self.sweep)]
    }
}

/// Two unit vectors across a chord and across each other.
fn across(from: [f64; 3], to: [f64; 3]) -> Option<[Vector3<f64>; 2]> {
    let chord = Point3::from(to) - Point3::from(from);
    let along = chord.try_normalize(1e-9)?;
    let least = along.iter().map(|part| part.abs()).fold(f64::INFINITY, f64::min);
    let axis = along.iter().position(|part| part.abs() == least)?;
    let mut aside = Vector3::zeros();
    *aside.iter_mut().nth(axis)? = 1.0;
    let u = along.cross(&aside).try_normalize(0.0)?;
    Some([u, along.cross(&u)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn half_a_circle_standing_up() {
        // From X10 over Z10 to X-10 about the origin: a half turn, furthest in Z at its middle.
        let arc = SpaceArc::through([10.0, 0.0, 0.0], [0.0, 0.0, 10.0], [-10.0, 0.0, 0.0]).unwrap();
        assert!(close(arc.center, [0.0; 3]) && close(arc.normal, [0.0, -1.0, 0.0]), "{arc:?}");
        assert!((arc.sweep - PI).abs() < 1e-9 && (arc.length() - 10.0 * PI).abs() < 1e-9);
        assert!(close(arc.at(0.5), [0.0, 0.0, 10.0]));
        let [first, second] = arc.turning_points(2);
        assert!((first.unwrap() - 0.5).abs() < 1e-9 && second.is_none());
        assert_eq!(arc.turning_points(1), [None; 2]);
    }

    #[test]
    fn more_than_half_turns_back_twice() {
        // Three quarters in the XY plane, from X10 by way of Y10 and X-10 to Y-10.
        let arc = SpaceArc::through([10.0, 0.0, 5.0], [-10.0, 0.0, 5.0], [0.0, -10.0, 5.0]);
        let arc = arc.unwrap_or_else(|error| panic!("{error}"));
        assert!(close(arc.center, [0.0, 0.0, 5.0]), "{arc:?}");
        assert!((arc.sweep - 1.5 * PI).abs() < 1e-9 && close(arc.normal, [0.0, 0.0, 1.0]));
        let shares = arc.turning_points(1);
        assert!((shares[0].unwrap() - 1.0 / 3.0).abs() < 1e-9, "{shares:?}");
    }

    #[test]
    fn a_bulge_tells_the_whole_arc() {
        let (from, to) = ([1.0, 2.0, 3.0], [4.0, -1.0, 2.5]);
        for via in [[2.0, 2.0, 9.0], [9.0, 9.0, 9.0], [2.5, 0.6, 2.8], [1.001, 2.0, 3.1]] {
            let arc = SpaceArc::through(from, via, to).unwrap();
            let again = SpaceArc::bulging(from, to, arc.bulge(from, to)).unwrap();
            assert!(close(arc.center, again.center) && close(arc.normal, again.normal), "{arc:?} {again:?}");
            assert!(close(arc.at(0.25), again.at(0.25)) && close(again.at(1.0), to));
        }
    }

    #[test]
    fn three_points_in_a_line_make_no_arc() {
        assert_eq!(SpaceArc::through([0.0; 3], [1.0; 3], [2.0; 3]), Err(ArcError::Straight));
        assert_eq!(SpaceArc::through([0.0; 3], [1.0; 3], [0.0; 3]), Err(ArcError::SamePoint));
        assert!(SpaceArc::through([0.0; 3], [f64::NAN; 3], [1.0; 3]).is_err());
        assert!(SpaceArc::through([f64::MAX; 3], [0.0; 3], [1.0, f64::MAX, 0.0]).is_err());
    }
}
