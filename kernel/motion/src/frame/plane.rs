//! Tilted planes: the forms in which programs say how a plane lies.
//!
//! Every form gives a rotation: X, Y and Z of the plane as they lie in the frame that it is defined in. *Invariant:* a
//! plane is right-handed and square, or there is none. Facts: reference heidenhain-cycles.md 6, siemens-cycles.md 2;
//! Fanuc descriptions of the tilted working plane command (B-63942EN 5.44).

use nalgebra::Vector3;

use super::affine::{Affine, Point, turn};

/// Directions of X, Y and Z.
pub const UNITS: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Sines below this are those of parallel directions.
const PARALLEL: f64 = 1e-9;

/// Rotations one after the other, each about an axis (0 to 2 for X, Y and Z) that those before have turned; none if an
/// angle is not finite.
pub fn turned(axes: [usize; 3], angles: Point) -> Option<Affine> {
    let mut map = Affine::SAME;
    for (axis, angle) in axes.into_iter().zip(angles) {
        map = map.after(&Affine::rotation(UNITS.get(axis).copied()?, angle)?);
    }
    Some(map)
}

/// Rotations one after the other about axes that stay; angles in the same order as the axes.
pub fn turned_about_fixed([a, b, c]: [usize; 3], [first, second, third]: Point) -> Option<Affine> {
    turned([c, b, a], [third, second, first])
}

/// A rotation by the directions of its X and Z, of any length. X is made perpendicular to Z; none if they are parallel.
pub fn of_directions(x: Point, z: Point) -> Option<Affine> {
    let direction = |of: Vector3<f64>| {
        let length = of.norm();
        length.is_normal().then(|| of / length)
    };
    let (x, z) = (direction(x.into())?, direction(z.into())?);
    let y = z.cross(&x);
    if y.norm() < PARALLEL {
        return None;
    }
    let y = y.normalize();
    let x = y.cross(&z);
    Affine::of_cells([x.x, y.x, z.x, 0.0, x.y, y.y, z.y, 0.0, x.z, y.z, z.z, 0.0])
}

/// A rotation by three points: from the first to the second along X, the third on the side of Y; none if they lie on a
/// line.
pub fn of_points([first, second, third]: [Point; 3]) -> Option<Affine> {
    let [first, second, third] = [first, second, third].map(Vector3::from);
    let (x, aside) = (second - first, third - first);
    let z = x.cross(&aside);
    if z.norm() < PARALLEL * x.norm() * aside.norm() {
        return None;
    }
    of_directions(x.into(), z.into())
}

/// A rotation by the lines in which the plane cuts two planes of the frame: that of Y and Z, where the line is Y turned
/// about X by the first angle, and that of Z and X, where it is X turned about Y by the second. X of the plane lies
/// along the line of Z and X before the last angle turns it about Z.
pub fn of_projections(about_x: f64, about_y: f64, about_z: f64) -> Option<Affine> {
    let ((sine_x, cosine_x), (sine_y, cosine_y)) = (turn(about_x), turn(about_y));
    let (x, aside) = (Vector3::new(cosine_y, 0.0, -sine_y), Vector3::new(0.0, cosine_x, sine_x));
    // Lines that lie on each other are those of no plane.
    let plane = of_directions(x.into(), x.cross(&aside).into())?;
    Some(plane.after(&Affine::rotation([0.0, 0.0, 1.0], about_z)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Point, b: Point) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn angles_about_axes_that_turn_and_that_stay() {
        // Reference heidenhain-cycles.md example 17: A 45, B 0, C 90 about fixed axes.
        let spatial = turned_about_fixed([0, 1, 2], [45.0, 0.0, 90.0]).unwrap();
        let half = 0.5_f64.sqrt();
        assert!(close(spatial.direction(UNITS[0]), [0.0, 1.0, 0.0]));
        assert!(close(spatial.direction(UNITS[1]), [-half, 0.0, half]));
        assert!(close(spatial.direction(UNITS[2]), [half, 0.0, half]));
        // Reference siemens-cycles.md example 16: 30 about Y.
        let swivelled = turned([0, 1, 2], [0.0, 30.0, 0.0]).unwrap();
        assert!(close(swivelled.point([10.0, 0.0, 20.0]), [18.660254037844386, 0.0, 12.320508075688775]));
        let euler = turned([2, 0, 2], [90.0, 90.0, 0.0]).unwrap();
        assert!(close(euler.direction(UNITS[2]), [1.0, 0.0, 0.0]));
        assert_eq!(turned([0, 1, 3], [0.0; 3]), None);
        assert_eq!(turned([0, 1, 2], [f64::NAN, 0.0, 0.0]), None);
    }

    #[test]
    fn directions_points_and_lines() {
        let plane = of_directions([2.0, 0.0, 5.0], [0.0, 0.0, 3.0]).unwrap();
        assert_eq!(plane, Affine::SAME);
        assert_eq!(of_directions([0.0, 0.0, 5.0], [0.0, 0.0, 3.0]), None);
        assert_eq!(of_directions([0.0; 3], [0.0, 0.0, 3.0]), None);
        let points = of_points([[1.0, 1.0, 1.0], [1.0, 3.0, 1.0], [0.0, 5.0, 1.0]]).unwrap();
        assert!(close(points.direction(UNITS[0]), [0.0, 1.0, 0.0]) && close(points.direction(UNITS[2]), UNITS[2]));
        assert_eq!(of_points([[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]), None);
        // One line alone is a rotation about one axis.
        let about_x = of_projections(20.0, 0.0, 0.0).unwrap();
        assert!(close(about_x.direction(UNITS[2]), turned([0, 1, 2], [20.0, 0.0, 0.0]).unwrap().direction(UNITS[2])));
        let about_y = of_projections(0.0, 20.0, 0.0).unwrap();
        assert!(close(about_y.direction(UNITS[2]), turned([0, 1, 2], [0.0, 20.0, 0.0]).unwrap().direction(UNITS[2])));
        // Both lines lie in the plane.
        let both = of_projections(10.0, 20.0, 30.0).unwrap();
        let normal = Vector3::from(both.direction(UNITS[2]));
        let ((s1, c1), (s2, c2)) = (turn(10.0), turn(20.0));
        assert!(normal.dot(&Vector3::new(0.0, c1, s1)).abs() < 1e-12);
        assert!(normal.dot(&Vector3::new(c2, 0.0, -s2)).abs() < 1e-12);
        assert!((both.determinant() - 1.0).abs() < 1e-12);
    }
}
