//! Random tilted planes of three controls and of heads, against rotations that are worked out here.

use counterpoint_kernel::log::event::{Kind, Position};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, cases, machine};

type Point = [f64; 3];
type Matrix = [Point; 3];

/// Pseudo-random numbers that are the same on every machine.
struct Chance(u64);

impl Chance {
    /// A number of three decimals between −`most` and `most`.
    fn next(&mut self, most: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        ((share * 2.0 - 1.0) * most * 1e3).round() / 1e3
    }

    fn point(&mut self, most: f64) -> Point {
        [0; 3].map(|_| self.next(most))
    }
}

fn about(axis: char, degrees: f64) -> Matrix {
    let (s, c) = degrees.to_radians().sin_cos();
    match axis {
        'X' => [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]],
        'Y' => [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]],
        _ => [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]],
    }
}

fn times(a: &Matrix, p: Point) -> Point {
    a.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2])
}

/// Rotations, the last one first.
fn turned(p: Point, turns: &[(char, f64)]) -> Point {
    turns.iter().rev().fold(p, |p, (axis, angle)| times(&about(*axis, *angle), p))
}

fn plus(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn close(a: Point, b: Point, by: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < by)
}

/// The planes are far beyond the travel of the machines.
const WIDE: &str = "[[diagnostics]]\nnumber = 2900023\nenable = false\n\n";

/// Ends of the moves of a program that ends without a complaint.
fn ends(name: &str, overlay: &str, text: &str) -> Vec<Position> {
    let options =
        JobOptions { limits: JobLimits { blocks: 1_000, ..JobLimits::default() }, threads: 1, ..JobOptions::default() };
    let machine = machine(name, &format!("{WIDE}{overlay}"));
    let done = Work::texts(machine, &[text.to_owned()], options).run(None).expect("it can be prepared");
    for event in &done.events {
        assert!(!matches!(&event.kind, Kind::Diagnostic(_)), "{event:?} in\n{text}");
    }
    let moves = done.events.iter().filter_map(|event| match &event.kind {
        Kind::Motion(motion) => Some(motion.to),
        _ => None,
    });
    moves.collect()
}

/// A plane: where its zero is, its rotations, and a point of it.
struct Plane {
    zero: Point,
    turns: [(char, f64); 3],
    at: Point,
}

impl Plane {
    fn part(&self) -> Point {
        plus(self.zero, turned(self.at, &self.turns))
    }

    fn normal(&self) -> Point {
        turned([0.0, 0.0, 1.0], &self.turns)
    }
}

/// The tables A and C have the tool perpendicular to the plane, and the axes are where they bring the point. `fixture`:
/// from the part to the machine; `length`: of the tool.
fn check_tables(plane: &Plane, (a, c): (f64, f64), axes: Point, fixture: Point, length: f64, text: &str) {
    let tool = turned([0.0, 0.0, 1.0], &[('Z', c), ('X', a)]);
    assert!(close(tool, plane.normal(), 1e-6), "A{a} C{c}: {tool:?}, not {:?} in\n{text}", plane.normal());
    assert!((-120.0..=30.0).contains(&a), "A{a} in\n{text}");
    let brought = turned(plus(plane.part(), fixture), &[('X', -a), ('Z', -c)]);
    let wanted = plus(brought, [0.0, 0.0, length]);
    assert!(close(axes, wanted, 1.1e-3), "{axes:?}, not {wanted:?} in\n{text}");
}

fn last_of(ends: &[Position]) -> (Point, (f64, f64)) {
    let [x, y, z, a, c, ..] = *ends.last().expect("there is a move");
    ([x, y, z], (a, c))
}

/// Angles that lean the tool by less than the travel of A.
fn leaning(chance: &mut Chance) -> [f64; 3] {
    [chance.next(60.0), chance.next(60.0), chance.next(180.0)]
}

#[test]
fn fanuc_planes_by_euler_angles() {
    let mut chance = Chance(1);
    for _ in 0..cases(120) {
        let [lean, ..] = leaning(&mut chance);
        let [i, k] = [chance.next(360.0), chance.next(360.0)];
        let j = lean * 2.0;
        let plane = Plane { zero: chance.point(200.0), turns: [('Z', i), ('X', j), ('Z', k)], at: chance.point(100.0) };
        let (fixture, length) = (chance.point(300.0), chance.next(100.0) + 150.0);
        let ([fx, fy, fz], [ox, oy, oz], [x, y, z]) = (fixture, plane.zero, plane.at);
        let (a, c) = (chance.next(30.0), chance.next(400.0));
        let text = format!(
            "O1\nG10 L2 P1 X{fx:.3} Y{fy:.3} Z{fz:.3}\nG10 L10 P1 R{length:.3}\nG90 G54 G0 X0 Y0 Z0 A{a:.3} C{c:.3}\n\
             G68.2 X{ox:.3} Y{oy:.3} Z{oz:.3} I{i:.3} J{j:.3} K{k:.3}\nG53.1\nG43 H1 X{x:.3} Y{y:.3} Z{z:.3}\n\
             #101=#5021\n#102=#5022\n#103=#5023\nG69\nG49\nX1000. Y1000. Z1000.\nX#101 Y#102 Z#103\nM30\n"
        );
        let (axes, (a, c)) = last_of(&ends("fanuc-mill-5axis-quiet", "", &text));
        check_tables(&plane, (a, c), axes, fixture, length, &text);
    }
}

#[test]
fn heidenhain_planes_by_spatial_angles() {
    let mut chance = Chance(2);
    for case in 0..cases(120) {
        let [a, b, c] = leaning(&mut chance);
        let plane = Plane { zero: [0.0; 3], turns: [('Z', c), ('Y', b), ('X', a)], at: chance.point(100.0) };
        let length = chance.next(100.0) + 150.0;
        let overlay = format!("[[tool.offsets]]\nnumber = 1\nvalues = {{ Z = {length} }}\n");
        let [x, y, z] = plane.at;
        // The same machine, for any source of the turn.
        let turn = match case % 3 {
            0 => ("TURN FMAX", ""),
            1 => ("MOVE DIST50 FMAX", ""),
            _ => ("STAY", "L A+Q120 C+Q122 FMAX\n"),
        };
        let text = format!(
            "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S100\n2 L X+0 Y+0 Z+300 FMAX\n3 PLANE SPATIAL SPA{a:+.3} SPB{b:+.3} SPC{c:+.3} {}\n{}\
             4 L X{x:+.3} Y{y:+.3} Z{z:+.3} FMAX\n5 FN 18: SYSREAD Q1 = ID240 NR1 IDX1\n6 FN 18: SYSREAD Q2 = ID240 NR1 IDX2\n\
             7 FN 18: SYSREAD Q3 = ID240 NR1 IDX3\n8 PLANE RESET STAY\n9 L X+1000 Y+1000 Z+1000 FMAX\n\
             10 L X+Q1 Y+Q2 Z+Q3 FMAX\n11 END PGM T MM\n",
            turn.0, turn.1
        );
        let (axes, angles) = last_of(&ends("heidenhain-mill-5axis-quiet", &overlay, &text));
        check_tables(&plane, angles, axes, [0.0; 3], length, &text);
    }
}

#[test]
fn siemens_planes_axis_by_axis() {
    let mut chance = Chance(3);
    for case in 0..cases(90) {
        let [about_x, about_y, about_z] = leaning(&mut chance);
        let (mode, order) = [(57, "XYZ"), (27, "ZYX"), (54, "YXZ")][case as usize % 3];
        let mut order = order.chars().map(|axis| match axis {
            'X' => (axis, about_x),
            'Y' => (axis, about_y),
            _ => (axis, about_z),
        });
        let mut next = || order.next().expect("there are three");
        let turns = [next(), next(), next()];
        let plane = Plane { zero: chance.point(200.0), turns, at: chance.point(100.0) };
        let ([a, b, c], [ox, oy, oz], [x, y, z]) = (turns.map(|(_, angle)| angle), plane.zero, plane.at);
        let side = if chance.next(1.0) > 0.0 { 1 } else { -1 };
        let text = format!(
            "G17 G90 G500\nG0 X0 Y0 Z300\nCYCLE800(0,\"\",0,{mode},{ox:.3},{oy:.3},{oz:.3},{a:.3},{b:.3},{c:.3},0,0,0,{side},0)\n\
             G0 X{x:.3} Y{y:.3} Z{z:.3}\nR1=$AA_IM[X] R2=$AA_IM[Y] R3=$AA_IM[Z]\nCYCLE800()\nG0 X1000 Y1000 Z1000\n\
             G0 X=R1 Y=R2 Z=R3\nM30\n"
        );
        let (axes, (a, c)) = last_of(&ends("siemens-mill-5axis-quiet", "", &text));
        check_tables(&plane, (a, c), axes, [0.0; 3], 0.0, &text);
        // The other pair is the one with the other sign of A.
        let fits = if side > 0 { !(-30.0..-1e-9).contains(&a) } else { a <= 1e-9 };
        assert!(fits, "A{a} for {side} in\n{text}");
    }
}

/// A head C that carries a head B, both about the gauge point.
const HEADS: &str = r#"
[[data]]
id = "REG_AXIS_CH"
register = "C"

[[data]]
id = "REG_AXIS_BH"
register = "B"

[[axes]]
name = "X"
rapid = 40_000

[[axes]]
name = "Y"
rapid = 40_000

[[axes]]
name = "Z"
rapid = 40_000

[[axes]]
name = "C"
data = "REG_AXIS_CH"
rapid = 18_000

[[axes]]
name = "B"
data = "REG_AXIS_BH"
rapid = 9_000

[[channels]]
number = 1
name = "MAIN"
axes = ["X", "Y", "Z", "C", "B"]
spindle = 1
"#;

#[test]
fn heads_turn_the_tool_into_the_plane() {
    let mut chance = Chance(4);
    for _ in 0..cases(90) {
        let [i, j, k] = [chance.next(360.0), chance.next(170.0), chance.next(360.0)];
        let plane = Plane { zero: chance.point(200.0), turns: [('Z', i), ('X', j), ('Z', k)], at: chance.point(100.0) };
        let (fixture, length) = (chance.point(300.0), chance.next(100.0) + 150.0);
        let ([fx, fy, fz], [ox, oy, oz], [x, y, z]) = (fixture, plane.zero, plane.at);
        let text = format!(
            "O1\nG10 L2 P1 X{fx:.3} Y{fy:.3} Z{fz:.3}\nG10 L10 P1 R{length:.3}\nG90 G54 G0 G43 H1 X0 Y0 Z0\n\
             G68.2 X{ox:.3} Y{oy:.3} Z{oz:.3} I{i:.3} J{j:.3} K{k:.3}\nG53.1\nX{x:.3} Y{y:.3} Z{z:.3}\n\
             #101=#5021\n#102=#5022\n#103=#5023\nG69\nG49\nX1000. Y1000. Z1000.\nX#101 Y#102 Z#103\nM30\n"
        );
        let (axes, (c, b)) = last_of(&ends("fanuc-mill-5axis-quiet", HEADS, &text));
        let tool = turned([0.0, 0.0, 1.0], &[('Z', c), ('Y', b)]);
        assert!(close(tool, plane.normal(), 1e-6), "C{c} B{b}: {tool:?}, not {:?} in\n{text}", plane.normal());
        let [u, v, w] = plane.normal();
        let wanted = plus(plus(plane.part(), fixture), [u * length, v * length, w * length]);
        assert!(close(axes, wanted, 1.1e-3), "{axes:?}, not {wanted:?} in\n{text}");
    }
}

const FANUC: &[&str] = &[
    "G68.2 X10. Y5. Z1. I20. J30. K40.",
    "G68.2 P1 Q321 X1. Y2. Z3. I10. J20. K30.",
    "G68.2 P2 Q1 X0 Y0 Z0",
    "G68.2 P2 Q2 X10. Y0 Z1.",
    "G68.2 P2 Q3 X0 Y10. Z2.",
    "G68.2 P3 Q1 X1. Y1. Z1. I1. J0 K0",
    "G68.2 P3 Q2 I0 J-0.5 K1.",
    "G68.4 X1. Y1. Z1. I0 J10. K0",
    "G53.1",
    "G53.6",
    "G69",
    "G0 X10. Y20. Z30.",
    "G1 X-5. Y5. F500.",
    "G2 X10. Y10. R20.",
    "G41 D1 X3.",
    "G40 X0",
    "G43 H1",
    "G49",
    "G43.4 H1",
    "G54",
    "G55",
    "G52 X1. Y2.",
    "G52 X0 Y0",
    "G91",
    "G90",
    "G28 Z100.",
    "G53 Z200.",
    "G81 X5. Y5. Z-3. R2. F100.",
    "G80",
    "A-10. C20.",
    "G10 L2 P1 X5. Y6. Z7.",
    "#500=#5041+#5021",
    "G68 X0 Y0 R30.",
    "G51 X0 Y0 P2000",
    "G50",
];

const HEIDENHAIN: &[&str] = &[
    "PLANE SPATIAL SPA-30 SPB+20 SPC+10 TURN FMAX",
    "PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE DIST20 F1000 SEQ-",
    "PLANE PROJECTED PROPR+10 PROMIN+20 ROT+30 STAY",
    "PLANE VECTOR BX+1 BY+0 BZ+0.1 NX+0.1 NY+0.2 NZ+1 TURN MB MAX FMAX",
    "PLANE POINTS P1X+0 P1Y+0 P1Z+0 P2X+10 P2Y+0 P2Z+1 P3X+0 P3Y+10 P3Z+2 STAY",
    "PLANE RELATIV SPA+5 TURN FMAX",
    "PLANE AXIAL A-20 C+30 TURN FMAX",
    "PLANE RESET TURN FMAX",
    "PLANE RESET STAY",
    "CYCL DEF 19.1 A-20 B+0 C+10",
    "CYCL DEF 19.1",
    "L X+10 Y+20 Z+30 R0 FMAX",
    "L X+0 Y+5 RL F500",
    "L X+30",
    "L R0 Y+40",
    "CC X+0 Y+0",
    "C X+10 Y+0 DR+",
    "CYCL DEF 7.1 X+5 IY+3",
    "CYCL DEF 10.1 ROT+20",
    "CYCL DEF 11.1 SCL0.9",
    "M128",
    "M129",
    "L A+Q120 C+Q122 FMAX",
    "L Z+100 FMAX M91",
    "FN 18: SYSREAD Q1 = ID210 NR6",
];

const SIEMENS: &[&str] = &[
    "CYCLE800(0,\"\",0,57,10,20,30,-20,10,5,1,2,3,-1,0)",
    "CYCLE800(1,\"\",1,27,10,20,30,10,0,5,1,2,3,1,0)",
    "CYCLE800(5,\"\",10,64,0,0,0,10,20,0,0,0,0,1,20)",
    "CYCLE800(2,\"\",11,192,0,0,0,-10,20,0,0,0,0,0,0)",
    "CYCLE800()",
    "CYCLE800(0,\"0\")",
    "G0 X10 Y20 Z30",
    "G1 X5 F500",
    "G2 X10 Y10 CR=30",
    "G41 X3",
    "G40 X0",
    "TRANS X5 Y6",
    "AROT Z30",
    "TRANS",
    "TRAORI",
    "TRAFOOF",
    "A-10 C30",
    "G91",
    "G90",
    "SUPA Z300",
    "G54",
    "CYCLE81(50,0,2,-5)",
    "R1=$AA_IM[X]+$AA_IW[Z]",
];

/// Any program with planes runs alike with one thread and with several, and moves to places that exist.
#[test]
fn any_program_with_planes() {
    let mut chance = Chance(5);
    for case in 0..cases(90) as usize {
        let (name, lines) = [
            ("fanuc-mill-5axis-quiet", FANUC),
            ("heidenhain-mill-5axis-quiet", HEIDENHAIN),
            ("siemens-mill-5axis-quiet", SIEMENS),
        ][case % 3];
        let mut text = ["O1\nG90 G17 G0 F500.\n", "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100 F500\n", "G17 G90 F500\n"]
            [case % 3]
            .to_owned();
        for number in 0..30 {
            let line = lines[(chance.next(1000.0).abs() * 997.0) as usize % lines.len()];
            text += &if case % 3 == 1 { format!("{} {line}\n", number + 2) } else { format!("{line}\n") };
        }
        text += ["M30\n", "99 END PGM A MM\n", "M30\n"][case % 3];
        // Where alarms stop, few programs come far.
        let stops = case % 6 < 3;
        let axis = if case % 3 == 2 { "Z1" } else { "Z" };
        let overlay = format!(
            "[control]\nstops = {stops}\n\n[[tool.offsets]]\nnumber = 1\nvalues = {{ {axis} = 100 }}\nradius = 3\n"
        );
        let run = |threads| {
            let options = JobOptions {
                limits: JobLimits { blocks: 5_000, ..JobLimits::default() },
                threads,
                ..JobOptions::default()
            };
            Work::texts(machine(name, &overlay), &[text.clone()], options).run(None).expect("it can be prepared")
        };
        let (one, many) = (run(1), run(0));
        assert_eq!(one.events, many.events, "scheduling counts in\n{text}");
        for event in &one.events {
            if let Kind::Motion(motion) = &event.kind {
                let sound = motion.to.iter().chain(&motion.center).all(|value| value.abs() < 1e6);
                assert!(sound && event.dur_ns >= 0, "{motion:?} in\n{text}");
            }
        }
    }
}
