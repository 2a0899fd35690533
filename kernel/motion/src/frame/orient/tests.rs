//! Solutions against forward kinematics that are computed another way, and the manufacturers' tables of choices.

use nalgebra::{Rotation3, Unit, Vector3};

use super::*;
use crate::frame::kinematics::Joint;

const X: Point = [1.0, 0.0, 0.0];
const Y: Point = [0.0, 1.0, 0.0];
const Z: Point = [0.0, 0.0, 1.0];

fn joint(axis: usize, vector: Point) -> Joint<usize> {
    Joint { axis, vector, center: [0.0; 3] }
}

/// A table A that carries a table C.
fn tables() -> Chain<usize> {
    Chain { tables: vec![joint(0, X), joint(1, Z)], heads: vec![], tool: Z }
}

/// Pseudo-random numbers that are the same on every machine.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    }

    fn direction(&mut self) -> Point {
        loop {
            let v = [self.next(), self.next(), self.next()];
            if (0.1..1.0).contains(&Vector3::from(v).norm()) {
                return v;
            }
        }
    }
}

/// Direction of the tool on the part, by the rotations of nalgebra.
fn forward(chain: &Chain<usize>, angles: &[(usize, f64)]) -> Vector3<f64> {
    let turn = |joint: &Joint<usize>, sign: f64| {
        let angle = angles.iter().find(|(axis, _)| *axis == joint.axis).map_or(0.0, |(_, angle)| *angle);
        Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::from(joint.vector)), sign * angle.to_radians())
    };
    let mut tool = Vector3::from(chain.tool).normalize();
    for head in chain.heads.iter().rev() {
        tool = turn(head, 1.0) * tool;
    }
    // From the machine to the part: a table that turns by an angle turns the tool relative to the part by it.
    for table in &chain.tables {
        tool = turn(table, 1.0) * tool;
    }
    tool
}

const RULES: [PairRule; 4] = [
    PairRule { turns: TurnChoice::Nearest, way: PairChoice::Least, side: None, free: FreeAxisPolicy::Stays },
    PairRule { turns: TurnChoice::Nearest, way: PairChoice::AxisByAxis, side: None, free: FreeAxisPolicy::At(0.0) },
    PairRule {
        turns: TurnChoice::Half,
        way: PairChoice::Least,
        side: Some(TiltRequest::Larger(true)),
        free: FreeAxisPolicy::At(0.0),
    },
    PairRule {
        turns: TurnChoice::Half,
        way: PairChoice::Least,
        side: Some(TiltRequest::Larger(false)),
        free: FreeAxisPolicy::Stays,
    },
];

#[test]
fn random_chains_come_to_directions_that_they_reach() {
    let mut chance = Chance(20_260);
    let mut reached = 0;
    for case in 0..4_000 {
        let (first, second) = (joint(0, chance.direction()), joint(1, chance.direction()));
        let (tables, heads) = match case % 3 {
            0 => (vec![first, second], vec![]),
            1 => (vec![], vec![first, second]),
            _ => (vec![first], vec![second]),
        };
        let chain = Chain { tables, heads, tool: chance.direction() };
        let wanted = forward(&chain, &[(0, chance.next() * 170.0), (1, chance.next() * 170.0)]);
        let stands = [chance.next() * 400.0, chance.next() * 400.0];
        for rule in RULES {
            let stand = |axis: usize| RotaryAxisState { at: stands[axis], travel: None };
            let angles = chain.reach(wanted.into(), &rule, stand).unwrap();
            let comes = forward(&chain, &angles);
            assert!((comes - wanted).norm() < 1e-6, "{case} {rule:?} {chain:?} {angles:?}: {comes} {wanted}");
            for (axis, angle) in angles {
                match rule.turns {
                    TurnChoice::Nearest => assert!((angle - stands[axis]).abs() <= 180.0 + 1e-6),
                    TurnChoice::Half => assert!((-180.0..=180.0).contains(&angle) || angle == stands[axis]),
                }
            }
            reached += 1;
        }
        // Both pairs come there, and no pair that is left out has a shorter path.
        let rule = RULES[0];
        let stand = |axis: usize| RotaryAxisState { at: stands[axis], travel: None };
        let pairs = chain.pairs(wanted.into(), &rule, stand);
        assert!(!pairs.is_empty() && pairs.len() <= 2);
        let way =
            |angles: &[(usize, f64)]| angles.iter().map(|(axis, angle)| (angle - stands[*axis]).abs()).sum::<f64>();
        let chosen = way(&chain.reach(wanted.into(), &rule, stand).unwrap());
        for pair in &pairs {
            assert!((forward(&chain, &pair.angles) - wanted).norm() < 1e-6);
            assert!(chosen <= way(&pair.angles) + 1e-5);
        }
    }
    assert_eq!(reached, 16_000);
}

#[test]
fn random_travels_are_kept() {
    let mut chance = Chance(7);
    let mut outside = 0;
    for _ in 0..4_000 {
        let chain = tables();
        let wanted = chance.direction();
        let travels = [(-120.0, 30.0), (-10.0 + chance.next() * 300.0, 0.0)];
        let travels = travels.map(|(a, b): (f64, f64)| (a.min(b), a.max(b)));
        let stand = |axis: usize| RotaryAxisState { at: travels[axis].0, travel: Some(travels[axis]) };
        let rule = RULES[0];
        // By hand: the tool leans by the angle of A towards the direction of C.
        let lean = wanted[0].hypot(wanted[1]).atan2(wanted[2]).to_degrees();
        let towards = wanted[0].atan2(-wanted[1]).to_degrees();
        let whole = |angle: f64, (low, high): (f64, f64)| {
            (-3..=3).any(|turn| (low..=high).contains(&(angle + 360.0 * f64::from(turn))))
        };
        let possible = [(lean, towards), (-lean, towards + 180.0)]
            .iter()
            .any(|(a, c)| whole(*a, travels[0]) && whole(*c, travels[1]));
        match chain.reach(wanted, &rule, stand) {
            Ok(angles) => {
                assert!(possible, "{wanted:?} {travels:?} {angles:?}");
                let comes = forward(&chain, &angles);
                assert!((comes - Vector3::from(wanted).normalize()).norm() < 1e-6);
                assert!(
                    angles
                        .iter()
                        .all(|(axis, angle)| (travels[*axis].0 - 1e-6..=travels[*axis].1 + 1e-6).contains(angle))
                );
            }
            Err(error) => {
                outside += 1;
                assert!(error == OrientationError::Travel && !possible, "{wanted:?} {travels:?} {error:?}");
            }
        }
    }
    assert!((500..3_900).contains(&outside), "{outside}");
}

#[test]
fn the_table_of_a_heidenhain_manual() {
    // iTNC 530, PLANE SPATIAL SPA+0 SPB+45 SPC+0 with a tilting table A and a rotary table C: travel of A, start, SEQ.
    let half = 0.5_f64.sqrt();
    let tilted = [half, 0.0, half];
    let of = |travel: Option<(f64, f64)>, start: [f64; 2], side: Option<bool>| {
        let rule = PairRule {
            turns: TurnChoice::Half,
            way: PairChoice::LeastLarger,
            side: side.map(TiltRequest::Sign),
            free: FreeAxisPolicy::At(0.0),
        };
        let stand = |axis: usize| RotaryAxisState { at: start[axis], travel: travel.filter(|_| axis == 0) };
        let angle =
            |angles: &[(usize, f64)], axis| angles.iter().find(|(at, _)| *at == axis).map(|(_, angle)| angle.round());
        tables().reach(tilted, &rule, stand).map(|angles| [0, 1].map(|axis| angle(&angles, axis).unwrap()))
    };
    assert_eq!(of(None, [0.0, 0.0], None), Ok([45.0, 90.0]));
    assert_eq!(of(None, [0.0, 0.0], Some(true)), Ok([45.0, 90.0]));
    assert_eq!(of(None, [0.0, 0.0], Some(false)), Ok([-45.0, -90.0]));
    assert_eq!(of(None, [0.0, -105.0], None), Ok([-45.0, -90.0]));
    assert_eq!(of(None, [0.0, -105.0], Some(true)), Ok([45.0, 90.0]));
    assert_eq!(of(None, [0.0, -105.0], Some(false)), Ok([-45.0, -90.0]));
    assert_eq!(of(Some((-90.0, 10.0)), [0.0, 0.0], None), Ok([-45.0, -90.0]));
    assert_eq!(of(Some((-90.0, 10.0)), [0.0, 0.0], Some(true)), Err(OrientationError::Side));
    assert_eq!(of(None, [0.0, -135.0], Some(true)), Ok([45.0, 90.0]));
}

#[test]
fn axis_by_axis_is_not_the_least_sum() {
    // A −30 or 30, C 80 or −100: from A −10 the first one is nearer by A, the second one by the sum.
    let wanted = forward(&tables(), &[(0, -30.0), (1, 80.0)]);
    let stand = |axis: usize| RotaryAxisState { at: [-10.0, -100.0][axis], travel: None };
    let angle = |rule: PairRule| {
        let angles = tables().reach(wanted.into(), &rule, stand).unwrap();
        angles.iter().find(|(axis, _)| *axis == 0).map(|(_, angle)| angle.round()).unwrap()
    };
    assert_eq!(angle(RULES[0]), 30.0);
    assert_eq!(angle(RULES[1]), -30.0);
}

#[test]
fn turns_and_free_axes() {
    let stands = |at: f64, travel| RotaryAxisState { at, travel };
    assert_eq!(stands(350.0, None).turn(10.0, TurnChoice::Nearest), 370.0);
    assert_eq!(stands(350.0, None).turn(-180.0, TurnChoice::Half), 180.0);
    assert_eq!(stands(0.0, Some((0.0, 360.0))).turn(-90.0, TurnChoice::Half), 270.0);
    assert_eq!(stands(1000.0, Some((-100.0, 100.0))).turn(90.0, TurnChoice::Nearest), 90.0);
    assert_eq!(stands(0.0, Some((-10.0, 10.0))).turn(90.0, TurnChoice::Nearest), 90.0);
    let free = |free| {
        let rule = PairRule { free, ..RULES[0] };
        let angles = tables().reach(Z, &rule, |axis| stands([3.0, 77.0][axis], None)).unwrap();
        angles.iter().find(|(axis, _)| *axis == 1).map(|(_, angle)| *angle).unwrap()
    };
    assert_eq!(free(FreeAxisPolicy::Stays), 77.0);
    assert_eq!(free(FreeAxisPolicy::At(12.0)), 12.0);
    let single = Chain { tables: vec![], heads: vec![joint(0, Y)], tool: Z };
    assert_eq!(single.reach(Y, &RULES[0], |_| stands(0.0, None)), Err(OrientationError::Direction));
    assert_eq!(single.reach(X, &RULES[0], |_| stands(0.0, None)), Ok(vec![(0, 90.0)]));
}
