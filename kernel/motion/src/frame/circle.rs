//! Circles under a map: where they stay circles, and in which plane they lie then.
//!
//! *Invariant:* a circle under unequal scales in its plane is none. Facts: reference control-emulator.md 6.7.

use nalgebra::Vector3;

use super::affine::{Affine, Point};
use crate::arc::PlaneArc;

/// Parts of a direction below this are none.
const FLAT: f64 = 1e-9;

/// The two directions of a circle's plane as they are under a map.
#[derive(Debug, Clone, Copy)]
pub struct CircleSides {
    first: Vector3<f64>,
    second: Vector3<f64>,
    /// How many times as large the circle is.
    pub scale: f64,
}

impl CircleSides {
    /// The sides of the plane of two axes by their roles (0 to 2 for X, Y and Z), if a circle stays a circle.
    pub fn under(map: &Affine, roles: [usize; 2]) -> Option<Self> {
        let [first, second] = roles.map(|role| Vector3::from(map.direction(Vector3::ith(role, 1.0).into())));
        let (one, other) = (first.norm_squared(), second.norm_squared());
        let same = (one - other).abs() <= FLAT * one && first.dot(&second).abs() <= FLAT * one;
        same.then_some(Self { first, second, scale: one.sqrt() })
    }

    /// The roles of the two axes whose plane the circle lies in.
    pub fn roles(&self) -> Option<[usize; 2]> {
        let flat = |role: usize| {
            let part = |side: &Vector3<f64>| side.get(role).is_some_and(|part| part.abs() <= FLAT * self.scale);
            part(&self.first) && part(&self.second)
        };
        [(2, [0, 1]), (1, [2, 0]), (0, [1, 2])].into_iter().find(|(normal, _)| flat(*normal)).map(|(_, roles)| roles)
    }
}

/// A circle in the plane of X and Y at a level along Z under a map; none if it is not a circle in that plane there.
pub fn circle_in_plane(map: &Affine, made: PlaneArc, level: f64) -> Option<PlaneArc> {
    if *map == Affine::SAME {
        return Some(made);
    }
    let sides = CircleSides::under(map, [0, 1]).filter(|sides| sides.roles() == Some([0, 1]))?;
    let [cx, cy] = made.center;
    let [x, y, _] = map.point([cx, cy, level]);
    let spoke = map.direction([libm::cos(made.start_angle), libm::sin(made.start_angle), 0.0]);
    let ([a, b, _], [c, d, _]): (Point, Point) = (sides.first.into(), sides.second.into());
    Some(PlaneArc {
        center: [x, y],
        radius: made.radius * sides.scale,
        start_angle: libm::atan2(spoke[1], spoke[0]),
        sweep: if a * d - b * c < 0.0 { -made.sweep } else { made.sweep },
    })
}
