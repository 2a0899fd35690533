//! Random programs under frames of rotary axes against the same programs without them, their words worked out here.
//!
//! Tool tip control, work offsets, machine coordinates, reference points, distances and variables of positions go
//! through both.

use counterpoint_kernel::log::event::{Kind, Position};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, cases, machine};

/// Ends of the moves of a program that ends without a complaint.
fn ends(name: &str, text: &str) -> Vec<Position> {
    let options =
        JobOptions { limits: JobLimits { blocks: 2_000, ..JobLimits::default() }, threads: 1, ..JobOptions::default() };
    let done = Work::texts(machine(name, ""), &[text.to_owned()], options).run(None).expect("it can be prepared");
    for event in &done.events {
        assert!(!matches!(&event.kind, Kind::Diagnostic(_)), "{event:?} in\n{text}");
    }
    let moves = done.events.iter().filter_map(|event| match &event.kind {
        Kind::Motion(motion) => Some(motion.to),
        _ => None,
    });
    moves.collect()
}

/// A line of an axis: `programmed · factor + shift`.
#[derive(Debug, Clone, Copy)]
struct Line {
    factor: f64,
    shift: f64,
}

const SAME: Line = Line { factor: 1.0, shift: 0.0 };

impl Line {
    fn of(self, programmed: f64) -> f64 {
        programmed * self.factor + self.shift
    }

    fn after(self, first: Self) -> Self {
        Self { factor: self.factor * first.factor, shift: self.of(first.shift) }
    }
}

/// The parts of a frame that is beside X, Y and Z, for controls that set them one by one.
#[derive(Debug, Clone, Copy)]
struct Parts {
    factor: f64,
    mirror: Option<f64>,
    shift: f64,
}

const NO_PARTS: Parts = Parts { factor: 1.0, mirror: None, shift: 0.0 };

impl Parts {
    fn line(self) -> Line {
        let scaled = Line { factor: self.factor, shift: 0.0 };
        let mirrored = self.mirror.map_or(SAME, |at| Line { factor: -1.0, shift: 2.0 * at });
        Line { factor: 1.0, shift: self.shift }.after(mirrored).after(scaled)
    }
}

struct Chance(u64);

impl Chance {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % most
    }

    /// An even number of thousandths between −`most` and `most`.
    fn next(&mut self, most: u64) -> f64 {
        (self.below(most * 1_000 + 1) as f64 * 2.0 - most as f64 * 1_000.0).trunc() * 0.001
    }

    fn factor(&mut self) -> f64 {
        [2.0, 0.5, 4.0][self.below(3) as usize]
    }
}

/// Two programs that go to the same places, and where the model of the axis C stands.
struct Pair {
    framed: String,
    plain: String,
    line: Line,
    /// In the work frame.
    at: f64,
    /// C has a word after the change of its frame.
    known: bool,
}

impl Pair {
    fn new(head: &str) -> Self {
        Self { framed: head.to_owned(), plain: head.to_owned(), line: SAME, at: 0.0, known: false }
    }

    fn both(&mut self, text: &str) {
        self.framed += text;
        self.plain += text;
    }

    fn frame(&mut self, text: &str, line: Line) {
        self.framed += text;
        (self.line, self.known) = (line, false);
    }

    /// A move to X and to a programmed C; `block` writes it.
    fn to(&mut self, x: f64, c: f64, block: impl Fn(f64, f64) -> String) {
        self.at = self.line.of(c);
        self.known = true;
        self.framed += &block(x, c);
        self.plain += &block(x, self.at);
    }

    /// A distance of C.
    fn by(&mut self, c: f64, block: impl Fn(f64) -> String) {
        self.at += c * self.line.factor;
        self.framed += &block(c);
        self.plain += &block(c * self.line.factor);
    }

    /// X goes where C is programmed to be; `read` names that value.
    fn x_to_c(&mut self, read: &str, number: impl Fn(f64) -> String) {
        let programmed = (self.at - self.line.shift) / self.line.factor;
        self.framed += read;
        self.plain += &number(programmed);
    }

    fn check(&self, name: &str) {
        let (framed, plain) = (ends(name, &self.framed), ends(name, &self.plain));
        let same = |(a, b): (&Position, &Position)| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        let first = framed.iter().zip(&plain).position(|pair| !same(pair));
        let alike = first.is_none() && framed.len() == plain.len();
        assert!(alike, "move {first:?} of {name}: {framed:?}, not {plain:?}\n{}\n{}", self.framed, self.plain);
    }
}

#[test]
fn fanuc_shifts_and_mirrors() {
    let mut chance = Chance(11);
    for _ in 0..cases(60) {
        let mut pair = Pair::new(
            "O1\nG10 L2 P1 C3.\nG10 L2 P2 X5. C-7.5\nG10 L10 P1 R80.\nG90 G54 G0 X0. Y0. Z100. A0. C0.\nG1 F1000.\n",
        );
        let mut parts = NO_PARTS;
        let mut offset = 3.0;
        for _ in 0..14 {
            match chance.below(10) {
                0 | 1 => {
                    parts.shift = chance.next(90);
                    pair.frame(&format!("G52 C{:.3}\n", parts.shift), parts.line());
                }
                2 => {
                    let at = chance.next(40);
                    parts.mirror = Some(at);
                    pair.frame(&format!("G51.1 C{at:.3}\n"), parts.line());
                }
                3 => {
                    parts.mirror = None;
                    pair.frame("G50.1 C0.\n", parts.line());
                }
                4 => {
                    let (code, other) = if chance.below(2) == 0 { ("G54", 3.0) } else { ("G55", -7.5) };
                    pair.at += offset - other;
                    offset = other;
                    pair.both(&format!("{code}\n"));
                }
                5 if pair.known => {
                    let by = chance.next(30);
                    pair.by(by, |by| format!("G91 C{by:.3}\nG90\n"));
                }
                6 => {
                    let to = chance.next(60);
                    pair.at = to - offset;
                    pair.both(&format!("G53 G0 C{to:.3}\nG1\n"));
                }
                7 => {
                    pair.at = -offset;
                    pair.both("G91 G28 C0.\nG90\n");
                }
                8 => pair.x_to_c("X#5045\n", |c| format!("X{c:.3}\n")),
                _ => {
                    let code = ["G43.4 H1\n", "G49\n"][chance.below(2) as usize];
                    pair.both(code);
                }
            }
            let (x, c) = (chance.next(50), chance.next(100));
            pair.to(x, c, |x, c| format!("X{x:.3} C{c:.3}\n"));
        }
        pair.both("G49\nM30\n");
        pair.check("fanuc-mill-5axis-quiet");
    }
}

#[test]
fn siemens_frames_set_and_added() {
    let mut chance = Chance(12);
    for _ in 0..cases(60) {
        let mut pair = Pair::new("G17 G90 G54 G0 X0 Y0 Z100 A0 C0\nG1 F1000\n");
        for _ in 0..14 {
            let [shift, factor] = [chance.next(90), chance.factor()];
            let inner = pair.line;
            match chance.below(11) {
                0 => pair.frame(&format!("TRANS C{shift:.3}\n"), Line { factor: 1.0, shift }),
                1 => pair.frame(&format!("ATRANS X0 C{shift:.3}\n"), inner.after(Line { factor: 1.0, shift })),
                2 => pair.frame(&format!("SCALE C{factor}\n"), Line { factor, shift: 0.0 }),
                3 if inner.factor.abs() <= 1.0 => {
                    pair.frame(&format!("ASCALE C{factor}\n"), inner.after(Line { factor, shift: 0.0 }));
                }
                4 => pair.frame("MIRROR C0\n", Line { factor: -1.0, shift: 0.0 }),
                5 => pair.frame("AMIRROR C0\n", inner.after(Line { factor: -1.0, shift: 0.0 })),
                6 => pair.frame("TRANS\n", SAME),
                7 if pair.known => {
                    let by = chance.next(30);
                    pair.by(by, |by| format!("C=IC({by:.6})\n"));
                }
                8 => {
                    let to = chance.next(60);
                    pair.at = to;
                    pair.both(&format!("G53 G0 C{to:.3}\nG1\n"));
                }
                9 => pair.x_to_c("X=$AA_IW[C]\n", |c| format!("X{c:.6}\n")),
                _ => {
                    let code = ["TRAORI\n", "TRAFOOF\n"][chance.below(2) as usize];
                    pair.both(code);
                }
            }
            let (x, c) = (chance.next(50), chance.next(100));
            pair.to(x, c, |x, c| format!("X{x:.3} C{c:.6}\n"));
        }
        pair.both("TRAFOOF\nM30\n");
        pair.check("siemens-mill-5axis-quiet");
    }
}

#[test]
fn heidenhain_cycles() {
    let mut chance = Chance(13);
    for _ in 0..cases(60) {
        let head = "BEGIN PGM T MM\nTOOL CALL 1 Z S600 F600\nL X+0 Y+0 Z+100 A+0 C+0 R0 FMAX M3\n";
        let mut pair = Pair::new(head);
        let mut parts = NO_PARTS;
        for _ in 0..14 {
            match chance.below(10) {
                0 => {
                    parts.shift = chance.next(90);
                    pair.frame(&format!("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 C{:+.3}\n", parts.shift), parts.line());
                }
                1 => {
                    let more = chance.next(20);
                    parts.shift += more;
                    let text = format!("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 IC{more:+.3}\n");
                    pair.frame(&text, parts.line());
                }
                2 => {
                    parts.shift = chance.next(50);
                    pair.frame(&format!("TRANS DATUM AXIS C{:+.3}\n", parts.shift), parts.line());
                }
                3 => {
                    parts.shift = 0.0;
                    pair.frame("TRANS DATUM RESET\n", parts.line());
                }
                4 => {
                    parts.mirror = if chance.below(3) == 0 { None } else { Some(0.0) };
                    let axis = if parts.mirror.is_some() { "CYCL DEF 8.1 C\n" } else { "CYCL DEF 8.1\n" };
                    pair.frame(&format!("CYCL DEF 8.0 MIRROR IMAGE\n{axis}"), parts.line());
                }
                5 => {
                    parts.factor = [1.0, 2.0, 0.5][chance.below(3) as usize];
                    let text = format!("CYCL DEF 26.0 AXIS-SPECIFIC SCALING\nCYCL DEF 26.1 C {}\n", parts.factor);
                    pair.frame(&text, parts.line());
                }
                6 if pair.known => {
                    let by = chance.next(30);
                    pair.by(by, |by| format!("L IC{by:+.6}\n"));
                }
                7 => {
                    let to = chance.next(60);
                    pair.at = to;
                    pair.both(&format!("L C{to:+.3} FMAX M91\n"));
                }
                8 => pair.x_to_c("FN 18: SYSREAD Q1 = ID270 NR1 IDX6\nL X+Q1\n", |c| format!("L X{c:+.6}\n")),
                _ => {
                    let code = ["L M128\n", "L M129\n"][chance.below(2) as usize];
                    pair.both(code);
                }
            }
            let (x, c) = (chance.next(50), chance.next(100));
            pair.to(x, c, |x, c| format!("L X{x:+.3} C{c:+.6} F1000\n"));
        }
        pair.both("L M129\nEND PGM T MM\n");
        pair.check("heidenhain-mill-5axis-quiet");
    }
}
