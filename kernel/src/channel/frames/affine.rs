//! Maps of space that keep straight lines straight.
//!
//! Coordinates are X, Y, Z as geometry (radii). Angles are degrees; their sines come from `libm` and are exact at
//! multiples of 90, so that every machine gives the same bits. Invariant: an inverse that exists is finite.

/// Three coordinates.
pub(crate) type Point = [f64; 3];

/// A linear part and a shift: one row for each coordinate of the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    rows: [[f64; 4]; 3],
}

impl Affine {
    /// Leaves everything where it is.
    pub(crate) const SAME: Self = Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// Moves everything by a distance.
    pub(crate) fn translation(by: Point) -> Self {
        let mut made = Self::SAME;
        for (row, by) in made.rows.iter_mut().zip(by) {
            row[3] = by;
        }
        made
    }

    /// Where a point goes.
    pub(crate) fn point(&self, [px, py, pz]: Point) -> Point {
        self.rows.map(|[x, y, z, shift]| x * px + y * py + z * pz + shift)
    }

    /// Volume of a unit cube after the map, negative if it mirrors.
    pub(crate) fn determinant(&self) -> f64 {
        let [[a, b, c, _], [d, e, f, _], [g, h, i, _]] = self.rows;
        a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    }

    /// The way back, if there is one.
    pub(crate) fn inverse(&self) -> Option<Self> {
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
