//! Maps of space that keep straight lines straight.
//!
//! Coordinates are X, Y, Z as geometry (radii). Angles are degrees; their sines come from `libm` and are exact at
//! multiples of 90, so that every machine gives the same bits. *Invariant:* an inverse that exists is finite.

use nalgebra::{Matrix3, Vector3};

/// Three coordinates, as everything outside frames has them.
pub type Point = [f64; 3];

/// A linear part and a shift. *Invariant:* a coordinate of a result is the sum by columns from the left, the shift
/// last, so that every machine rounds alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    linear: Matrix3<f64>,
    shift: Vector3<f64>,
}

/// Sine and cosine of degrees.
pub fn turn(degrees: f64) -> (f64, f64) {
    let quarter = degrees.rem_euclid(360.0) / 90.0;
    match [0.0, 1.0, 2.0, 3.0].iter().position(|at| *at == quarter) {
        Some(0) => (0.0, 1.0),
        Some(1) => (1.0, 0.0),
        Some(2) => (0.0, -1.0),
        Some(_) => (-1.0, 0.0),
        None => (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians())),
    }
}

/// The linear part applied to a vector.
#[inline]
fn applied(linear: &Matrix3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    linear.column(0) * to.x + linear.column(1) * to.y + linear.column(2) * to.z
}

impl Affine {
    /// Leaves everything where it is.
    pub const SAME: Self =
        Self { linear: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), shift: Vector3::new(0.0, 0.0, 0.0) };

    /// Moves everything by a distance.
    pub fn translation(by: Point) -> Self {
        Self { shift: by.into(), ..Self::SAME }
    }

    /// Makes every coordinate this many times as large; −1 mirrors.
    pub fn scale(by: Point) -> Self {
        Self { linear: Matrix3::from_diagonal(&by.into()), ..Self::SAME }
    }

    /// Turns about a direction through the origin, counter-clockwise seen against it; `None` for no direction. Quarters
    /// are exact, which the rotations of nalgebra are not.
    pub fn rotation(about: Point, degrees: f64) -> Option<Self> {
        let about = Vector3::from(about);
        let length = about.norm();
        if !(length.is_normal() && degrees.is_finite()) {
            return None;
        }
        let [x, y, z] = (about / length).into();
        let (sine, cosine) = turn(degrees);
        let rest = 1.0 - cosine;
        let linear = Matrix3::new(
            x * x * rest + cosine,
            x * y * rest - z * sine,
            x * z * rest + y * sine,
            y * x * rest + z * sine,
            y * y * rest + cosine,
            y * z * rest - x * sine,
            z * x * rest - y * sine,
            z * y * rest + x * sine,
            z * z * rest + cosine,
        );
        Some(Self { linear, ..Self::SAME })
    }

    /// The same around another point than the origin.
    pub fn around(&self, center: Point) -> Self {
        Self::translation(center).after(self).after(&Self::translation(center.map(|value| -value)))
    }

    /// The map of twelve numbers, row by row; `None` if one of them is not finite.
    pub fn of_cells(cells: [f64; 12]) -> Option<Self> {
        let [a, b, c, x, d, e, f, y, g, h, i, z] = cells;
        let map = Self { linear: Matrix3::new(a, b, c, d, e, f, g, h, i), shift: Vector3::new(x, y, z) };
        map.is_finite().then_some(map)
    }

    /// The twelve numbers, row by row.
    pub fn cells(&self) -> Vec<f64> {
        let rows: [[f64; 3]; 3] = self.linear.transpose().into();
        rows.into_iter().zip(&self.shift).flat_map(|([x, y, z], shift)| [x, y, z, *shift]).collect()
    }

    /// Whether it only shifts.
    pub fn is_shift(&self) -> bool {
        self.linear == Matrix3::identity()
    }

    /// First `inner`, then this one.
    pub fn after(&self, inner: &Self) -> Self {
        let [first, second, third] = [0, 1, 2].map(|at| applied(&self.linear, &inner.linear.column(at).into_owned()));
        Self {
            linear: Matrix3::from_columns(&[first, second, third]),
            shift: applied(&self.linear, &inner.shift) + self.shift,
        }
    }

    /// Where a point goes.
    pub fn point(&self, point: Point) -> Point {
        (applied(&self.linear, &point.into()) + self.shift).into()
    }

    /// The transformed direction.
    pub fn direction(&self, direction: Point) -> Point {
        applied(&self.linear, &direction.into()).into()
    }

    /// Whether a coordinate that is there makes one that is not.
    pub fn leaves(&self, has: [bool; 3]) -> bool {
        let of = |row: &[f64; 3]| row.iter().zip(has).any(|(part, has)| has && part.abs() > 1e-12);
        let rows: [[f64; 3]; 3] = self.linear.transpose().into();
        rows.iter().zip(has).any(|(row, has)| !has && of(row))
    }

    /// Volume of a unit cube after the map, negative if it mirrors.
    pub fn determinant(&self) -> f64 {
        self.linear.determinant()
    }

    /// The way back, if there is one.
    pub fn inverse(&self) -> Option<Self> {
        let by = self.determinant();
        if !by.is_normal() {
            return None;
        }
        // Written out: the inverse of nalgebra has zeros of the other sign.
        let [[a, d, g], [b, e, h], [c, f, i]]: [[f64; 3]; 3] = self.linear.into();
        let turned = Matrix3::new(
            e * i - f * h,
            c * h - b * i,
            b * f - c * e,
            f * g - d * i,
            a * i - c * g,
            c * d - a * f,
            d * h - e * g,
            b * g - a * h,
            a * e - b * d,
        );
        let linear = turned / by;
        let map = Self { linear, shift: -applied(&linear, &self.shift) };
        map.is_finite().then_some(map)
    }

    fn is_finite(&self) -> bool {
        self.linear.iter().chain(&self.shift).all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_are_exact_and_there_is_a_way_back() {
        let turned = Affine::rotation([0.0, 0.0, 2.0], 90.0).unwrap();
        assert_eq!(turned.point([1.0, 0.0, 5.0]), [0.0, 1.0, 5.0]);
        assert_eq!(turned.around([1.0, 0.0, 0.0]).point([2.0, 0.0, 0.0]), [1.0, 1.0, 0.0]);
        let both = Affine::scale([2.0, -1.0, 1.0]).after(&Affine::translation([3.0, 4.0, 5.0]));
        assert_eq!(both.point([0.0, 0.0, 0.0]), [6.0, -4.0, 5.0]);
        assert_eq!(both.inverse().unwrap().point([6.0, -4.0, 5.0]), [0.0, 0.0, 0.0]);
        assert_eq!(both.determinant(), -2.0);
    }

    #[test]
    fn what_has_no_way_back_is_refused() {
        assert_eq!(Affine::scale([1.0, 0.0, 1.0]).inverse(), None);
        assert_eq!(Affine::scale([1.0, f64::NAN, 1.0]).inverse(), None);
        assert_eq!(Affine::translation([f64::INFINITY, 0.0, 0.0]).inverse(), None);
        assert_eq!(Affine::rotation([0.0; 3], 30.0), None);
        assert_eq!(Affine::rotation([0.0, 0.0, 1.0], f64::NAN), None);
    }
}
