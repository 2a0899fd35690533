//! The same part of a TNC in both languages: a conversational and an ISO program make the same moves in the same time,
//! and raise the same diagnostics. Parts are made at random, on the machine as it is shipped.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::log::event::{Kind, MotionKind};
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, cases, machine};
use proptest::prelude::*;

/// Radii of the tools.
const TOOLS: &str = "\
    [[tool.offsets]]\nnumber = 1\nradius = 1\n\n\
    [[tool.offsets]]\nnumber = 2\nradius = 2.5\n\n\
    [[tool.offsets]]\nnumber = 3\nradius = 4\n";

/// An element of a part; lengths in thousandths, angles in degrees.
#[derive(Debug, Clone)]
enum Element {
    Line { to: [i32; 2], feed: Option<u16>, increments: bool },
    Height(i32),
    Arc { to: [i32; 2], radius: i32, clockwise: bool },
    Tangent([i32; 2]),
    About { pole: [i32; 2], angle: i16, clockwise: bool },
    Polar { pole: [i32; 2], radius: i32, angle: i16 },
    Full { pole: [i32; 2], clockwise: bool },
    Round(i32),
    Chamfer(i32),
    Side(u8),
    Shift([i32; 2]),
    Turn(i16),
    Scale(u8),
    Hole([i32; 2]),
    Tool(u8),
    Repeat([i32; 2]),
    Dwell(u8),
    Coolant(bool),
}

fn element() -> impl Strategy<Value = Element> {
    let point = || prop::array::uniform2(-50_000_i32..50_000);
    prop_oneof![
        4 => (point(), prop::option::of(1_u16..9), any::<bool>())
            .prop_map(|(to, feed, increments)| Element::Line { to, feed: feed.map(|feed| feed * 100), increments }),
        1 => (-9_000_i32..9_000).prop_map(Element::Height),
        2 => (point(), 1_000_i32..90_000, any::<bool>())
            .prop_map(|(to, radius, clockwise)| Element::Arc { to, radius, clockwise }),
        1 => point().prop_map(Element::Tangent),
        2 => (point(), -360_i16..360, any::<bool>())
            .prop_map(|(pole, angle, clockwise)| Element::About { pole, angle, clockwise }),
        1 => (point(), 1_000_i32..50_000, -360_i16..360)
            .prop_map(|(pole, radius, angle)| Element::Polar { pole, radius, angle }),
        1 => (point(), any::<bool>()).prop_map(|(pole, clockwise)| Element::Full { pole, clockwise }),
        1 => (100_i32..5_000).prop_map(Element::Round),
        1 => (100_i32..5_000).prop_map(Element::Chamfer),
        1 => (0_u8..3).prop_map(Element::Side),
        1 => point().prop_map(Element::Shift),
        1 => (-180_i16..180).prop_map(Element::Turn),
        1 => (1_u8..5).prop_map(Element::Scale),
        1 => point().prop_map(Element::Hole),
        1 => (1_u8..6).prop_map(Element::Tool),
        1 => point().prop_map(Element::Repeat),
        1 => (1_u8..9).prop_map(Element::Dwell),
        1 => any::<bool>().prop_map(Element::Coolant),
    ]
}

/// Thousandths with a sign and a point.
fn shown(value: i32) -> String {
    format!("{:+.3}", f64::from(value) / 1000.0)
}

fn sign(clockwise: bool) -> char {
    if clockwise { '-' } else { '+' }
}

/// Both programs of a part.
fn spelled(elements: &[Element]) -> [String; 2] {
    let mut plain =
        String::from("0 BEGIN PGM P MM\nTOOL CALL 1 Z S1000 F200\nL X+0 Y+0 Z+50 R0 FMAX M3\nL X+1 Y+1 F500\n");
    let mut iso =
        String::from("%P G71 *\nN10 T1 G17 S1000 F200*\nN20 G00 G40 G90 X+0 Y+0 Z+50 M3*\nN30 G01 X+1 Y+1 F500*\n");
    // Where the program is, as far as it is a number of three places.
    let mut at = Some([1_000, 1_000]);
    let mut label = 0;
    for (count, element) in elements.iter().enumerate() {
        let n = 40 + count * 10;
        let (conversational, own) = match element {
            Element::Line { to, feed, increments } => {
                let [x, y] = to.map(shown);
                let (rate, motion) = match feed {
                    Some(feed) => (format!("F{feed}"), "G01"),
                    None => ("FMAX".to_owned(), "G00"),
                };
                let iso_rate = feed.map_or(String::new(), |feed| format!(" F{feed}"));
                let own = match at.filter(|_| *increments) {
                    Some(from) => {
                        let [x, y] = [to[0] - from[0], to[1] - from[1]].map(shown);
                        format!("N{n} {motion} G91 X{x} Y{y}{iso_rate}*\nN{} G90*", n + 1)
                    }
                    None => format!("N{n} {motion} X{x} Y{y}{iso_rate}*"),
                };
                at = Some(*to);
                (format!("L X{x} Y{y} {rate}"), own)
            }
            Element::Height(z) => (format!("L Z{}", shown(*z)), format!("N{n} G01 Z{}*", shown(*z))),
            Element::Arc { to, radius, clockwise } => {
                let ([x, y], r) = (to.map(shown), shown(*radius));
                at = Some(*to);
                let code = if *clockwise { "G02" } else { "G03" };
                (format!("CR X{x} Y{y} R{r} DR{}", sign(*clockwise)), format!("N{n} {code} X{x} Y{y} R{r}*"))
            }
            Element::Tangent(to) => {
                let [x, y] = to.map(shown);
                at = Some(*to);
                (format!("CT X{x} Y{y}"), format!("N{n} G06 X{x} Y{y}*"))
            }
            Element::About { pole, angle, clockwise } => {
                let [x, y] = pole.map(shown);
                at = None;
                let code = if *clockwise { "G12" } else { "G13" };
                (
                    format!("CC X{x} Y{y}\nCP PA{angle:+} DR{}", sign(*clockwise)),
                    format!("N{n} I{x} J{y}*\nN{} {code} H{angle:+}*", n + 1),
                )
            }
            Element::Polar { pole, radius, angle } => {
                let ([x, y], r) = (pole.map(shown), shown(*radius));
                at = None;
                (format!("CC X{x} Y{y}\nLP PR{r} PA{angle:+}"), format!("N{n} G11 I{x} J{y} R{r} H{angle:+}*"))
            }
            Element::Full { pole, clockwise } => {
                let [x, y] = pole.map(shown);
                let code = if *clockwise { "G02" } else { "G03" };
                (format!("CC X{x} Y{y}\nC DR{}", sign(*clockwise)), format!("N{n} {code} I{x} J{y}*"))
            }
            Element::Round(radius) => (format!("RND R{}", shown(*radius)), format!("N{n} G25 R{}*", shown(*radius))),
            Element::Chamfer(size) => {
                (format!("CHF {}", shown(*size).trim_start_matches('+')), format!("N{n} G24 R{}*", shown(*size)))
            }
            Element::Side(side) => {
                let (word, code) = [("R0", "G40"), ("RL", "G41"), ("RR", "G42")][usize::from(*side)];
                at = Some([7_000, 9_000]);
                (format!("L X+7 Y+9 {word}"), format!("N{n} G01 {code} X+7 Y+9*"))
            }
            Element::Shift(to) => {
                let [x, y] = to.map(shown);
                at = None;
                (
                    format!("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X{x}\nCYCL DEF 7.2 Y{y}"),
                    format!("N{n} G54 X{x} Y{y}*"),
                )
            }
            Element::Turn(angle) => {
                at = None;
                (format!("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT{angle:+}"), format!("N{n} G73 G90 H{angle:+}*"))
            }
            Element::Scale(factor) => {
                at = None;
                (format!("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL {factor}"), format!("N{n} G72 F{factor}*"))
            }
            Element::Hole(to) => {
                let [x, y] = to.map(shown);
                at = Some(*to);
                let cycle = "Q200=2 Q201=-10 Q206=150 Q202=5 Q210=0 Q203=+0 Q204=20 Q211=0.2";
                (
                    format!("CYCL DEF 200 DRILLING {cycle}\nL X{x} Y{y} R0 FMAX M99"),
                    format!("N{n} G200 {cycle}*\nN{} G00 G40 X{x} Y{y} M99*", n + 1),
                )
            }
            Element::Tool(tool) => (
                format!("L Z+50 R0 FMAX\nTOOL CALL {tool} Z S900 DR+0.1"),
                format!("N{n} G00 G40 Z+50*\nN{} T{tool} G17 S900 DR+0.1*", n + 1),
            ),
            Element::Repeat(by) => {
                let [x, y] = by.map(|by| shown(by / 10));
                at = None;
                label += 1;
                (
                    format!("LBL {label}\nL IX{x} IY{y} F300\nCALL LBL {label} REP 2"),
                    format!(
                        "N{n} G98 L{label}*\nN{} G01 G91 X{x} Y{y} F300*\nN{} G90*\nN{} L{label},2*",
                        n + 1,
                        n + 2,
                        n + 3
                    ),
                )
            }
            Element::Coolant(on) => {
                let code = if *on { "M8" } else { "M9" };
                (code.to_owned(), format!("N{n} {code}*"))
            }
            Element::Dwell(tenths) => {
                let time = f64::from(*tenths) / 10.0;
                (format!("CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL {time}"), format!("N{n} G04 F{time}*"))
            }
        };
        _ = writeln!(plain, "{conversational}");
        _ = writeln!(iso, "{own}");
    }
    [plain + "END PGM P MM\n", iso + "N99999999 %P G71 *\n"]
}

/// Moves of the axes: kind, end, feed and time of each move; the reports, and the time at the end.
#[derive(Debug)]
struct Ran {
    moves: Vec<(MotionKind, [f64; 3], f64, i64)>,
    told: Vec<u32>,
    end: i64,
}

fn ran(machine: &Arc<Machine>, text: &str) -> Ran {
    let done =
        Work::texts(Arc::clone(machine), &[text], JobOptions::default()).run(None).expect("the job can be prepared");
    let moves = done.events.iter().filter_map(|event| match &event.kind {
        Kind::Motion(motion) => {
            Some((motion.kind, [motion.to[0], motion.to[1], motion.to[2]], motion.feed, event.dur_ns))
        }
        _ => None,
    });
    Ran {
        moves: moves.collect(),
        told: done.summary.diagnostics.iter().map(|told| told.number).collect(),
        end: done.summary.makespan_ns,
    }
}

fn same(machine: &Arc<Machine>, elements: &[Element]) {
    let [plain, iso] = spelled(elements);
    let (one, two) = (ran(machine, &plain), ran(machine, &iso));
    assert_eq!(one.told, two.told, "\n{plain}\n{iso}");
    assert_eq!(one.moves.len(), two.moves.len(), "\n{plain}\n{iso}\n{:?}\n{:?}", one.moves, two.moves);
    for (at, (one, two)) in one.moves.iter().zip(&two.moves).enumerate() {
        let near = one.1.iter().zip(two.1).all(|(one, two)| (one - two).abs() < 2e-6);
        let alike = one.0 == two.0 && near && (one.2 - two.2).abs() < 1e-6 && (one.3 - two.3).abs() < 1_000;
        assert!(alike, "motion {at}: {one:?} {two:?}\n{plain}\n{iso}");
    }
    assert!((one.end - two.end).abs() < 10_000, "{} {}\n{plain}\n{iso}", one.end, two.end);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(300), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn an_iso_program_makes_the_part_of_the_conversational_one(mut elements in prop::collection::vec(element(), 1..14)) {
        // A corner needs a line after it.
        elements.push(Element::Line { to: [60_000, 60_000], feed: Some(500), increments: false });
        same(&machine("heidenhain-mill", TOOLS), &elements);
    }
}
