//! The same path, spelled in two ways: in every notation of a control, the axes go to the same places in the
//! same time. Paths are made at random; each move takes one of the spellings of its control at random.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::log::event::{Kind, MotionKind};
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::Work;
use proptest::prelude::*;

/// A move: rapid or with a feed, to a point in thousandths, spelled in one of several ways.
#[derive(Debug, Clone)]
struct Move {
    feed: Option<u16>,
    to: [i32; 3],
    way: u8,
}

fn moves() -> impl Strategy<Value = Vec<Move>> {
    let one = (prop::option::of(1_u16..9), prop::array::uniform3(-90_000_i32..90_000), any::<u8>())
        .prop_map(|(feed, to, way)| Move { feed: feed.map(|feed| feed * 100), to, way });
    prop::collection::vec(one, 1..12)
}

fn cases() -> ProptestConfig {
    ProptestConfig { cases: counterpoint_tests::cases(60), failure_persistence: None, ..ProptestConfig::default() }
}

fn machine(text: &str) -> Arc<Machine> {
    let mut user = MemoryFiles::default();
    user.insert("spellings/machine.toml", text);
    let loaded = load(&Overlay::new(user, counterpoint_tests::library()), "spellings");
    let findings = format!("{:?}", loaded.findings);
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("{findings}"))
}

/// The moves of the axes.
#[derive(Debug)]
struct Ran {
    /// Each motion: its kind, its end, its feed, how long it takes. Not when: a pass of a loop costs a tick.
    ends: Vec<(MotionKind, [f64; 3], f64, i64)>,
    told: Vec<(u32, u32)>,
}

fn ran(machine: &Arc<Machine>, text: &str) -> Ran {
    let work = Work::texts(Arc::clone(machine), &[text], JobOptions::default());
    let done = work.run(None).expect("the job can be prepared");
    let ends = done.events.iter().filter_map(|event| match &event.kind {
        Kind::Motion(motion) => {
            let to = [motion.to[0], motion.to[1], motion.to[2]];
            Some((motion.kind, to, motion.feed, event.dur_ns))
        }
        _ => None,
    });
    Ran { ends: ends.collect(), told: done.summary.diagnostics.iter().map(|told| (told.number, told.line)).collect() }
}

fn same(machine: &Arc<Machine>, plain: &str, other: &str) {
    let (one, two) = (ran(machine, plain), ran(machine, other));
    assert!(one.told.is_empty(), "{:?} of\n{plain}", one.told);
    assert!(two.told.is_empty(), "{:?} of\n{other}", two.told);
    assert_eq!(one.ends.len(), two.ends.len(), "\n{plain}\n{other}\n{:?}\n{:?}", one.ends, two.ends);
    for (at, (one, two)) in one.ends.iter().zip(&two.ends).enumerate() {
        let near = one.1.iter().zip(two.1).all(|(one, two)| (one - two).abs() < 2e-6);
        let on_time = (one.3 - two.3).abs() < 1_000;
        assert!(
            one.0 == two.0 && near && (one.2 - two.2).abs() < 1e-6 && on_time,
            "motion {at}: {one:?} {two:?}\n{plain}\n{other}"
        );
    }
}

/// Thousandths as a number with a point.
fn shown(value: i32) -> String {
    format!("{:.3}", f64::from(value) / 1000.0)
}

/// A path as each of these controls reads it.
fn plain(moves: &[Move]) -> String {
    let mut text = String::from("G90 G0 X0. Y0. Z0.\n");
    for step in moves {
        let [x, y, z] = step.to.map(shown);
        match step.feed {
            None => _ = writeln!(text, "G0 X{x} Y{y} Z{z}"),
            Some(feed) => _ = writeln!(text, "G1 X{x} Y{y} Z{z} F{feed}."),
        }
    }
    text + "M30\n"
}

fn siemens_machine() -> Arc<Machine> {
    machine(
        "extends = \"fanuc-mill-exact\"\n\n[ce]\nname = \"spellings\"\npreprocessor = \"siemens\"\n\n[format]\nrws = \"\"\n\
         rws_at = \"none\"\ncomment = [\";\", \"\"]\n",
    )
}

fn siemens(moves: &[Move]) -> String {
    let mut text = String::from("DEF REAL TO[3]\nDEF REAL HERE\nDEF INT NN\nG90 G0 X0. Y0. Z0.\n");
    let mut at = [0; 3];
    for (count, step) in moves.iter().enumerate() {
        let to = step.to;
        let by = [to[0] - at[0], to[1] - at[1], to[2] - at[2]];
        let (go, feed) = match step.feed {
            None => ("G0", String::new()),
            Some(feed) => ("G1", format!(" F={}/2", feed * 2)),
        };
        let words = |list: [String; 3]| format!("{go} X={} Y={} Z={}{feed}", list[0], list[1], list[2]);
        let line = match step.way % 15 {
            0 => words(to.map(|value| format!("{}+({})", shown(value - 500), 0.5))),
            1 => {
                let [x, y, z] = to.map(shown);
                format!("R1={x} R2={y} R3={z}\nR4=1\n{}", words(["R1".into(), "R[R4+1]".into(), "R[3]".into()]))
            }
            2 => words(by.map(|value| format!("IC({})", shown(value)))),
            3 => format!("G91\n{}\nG90", words(by.map(shown))),
            4 => format!("G90 {}", words(to.map(|value| format!("AC({})", shown(value))))),
            5 => format!("G91\n{}\nG90", words(to.map(|value| format!("AC({})", shown(value))))),
            6 => {
                let [x, y, z] = to.map(shown);
                format!("TO[0]=SET({x},{y},{z})\n{}", words(["TO[0]".into(), "TO[1]".into(), "TO[NN+2]".into()]))
            }
            7 => {
                let [x, y, z] = to.map(shown);
                format!(
                    "R9=1\nIF R9==2 GOTOF NO{count} IF R9==1 GOTOF YES{count}\nNO{count}: M30\nYES{count}: {}",
                    words([x, y, z])
                )
            }
            8 => {
                let [x, y, z] = to.map(shown);
                let feed = step.feed.unwrap_or(0);
                format!("MOVE({x},{y},{z},{feed})")
            }
            9 => format!(
                "WHILE HERE<3\nHERE=HERE+1\nIF HERE==2\n{}\nELSE\nR8=1\nENDIF\nENDWHILE\nHERE=0",
                words(to.map(shown))
            ),
            10 => format!(
                "FOR NN=1 TO 3\nCASE NN OF 2 GOTOF AT{count} DEFAULT GOTOF ON{count}\nAT{count}: {}\nON{count}:\nENDFOR\nNN=0",
                words(to.map(shown))
            ),
            11 => format!(
                "REPEAT\nR8=R8+1\nUNTIL R8>2\nR8=0\nLOOP\n{}\nGOTOF OUT{count}\nENDLOOP\nOUT{count}:",
                words(to.map(shown))
            ),
            12 => format!(
                "DEFINE TARGET{count} AS X={} Y={}\n{go} TARGET{count} Z={}{feed}",
                shown(to[0]),
                shown(to[1]),
                shown(to[2])
            ),
            13 => format!(
                "{go}{feed}\nMCALL PLACE({},{},{})\nM8\nF{} \nMCALL",
                shown(to[0]),
                shown(to[1]),
                shown(to[2]),
                step.feed.unwrap_or(100)
            ),
            _ => format!("PART{count}: R7=R7+1\n{}\nREPEAT PART{count} P=2\nR7=0", words(to.map(shown))),
        };
        text.push_str(&line);
        text.push('\n');
        at = to;
    }
    text + "M30\n%_N_MOVE_SPF\nPROC MOVE(REAL XX, REAL YY, REAL ZZ, INT FEED)\nIF FEED==0\nG0 X=XX Y=YY Z=ZZ\nELSE\n\
            G1 X=XX Y=YY Z=ZZ F=FEED\nENDIF\nRET\n%_N_PLACE_SPF\nPROC PLACE(REAL XX, REAL YY, REAL ZZ)\nX=XX Y=YY Z=ZZ\nRET\n"
}

fn okuma_machine() -> Arc<Machine> {
    machine("extends = \"fanuc-mill-exact\"\n\n[ce]\nname = \"spellings\"\npreprocessor = \"okuma\"\n")
}

fn okuma(moves: &[Move]) -> String {
    let mut text = String::from("O1\nG90 G0 X0. Y0. Z0.\n");
    let mut at = [0; 3];
    for (count, step) in moves.iter().enumerate() {
        let to = step.to;
        let by = [to[0] - at[0], to[1] - at[1], to[2] - at[2]];
        let (go, feed) = match step.feed {
            None => ("G0", String::new()),
            Some(feed) => ("G1", format!(" F=[{}/2]", feed * 2)),
        };
        let words = |list: [String; 3]| format!("{go} X={} Y={} Z={}{feed}", list[0], list[1], list[2]);
        let line = match step.way % 10 {
            0 => words(to.map(|value| format!("[{}+{}]", shown(value - 500), 0.5))),
            1 => {
                let [x, y, z] = to.map(shown);
                format!("LA1={x} LB={y} VC7={z}\nLC=7\n{}", words(["LA1".into(), "LB".into(), "VC[LC]".into()]))
            }
            2 => format!("G91 {}\nG90", words(by.map(shown))),
            3 => {
                let [x, y, z] = to.map(shown);
                format!("{go} X{x}\n$ Y={y}\n$Z{z}{feed}")
            }
            4 => {
                let [x, y, z] = to.map(shown);
                match step.feed {
                    None => format!("CALL O20 XX={x} YY={y} ZZ={z}"),
                    Some(feed) => format!("CALL O21 XX={x},YY={y} ZZ={z}\n$ FF={feed}"),
                }
            }
            5 => format!("LK=0\nN1{count} LK=LK+1\nIF [LK LT #3H] N1{count}\n{}", words(to.map(shown))),
            6 => format!(
                "IF [1 EQ 2] NNO{count}\nGOTO NYES{count}\nNNO{count} M30\nNYES{count} {}",
                words(to.map(shown))
            ),
            7 => words(to.map(|value| format!("SQRT[{0}*{0}]*{1}", shown(value), value.signum()))),
            8 => words(
                by.map(shown)
                    .into_iter()
                    .zip(["VSIOX", "VSIOY", "VSIOZ"])
                    .map(|(by, here)| format!("[{here}+{by}]"))
                    .collect::<Vec<_>>()
                    .try_into()
                    .unwrap(),
            ),
            _ => format!("{go} X[{}]Y[{}]Z[{}]{feed}", shown(to[0]), shown(to[1]), shown(to[2])),
        };
        text.push_str(&line);
        text.push('\n');
        at = to;
    }
    text + "M30\nO20\nG0 X=XX Y=YY Z=ZZ\nRTS\nO21\nG1 X=XX Y=YY Z=ZZ F=FF\nRTS\n"
}

/// The machine of the page of path blocks.
fn heidenhain_machine() -> Arc<Machine> {
    machine(include_str!("../spec/machines/mill-tnc.toml"))
}

fn heidenhain_plain(moves: &[Move]) -> String {
    let mut text = String::from("0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n");
    for step in moves {
        let [x, y, z] = step.to.map(shown);
        match step.feed {
            None => _ = writeln!(text, "L X{x} Y{y} Z{z} R0 FMAX"),
            Some(feed) => _ = writeln!(text, "L X{x} Y{y} Z{z} R0 F{feed}"),
        }
    }
    text + "9999 M30\n"
}

fn heidenhain(moves: &[Move]) -> String {
    let mut text = String::from("0 BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\n");
    let mut at = [0; 3];
    let mut labels = String::new();
    for (count, step) in moves.iter().enumerate() {
        let to = step.to;
        let by = [to[0] - at[0], to[1] - at[1], to[2] - at[2]];
        let label = count + 10;
        let feed = step.feed.map_or(" FMAX".to_owned(), |feed| format!(" F{feed}"));
        let [x, y, z] = to.map(shown);
        let line = match step.way % 12 {
            0 => format!("L IX{} IY{} IZ{}{feed}", shown(by[0]), shown(by[1]), shown(by[2])),
            1 => format!("L IX{} Y{y} IZ{}{feed}", shown(by[0]), shown(by[2])),
            2 => format!("Q1 = {x}\nFN 0: Q2 = +{y}\nFN 1: QL3 = +{z} + +1.5\nQL3 = QL3 - 1.5\nL XQ1 Y+Q2 ZQL3{feed}"),
            3 => format!("L X{} Y{} Z{}{feed}", x.replace('.', ","), y.replace('.', ","), z.replace('.', ",")),
            4 => {
                // About a pole 10 before the point.
                let (px, py) = (to[0] - 10_000, to[1]);
                let polar = format!("CC X{} Y{}\nLP PR+10 PA+0 Z{z}{feed}", shown(px), shown(py));
                polar
            }
            5 => {
                let (px, py) = (to[0], to[1] + 7_500);
                format!("CC X{} Y{}\nLP PR7,5 PA-90 IZ{}{feed}", shown(px), shown(py), shown(by[2]))
            }
            6 => {
                _ = write!(labels, "LBL {label}\nL X{x} Y{y} Z{z}{feed}\nLBL 0\n");
                format!("CALL LBL {label}")
            }
            7 => {
                _ = write!(labels, "LBL \"P{label}\"\nL X+Q31 Y+Q32 Z+Q33{feed}\nLBL 0\n");
                format!("Q31 = {x}\nQ32 = {y}\nQ33 = {z}\nCALL LBL \"P{label}\"")
            }
            8 => format!(
                "FN 0: Q5 = +0\nLBL {label}\nFN 1: Q5 = +Q5 + +1\nFN 12: IF +Q5 LT +3 GOTO LBL {label}\nL X{x} Y{y} Z{z}{feed}"
            ),
            9 => format!(
                "Q6 = 0\nLBL {label}\nQ6 = Q6 + 1\nCALL LBL {label} REP 2\nQ7 = {x} * Q6 / 3\nL XQ7 Y{y} Z{z}{feed}"
            ),
            10 => format!("; a comment ~\nL X+0 Y+0 ~\nL Z+0\nL X{x} ~\n Y{y} ~\n Z{z}{feed}"),
            _ => format!(
                "QR1 = SQRT ( SQ ( {x} ) ) * SGN {x}\nQS1 = TOCHAR ( DAT{y} DECIMALS3 )\nQ8 = TONUMB ( SRC_QS1 )\nL XQR1 YQ8 Z{z}{feed}"
            ),
        };
        text.push_str(&line);
        text.push('\n');
        at = to;
    }
    format!("{text}M30\n{labels}")
}

/// Circles of conversational programs: by centre, radius, angle, tangent.
fn circles(arcs: &[(i32, i32, bool, u8)], plain: bool) -> String {
    let mut text = String::from("0 BEGIN PGM A MM\nL X+0 Y+0 Z+0 F500\nL X+1\n");
    let (mut x, mut y) = (1.0_f64, 0.0_f64);
    for &(radius, degrees, clockwise, way) in arcs {
        let radius = f64::from(radius);
        // Centre to the left or right, straight up or down of the start.
        let (cx, cy) = (x, y + radius);
        let sweep = f64::from(if clockwise { -degrees } else { degrees });
        let end = (-90.0 + sweep).to_radians();
        let (ex, ey) = (cx + radius * end.cos(), cy + radius * end.sin());
        let turn = if clockwise { "DR-" } else { "DR+" };
        let line = match if plain { 0 } else { way % 6 } {
            0 => format!("CC X{cx:.9} Y{cy:.9}\nC X{ex:.9} Y{ey:.9} {turn}"),
            1 => {
                let sign = if degrees > 180 { "-" } else { "+" };
                format!("CR X{ex:.9} Y{ey:.9} R{sign}{radius} {turn}")
            }
            2 => format!("CC IX0 IY{radius}\nCP IPA{sweep} {turn}"),
            3 => format!("CC IX+0 IY+{radius}\nCP PA{} {turn}", -90.0 + sweep),
            4 => format!("CC X{cx:.9} Y{cy:.9}\nC IX{:.9} IY{:.9} {turn}", ex - x, ey - y),
            _ => format!("G91 I0 J{radius}\nG90 {} H{}", if clockwise { "G12" } else { "G13" }, -90.0 + sweep),
        };
        text.push_str(&line);
        text.push('\n');
        (x, y) = (ex, ey);
    }
    text + "M30\n"
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn siemens_spellings(moves in moves()) {
        same(&siemens_machine(), &plain(&moves), &siemens(&moves));
    }

    #[test]
    fn okuma_spellings(moves in moves()) {
        same(&okuma_machine(), &plain(&moves), &okuma(&moves));
    }

    #[test]
    fn heidenhain_spellings(moves in moves()) {
        same(&heidenhain_machine(), &heidenhain_plain(&moves), &heidenhain(&moves));
    }

    #[test]
    fn heidenhain_circles(arcs in prop::collection::vec((1_i32..50, prop::sample::select(vec![30, 45, 90, 135, 170, 190, 250, 269]), any::<bool>(), any::<u8>()), 1..8)) {
        same(&heidenhain_machine(), &circles(&arcs, true), &circles(&arcs, false));
    }
}

fn siemens_mill() -> Arc<Machine> {
    machine("extends = \"siemens-mill-exact\"\n\n[ce]\nname = \"spellings\"\n")
}

/// A path on the shipped Siemens mill, with lines written by `line`, between two texts.
fn on_siemens(before: &str, moves: &[Move], line: impl Fn(&Move) -> String, after: &str) -> String {
    let lines: Vec<String> = moves.iter().map(line).collect();
    format!("G17 G90 G94 G54\nG0 X0 Y0 Z0\n{before}\n{}\n{after}\nM30\n", lines.join("\n"))
}

fn in_mm(step: &Move) -> String {
    let [x, y, z] = step.to.map(shown);
    match step.feed {
        None => format!("G0 X{x} Y{y} Z{z}"),
        Some(feed) => format!("G1 X{x} Y{y} Z{z} F{feed}"),
    }
}

proptest! {
    #![proptest_config(cases())]

    /// G70 converts lengths, G700 feeds as well.
    #[test]
    fn inches_of_siemens(moves in moves(), feeds in any::<bool>()) {
        let line = |step: &Move, inch: bool| {
            // Ten thousandths of an inch.
            let [x, y, z] = step.to.map(|value| f64::from(value) / 10_000.0 * if inch { 1.0 } else { 25.4 });
            let words = format!("X={x:.5} Y={y:.5} Z={z:.5}");
            match step.feed {
                None => format!("G0 {words}"),
                Some(feed) if feeds && inch => format!("G1 {words} F={:.3}", f64::from(feed) / 10.0),
                Some(feed) => format!("G1 {words} F={:.3}", f64::from(feed) * 2.54),
            }
        };
        let mm = on_siemens("", &moves, |step| line(step, false), "");
        let other = on_siemens(if feeds { "G700" } else { "G70" }, &moves, |step| line(step, true), "");
        same(&siemens_mill(), &mm, &other);
    }

    /// A rotation of the settable frame is one of the programmable frame.
    #[test]
    fn rotated_settable_frames(moves in moves(), angle in -179_i32..180, shift in -50_i32..50) {
        let rotated = on_siemens(&format!("ROT RPL={angle}\nATRANS X{shift}"), &moves, in_mm, "ROT");
        let before = format!("$P_UIFR[2]=CROT(Z,{angle})\nG55\nTRANS X{shift}");
        let settable = on_siemens(&before, &moves, in_mm, "TRANS");
        same(&siemens_mill(), &rotated, &settable);
    }

    /// FA counts wherever it stands, and the order of positioning axes does not matter.
    #[test]
    fn orders_of_positioning_axes(moves in moves(), fast in 1_u16..9, slow in 1_u16..9) {
        let words = |step: &Move| {
            let [x, y, z] = step.to.map(shown);
            let own = step.feed.unwrap_or(500);
            [format!("POS[X]={x}"), format!("POS[Y]={y}"), format!("FA[X]={fast}00"), format!("FA[Y]={slow}00"), format!("G1 Z{z} F{own}")]
        };
        let one = on_siemens("", &moves, |step| words(step).join(" "), "");
        let order = |step: &Move| {
            let mut words = words(step).to_vec();
            let turns = usize::from(step.way) % words.len();
            words.rotate_left(turns);
            words.swap(0, usize::from(step.way / 5) % 5);
            words.join(" ")
        };
        same(&siemens_mill(), &one, &on_siemens("", &moves, order, ""));
    }

    /// Words in comments, texts and names are not words of the block.
    #[test]
    fn words_in_texts_and_names(moves in moves()) {
        let decoys = ["; SPOS=90 WAITS(1)", "; T=\"DRILL\" SETMS(1)", "ASPOS=ASPOS+1", "MSG(\"SPOS=1 TRAORI(1)\")"];
        let with = |step: &Move| {
            let decoy = decoys[usize::from(step.way) % decoys.len()];
            if decoy.starts_with(';') { format!("{} {decoy}", in_mm(step)) } else { format!("{}\n{decoy}", in_mm(step)) }
        };
        let plain = format!("DEF REAL ASPOS\n{}", on_siemens("", &moves, in_mm, ""));
        let other = format!("DEF REAL ASPOS\n{}", on_siemens("", &moves, with, ""));
        same(&siemens_mill(), &plain, &other);
    }
}
