//! Maps of space that keep straight lines straight.
//!
//! Coordinates are X, Y, Z as geometry (radii). Angles are degrees; their sines come from `libm` and are exact at
//! multiples of 90, so that every machine gives the same bits. Invariant: an inverse that exists is finite.

/// Three coordinates.
pub type Point = [f64; 3];

/// A linear part and a shift: one row for each coordinate of the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    rows: [[f64; 4]; 3],
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

impl Affine {
    /// Leaves everything where it is.
    pub const SAME: Self = Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// Moves everything by a distance.
    pub fn translation(by: Point) -> Self {
        let mut made = Self::SAME;
        for (row, by) in made.rows.iter_mut().zip(by) {
            row[3] = by;
        }
        made
    }

    /// Makes every coordinate so many times as large; −1 mirrors.
    pub fn scale(by: Point) -> Self {
        let mut made = Self::SAME;
        for (at, (row, by)) in made.rows.iter_mut().zip(by).enumerate() {
            if let Some(slot) = row.get_mut(at) {
                *slot = by;
            }
        }
        made
    }

    /// Turns about a direction through the origin, counter-clockwise seen against it; `None` for no direction.
    pub fn rotation(about: Point, degrees: f64) -> Option<Self> {
        let length = about.iter().map(|part| part * part).sum::<f64>().sqrt();
        if !(length.is_normal() && degrees.is_finite()) {
            return None;
        }
        let [x, y, z] = about.map(|part| part / length);
        let (sine, cosine) = turn(degrees);
        let rest = 1.0 - cosine;
        Some(Self {
            rows: [
                [x * x * rest + cosine, x * y * rest - z * sine, x * z * rest + y * sine, 0.0],
                [y * x * rest + z * sine, y * y * rest + cosine, y * z * rest - x * sine, 0.0],
                [z * x * rest - y * sine, z * y * rest + x * sine, z * z * rest + cosine, 0.0],
            ],
        })
    }

    /// The same around another point than the origin.
    pub fn around(&self, center: Point) -> Self {
        Self::translation(center).after(self).after(&Self::translation(center.map(|value| -value)))
    }

    /// The map of twelve numbers, row by row; `None` if one of them is not finite.
    pub fn of_cells(cells: [f64; 12]) -> Option<Self> {
        let [a, b, c, x, d, e, f, y, g, h, i, z] = cells;
        cells.iter().all(|cell| cell.is_finite()).then_some(Self { rows: [[a, b, c, x], [d, e, f, y], [g, h, i, z]] })
    }

    /// The twelve numbers, row by row.
    pub fn cells(&self) -> Vec<f64> {
        self.rows.concat()
    }

    /// First `inner`, then this one.
    pub fn after(&self, inner: &Self) -> Self {
        let mut made = *self;
        for (row, [x, y, z, shift]) in made.rows.iter_mut().zip(self.rows) {
            let [first, second, third] = inner.rows;
            for (column, slot) in row.iter_mut().enumerate() {
                let at = |of: [f64; 4]| of.get(column).copied().unwrap_or(0.0);
                *slot = x * at(first) + y * at(second) + z * at(third);
            }
            row[3] += shift;
        }
        made
    }

    /// Where a point goes.
    pub fn point(&self, [px, py, pz]: Point) -> Point {
        self.rows.map(|[x, y, z, shift]| x * px + y * py + z * pz + shift)
    }

    /// What a direction becomes.
    pub fn direction(&self, [dx, dy, dz]: Point) -> Point {
        self.rows.map(|[x, y, z, _]| x * dx + y * dy + z * dz)
    }

    /// A coordinate that is there makes one that is not.
    pub fn leaves(&self, has: [bool; 3]) -> bool {
        let of = |row: &[f64; 4]| row.iter().zip(has).any(|(part, has)| has && part.abs() > 1e-12);
        self.rows.iter().zip(has).any(|(row, has)| !has && of(row))
    }

    /// Volume of a unit cube after the map, negative if it mirrors.
    pub fn determinant(&self) -> f64 {
        let [[a, b, c, _], [d, e, f, _], [g, h, i, _]] = self.rows;
        a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    }

    /// The way back, if there is one.
    pub fn inverse(&self) -> Option<Self> {
        let by = self.determinant();
        if !by.is_normal() {
            return None;
        }
        let [[a, b, c, x], [d, e, f, y], [g, h, i, z]] = self.rows;
        let turned = [
            [e * i - f * h, c * h - b * i, b * f - c * e],
            [f * g - d * i, a * i - c * g, c * d - a * f],
            [d * h - e * g, b * g - a * h, a * e - b * d],
        ];
        let rows = turned.map(|row| {
            let [p, q, r] = row.map(|value| value / by);
            [p, q, r, -(p * x + q * y + r * z)]
        });
        rows.iter().flatten().all(|value| value.is_finite()).then_some(Self { rows })
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
