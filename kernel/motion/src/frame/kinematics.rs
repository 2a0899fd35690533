//! Rotary axes of tables and heads: where they bring the part and the tool, and which angles bring the tool into a
//! direction.
//!
//! Every rotary axis has a direction about which the tool turns right-handed relative to the part at growing angles,
//! and a point on it in the machine frame with all axes at zero. Tables and heads are in the order from the machine to
//! the part or to the tool. Points are those of the gauge point of the spindle; a tool is the vector from its tip to
//! that point with all heads at zero. Facts: reference control-emulator.md 6.8, functions.md 10. *Invariant:* a
//! solution is finite.

use nalgebra::Vector3;

use super::affine::{Affine, Point};

/// Sums below this are none.
const FLAT: f64 = 1e-9;

/// Directions that differ by less are the same.
const SAME: f64 = 1e-7;

/// A rotary axis; `A` says which.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint<A> {
    /// Which axis it is.
    pub axis: A,
    /// Its direction, any length but zero.
    pub vector: Point,
    /// A point on it.
    pub center: Point,
}

/// The rotary axes of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain<A> {
    /// Rotary axes of the table, from the machine to the part.
    pub tables: Vec<Joint<A>>,
    /// Rotary axes of the head, from the machine to the tool.
    pub heads: Vec<Joint<A>>,
    /// From the tip to the spindle, all heads at zero.
    pub tool: Point,
}

/// A direction of length one; none for zero.
pub fn unit(direction: Point) -> Option<Point> {
    unit_vector(direction).map(Into::into)
}

fn unit_vector(direction: Point) -> Option<Vector3<f64>> {
    let direction = Vector3::from(direction);
    let length = direction.norm();
    length.is_normal().then(|| direction * (1.0 / length))
}

/// Degrees that turn `from` to `to` about `axis`; none if they do not lie on one circle about it, `Some(None)` if any
/// angle does.
fn turn_between(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Option<Option<f64>> {
    if (axis.dot(from) - axis.dot(to)).abs() > SAME {
        return None;
    }
    let flat = |v: &Vector3<f64>| v + axis * -axis.dot(v);
    let (from, to) = (flat(from), flat(to));
    if from.norm_squared() < SAME * SAME || to.norm_squared() < SAME * SAME {
        return Some(None);
    }
    Some(Some(libm::atan2(axis.dot(&from.cross(&to)), from.dot(&to)).to_degrees()))
}

/// Angles of the axes by solution: one for each axis, none where any angle does.
pub type Angles<A> = Vec<(A, Option<f64>)>;

impl<A: Copy> Chain<A> {
    fn map(joints: &[Joint<A>], sign: f64, angle: impl Fn(A) -> f64) -> Affine {
        let mut map = Affine::SAME;
        for joint in joints {
            let turned = Affine::rotation(joint.vector, sign * angle(joint.axis)).unwrap_or(Affine::SAME);
            map = map.after(&turned.around(joint.center));
        }
        map
    }

    /// Where tables bring points of the part.
    pub fn part(&self, angle: impl Fn(A) -> f64) -> Affine {
        Self::map(&self.tables, -1.0, angle)
    }

    /// Where heads bring points of the tool.
    pub fn head(&self, angle: impl Fn(A) -> f64) -> Affine {
        Self::map(&self.heads, 1.0, angle)
    }

    /// Where the linear axes are when the tip is at a point of the part. `length`: from the tip to the gauge point.
    pub fn linear(&self, part: Point, length: Point, angle: impl Fn(A) -> f64 + Copy) -> Point {
        let tip = Vector3::from(self.part(angle).point(part));
        let tool = Vector3::from(self.head(angle).point(length.map(|value| -value)));
        (tip - tool).into()
    }

    /// How fast the linear axes follow the rotary ones while the tip stays at a point of the part; `turning`: degrees
    /// of each axis in some time, in which the path is made.
    pub fn following(&self, part: Point, length: Point, angle: impl Fn(A) -> f64, turning: impl Fn(A) -> f64) -> f64 {
        let carried = |joints: &[Joint<A>], sign: f64, point: Point| {
            let (mut point, mut speed) = (point, Vector3::zeros());
            // From the part, or the tool, to the machine.
            for joint in joints.iter().rev() {
                let turned = Affine::rotation(joint.vector, sign * angle(joint.axis)).unwrap_or(Affine::SAME);
                point = turned.around(joint.center).point(point);
                let arm = Vector3::from(point) - Vector3::from(joint.center);
                let axis = unit_vector(joint.vector).unwrap_or_default() * (sign * turning(joint.axis)).to_radians();
                speed = Vector3::from(turned.direction(speed.into())) + axis.cross(&arm);
            }
            speed
        };
        (carried(&self.tables, -1.0, part) - carried(&self.heads, 1.0, length.map(|value| -value))).norm()
    }

    /// The point of the part where the tip is.
    pub fn tip(&self, linear: Point, length: Point, angle: impl Fn(A) -> f64 + Copy) -> Option<Point> {
        let tool = Vector3::from(self.head(angle).point(length.map(|value| -value)));
        self.part(angle).inverse().map(|back| back.point(Into::into(Vector3::from(linear) + tool)))
    }

    /// Direction of the tool on the part.
    pub fn direction(&self, angle: impl Fn(A) -> f64 + Copy) -> Option<Point> {
        let turned = self.head(angle).direction(self.tool);
        self.part(angle).inverse().and_then(|back| unit(back.direction(turned)))
    }

    /// Two axes that turn about the same direction leave no way to choose.
    pub fn is_possible(&self) -> bool {
        let [first, second] = match (self.tables.as_slice(), self.heads.as_slice()) {
            ([a, b], []) | ([], [a, b]) => [a, b],
            ([a], [b]) => [a, b],
            ([_], []) | ([], [_]) => return true,
            _ => return false,
        };
        let pair = unit_vector(first.vector).zip(unit_vector(second.vector));
        pair.is_some_and(|(a, b)| 1.0 - a.dot(&b).abs() > FLAT)
    }

    /// The angles that bring the tool into a direction of the part: up to two solutions.
    pub fn solve(&self, direction: Point) -> Vec<Angles<A>> {
        let (Some(wanted), Some(tool)) = (unit_vector(direction), unit_vector(self.tool)) else { return Vec::new() };
        // Each case is: the first axis turns `x`, the second one `y`, and both come to the same direction.
        let (first, second, x, y, signs) = match (self.tables.as_slice(), self.heads.as_slice()) {
            ([a, b], []) => (b, a, wanted, tool, [-1.0, 1.0]),
            ([], [a, b]) => (a, b, wanted, tool, [-1.0, 1.0]),
            ([a], [b]) => (a, b, wanted, tool, [-1.0, 1.0]),
            ([a], []) => return Self::single(a, &wanted, &tool, -1.0),
            ([], [a]) => return Self::single(a, &tool, &wanted, 1.0),
            _ => return Vec::new(),
        };
        let (Some(p), Some(q)) = (unit_vector(first.vector), unit_vector(second.vector)) else { return Vec::new() };
        let (k, xp, yq) = (p.dot(&q), x.dot(&p), y.dot(&q));
        let rest = 1.0 - k * k;
        if rest < FLAT {
            return Vec::new();
        }
        let (a, b) = ((xp - k * yq) / rest, (yq - k * xp) / rest);
        let height = (1.0 - a * a - b * b - 2.0 * a * b * k) / rest;
        if height < -SAME {
            return Vec::new();
        }
        let height = height.max(0.0).sqrt();
        let flat = p * a + q * b;
        let heights: &[f64] = if height < FLAT { &[0.0] } else { &[height, -height] };
        let solve = |height: f64| {
            let common = flat + p.cross(&q) * height;
            let one = turn_between(&p, &x, &common)?;
            let two = turn_between(&q, &y, &common)?;
            let [s, t] = signs;
            Some(vec![(first.axis, one.map(|angle| s * angle)), (second.axis, two.map(|angle| t * angle))])
        };
        heights.iter().filter_map(|height| solve(*height)).collect()
    }

    fn single(joint: &Joint<A>, from: &Vector3<f64>, to: &Vector3<f64>, sign: f64) -> Vec<Angles<A>> {
        let angle = unit_vector(joint.vector).and_then(|axis| turn_between(&axis, from, to));
        angle.map(|angle| vec![(joint.axis, angle.map(|angle| sign * angle))]).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Point = [1.0, 0.0, 0.0];
    const Y: Point = [0.0, 1.0, 0.0];
    const Z: Point = [0.0, 0.0, 1.0];

    fn joint(axis: usize, vector: Point) -> Joint<usize> {
        Joint { axis, vector, center: [0.0; 3] }
    }

    fn chains() -> Vec<Chain<usize>> {
        let chain = |tables: Vec<Joint<usize>>, heads: Vec<Joint<usize>>| Chain { tables, heads, tool: Z };
        vec![
            chain(vec![joint(0, X), joint(1, Z)], vec![]),
            chain(vec![], vec![joint(0, Z), joint(1, Y)]),
            chain(vec![joint(0, Z)], vec![joint(1, Y)]),
            chain(vec![joint(0, [0.0, 1.0, 1.0]), joint(1, Z)], vec![]),
        ]
    }

    #[test]
    fn every_solution_brings_the_tool_there() {
        for chain in chains() {
            for angles in [[30.0, 40.0], [-70.0, 20.0], [0.0, 10.0], [100.0, -80.0]] {
                let of = |axis: usize| angles[axis];
                let direction = chain.direction(of).unwrap();
                let solutions = chain.solve(direction);
                assert!(!solutions.is_empty(), "{chain:?} {angles:?}");
                for solution in solutions {
                    let of = |axis: usize| {
                        solution.iter().find(|(at, _)| *at == axis).and_then(|(_, angle)| *angle).unwrap_or(0.0)
                    };
                    let back = chain.direction(of).unwrap();
                    assert!(
                        Vector3::from(back).dot(&Vector3::from(direction)) > 1.0 - 1e-12,
                        "{chain:?} {angles:?} {solution:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_reached_has_no_solution() {
        let chain = Chain { tables: vec![joint(0, Z)], heads: vec![], tool: Z };
        assert_eq!(chain.solve(X), Vec::<Angles<usize>>::new());
        assert_eq!(chain.solve(Z), vec![vec![(0, None)]]);
        assert_eq!(chain.solve([f64::NAN; 3]), Vec::<Angles<usize>>::new());
        let parallel = Chain { tables: vec![joint(0, Z)], heads: vec![joint(1, Z)], tool: Z };
        assert!(!parallel.is_possible() && parallel.solve(X).is_empty());
    }

    #[test]
    fn linear_axes_follow_as_fast_as_differences_say() {
        for mut chain in chains() {
            for joint in chain.tables.iter_mut().chain(&mut chain.heads) {
                joint.center = [5.0, 6.0, 7.0];
            }
            let (part, length) = ([10.0, -20.0, 30.0], [0.0, 0.0, 50.0]);
            let (angles, turning) = ([30.0, 40.0], [7.0, -5.0]);
            let after = |share: f64| {
                let angle = |axis: usize| angles[axis] + turning[axis] * share;
                Vector3::from(chain.linear(part, length, angle))
            };
            let differs = (after(1e-5) - after(-1e-5)).norm() / 2e-5;
            let follows = chain.following(part, length, |axis| angles[axis], |axis| turning[axis]);
            assert!((differs - follows).abs() < 1e-6 && follows > 1.0, "{chain:?}: {differs} {follows}");
        }
    }

    #[test]
    fn the_tip_goes_there_and_back() {
        let mut chain = chains().remove(2);
        chain.tables[0].center = [5.0, 6.0, 0.0];
        chain.heads[0].center = [0.0, 0.0, 100.0];
        let of = |axis: usize| [90.0, 90.0][axis];
        let linear = chain.linear([1.0, 2.0, 3.0], [0.0, 0.0, 50.0], of);
        let back = chain.tip(linear, [0.0, 0.0, 50.0], of).unwrap();
        for (a, b) in back.into_iter().zip([1.0, 2.0, 3.0]) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
