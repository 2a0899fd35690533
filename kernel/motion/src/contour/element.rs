//! A piece of the contour in its plane, and its offset.
//!
//! Coordinates are those of the plane, as geometry (radii). The side is +1 for a tool left of the path, −1 right.
//! *Invariant:* an element has a length.

use std::f64::consts::TAU;

use crate::arc::PlaneArc;

/// Two coordinates of the plane.
pub type Spot = [f64; 2];

/// Differences below this are none.
pub const NOISE: f64 = 1e-7;

/// Direction of an angle in degrees; exact at multiples of 90.
#[must_use]
pub fn direction(degrees: f64) -> Spot {
    let turn = degrees.rem_euclid(360.0);
    match () {
        () if turn == 0.0 => [1.0, 0.0],
        () if turn == 90.0 => [0.0, 1.0],
        () if turn == 180.0 => [-1.0, 0.0],
        () if turn == 270.0 => [0.0, -1.0],
        () => [libm::cos(turn.to_radians()), libm::sin(turn.to_radians())],
    }
}

/// `a + c * times`, coordinate by coordinate.
pub fn plus([a, b]: Spot, [c, d]: Spot, times: f64) -> Spot {
    [a + c * times, b + d * times]
}

/// Scalar product.
pub fn dot([a, b]: Spot, [c, d]: Spot) -> f64 {
    a * c + b * d
}

/// The component of the vector product that is normal to the plane.
pub fn cross([a, b]: Spot, [c, d]: Spot) -> f64 {
    a * d - b * c
}

/// Distance of two points.
pub fn distance(a: Spot, b: Spot) -> f64 {
    let by = plus(b, a, -1.0);
    dot(by, by).sqrt()
}

/// A line or an arc of the contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Start.
    pub from: Spot,
    /// End.
    pub to: Spot,
    /// The arc between them; none for a line.
    pub arc: Option<PlaneArc>,
}

impl Element {
    /// Direction at its start, of length one.
    pub fn start(&self) -> Spot {
        match &self.arc {
            Some(arc) => along(arc, self.from),
            None => self.straight(),
        }
    }

    /// Direction at its end.
    pub fn end(&self) -> Spot {
        match &self.arc {
            Some(arc) => along(arc, self.to),
            None => self.straight(),
        }
    }

    fn straight(&self) -> Spot {
        let by = plus(self.to, self.from, -1.0);
        let length = dot(by, by).sqrt();
        by.map(|part| part / length)
    }

    /// Length of the path along it.
    pub fn length(&self) -> f64 {
        self.arc.as_ref().map_or_else(|| distance(self.from, self.to), PlaneArc::length)
    }

    /// Radius of the offset of an arc; none if the tool does not fit in.
    pub fn offset_radius(&self, side: f64, radius: f64) -> Option<f64> {
        let arc = self.arc.as_ref()?;
        let left = arc.radius - side * arc.sweep.signum() * radius;
        (left > NOISE).then_some(left)
    }

    /// Whether the tool is larger than the arc; one of the same radius is in its centre.
    pub fn is_smaller(&self, side: f64, radius: f64) -> bool {
        self.arc.as_ref().is_some_and(|arc| arc.radius - side * arc.sweep.signum() * radius < -NOISE)
    }

    /// Whether the offset of the arc is not an arc.
    pub fn is_too_small(&self, side: f64, radius: f64) -> bool {
        self.arc.is_some() && self.offset_radius(side, radius).is_none()
    }

    /// The part of the element between two of its points.
    #[must_use]
    pub fn between(&self, from: Spot, to: Spot) -> Self {
        let arc = self.arc.map(|arc| {
            let (start_angle, turn) = (angle(arc.center, from), arc.sweep.signum());
            let way = ((angle(arc.center, to) - start_angle) * turn).rem_euclid(TAU);
            // Nothing of it, not almost a whole turn.
            let way = if TAU - way < 1e-9 && arc.sweep.abs() < TAU - 1e-9 { 0.0 } else { way };
            let turns = ((arc.sweep.abs() - way) / TAU + 1e-9).floor().max(0.0);
            PlaneArc { start_angle, sweep: turn * (way + turns * TAU), ..arc }
        });
        Self { from, to, arc }
    }

    /// Share of the element that is done at a point of its offset.
    pub fn share(&self, spot: Spot) -> f64 {
        let Some(arc) = &self.arc else {
            let by = plus(self.to, self.from, -1.0);
            return dot(plus(spot, self.from, -1.0), by) / dot(by, by);
        };
        let turned = angle(arc.center, spot) - arc.start_angle;
        let way = (turned * arc.sweep.signum()).rem_euclid(TAU);
        let whole = arc.sweep.abs();
        // Just before the start is less than nothing, not almost a whole turn.
        let way = if way > whole && way - whole > TAU - way { way - TAU } else { way };
        way / whole
    }
}

/// Direction of an arc at one of its points.
fn along(arc: &PlaneArc, spot: Spot) -> Spot {
    let [x, y] = plus(spot, arc.center, -1.0);
    let length = (x * x + y * y).sqrt().max(f64::MIN_POSITIVE);
    let turn = arc.sweep.signum();
    [-y / length * turn, x / length * turn]
}

/// Where the tool is beside a point of the contour.
pub fn beside(spot: Spot, [x, y]: Spot, side: f64, radius: f64) -> Spot {
    plus(spot, [-y, x], side * radius)
}

/// Direction from a centre to a point.
pub fn angle(center: Spot, spot: Spot) -> f64 {
    let [x, y] = plus(spot, center, -1.0);
    libm::atan2(y, x)
}
