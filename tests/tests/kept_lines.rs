//! A kernel's memory of repeated lines changes nothing: a job with a trace, which keeps nothing, has the same events.
//!
//! Programs are made at random: loops and jumps, calls with and without arguments, modal calls and cycles,
//! compensation, frames and incremental words. Their order makes a line come again in another state than the first
//! time.

use counterpoint_kernel::log::event::{Event, Kind};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Done, Work, cases, machine};
use proptest::prelude::*;

/// A control: its machine, the text around the lines, and the lines of its programs.
struct Control {
    machine: &'static str,
    overlay: &'static str,
    head: &'static str,
    tail: &'static str,
    /// Opens and closes a loop of three passes; `@` stands for its number.
    loops: [&'static str; 2],
    /// A loop is a jump back to a label, which has a number of its own.
    jumps: bool,
    lines: &'static [&'static str],
}

const OFFSETS: &str = "
[[tool.offsets]]
number = 1
radius = 0.5

[[tool.offsets]]
number = 2
radius = 0.25
";

const FANUC: Control = Control {
    machine: "fanuc-mill",
    overlay: OFFSETS,
    head: "O1\n#101=0 #102=0 #103=0\nG90 G17 G94 F500 S1000 M3\nG0 X0 Y0 Z5.",
    tail: "G40 G80 G67\nM30\n\
           O77\nG91 G1 X1. F200\nG90\nM99\n\
           O78 (TWICE)\n#105=#105+1\nG1 Y[#105/10]\nM99\n\
           O79\nIF[#4EQ2]GOTO5\nG1 X#1 Y#2\nN5 M99\n\
           O80 G1 X3.\nM98 P77\nM99\n\
           O81\nM98 P78 L2\n/M98 P77\nM99",
    loops: ["#10@=0\nWHILE[#10@LT3]DO@\n#10@=#10@+1", "END@"],
    jumps: false,
    lines: &[
        "G1 X1. Y1.",
        "G1 X5. Y2. F300",
        "X4.",
        "Y[#101+3]",
        "G0 X0 Y0",
        "G2 X3. Y3. R4.",
        "G3 I-1. J0",
        "G91",
        "G90",
        "G41 D1",
        "G42 D2",
        "G40",
        "G1 G41 D1 X6. Y6.",
        "G40 G1 X0 Y0",
        "M98 P77",
        "M98 P78",
        "M98 P78 L3",
        "M98 P80",
        "M98 P81",
        "M98 P79",
        "G65 P79 A1. B2.",
        "G65 P79 A#101 B2. I2",
        "G66 P79 A2. B1.",
        "G66.1 P79 A2. B1.\nA3. B2.\nG67",
        "G67",
        "G81 Z-1. R1. F100",
        "G83 Z-3. R1. Q1. F100",
        "G80",
        "G68 X1. Y1. R30.",
        "G69",
        "G52 X1. Y2.",
        "G52 X0 Y0",
        "G51 X0 Y0 P2000",
        "G50",
        "G54",
        "G55",
        "G92 X1.",
        "G18",
        "G17",
        "G20",
        "G21",
        "G43 H1 Z10.",
        "G49",
        "#105=#101+#102",
        "#500=#500+1",
        "IF[#500GT4]THEN #500=0",
        "IF[#101EQ2]THEN #501=#501+1",
        "#104=SIN[#101*30]",
        "M8",
        "M9",
        "T2 M6",
        "G4 P100",
        "G28 X0",
        "G93 F2",
        "G94 F400",
        "/G1 X7.",
        "/2 M98 P77",
        "G10 L2 P1 X#101",
        "G10 L12 P1 R1.",
        "G9 X2.",
        "(COMMENT)",
        "#3003=1",
        "S2000",
    ],
};

const SIEMENS: Control = Control {
    machine: "siemens-mill",
    overlay: OFFSETS,
    head: "%_N_MAIN_MPF\nDEF REAL WIDE\nR1=0 R2=0 R3=0 R5=0 WIDE=2\nG90 G17 G94 F500 S1000 M3\nT1 D1\nG0 X0 Y0 Z5",
    tail: "G40\nMCALL\nTRANS\nM30\n\
           %_N_L77_SPF\nG91 G1 X1 F200\nG90\nM17\n\
           %_N_L78_SPF\nR5=R5+1\nG1 Y=R5/10\nRET\n\
           %_N_AWAY_SPF\nPROC AWAY(REAL _X, REAL _Y)\nIF _X>2 GOTOF FAR\nG1 X=_X Y=_Y\nFAR:\nRET\n\
           %_N_L80_SPF\nL77\nL78 P2\nM17",
    loops: ["FOR R@=1 TO 3", "ENDFOR"],
    jumps: false,
    lines: &[
        "G1 X1 Y1",
        "G1 X5 Y2 F300",
        "X4",
        "Y=R1+3",
        "X=IC(1)",
        "G0 X0 Y0",
        "G2 X=IC(1) Y=IC(1) CR=4",
        "G3 I-1 J0",
        "G91",
        "G90",
        "G41",
        "G42",
        "G40",
        "G1 G41 X6 Y6",
        "G40 G1 X0 Y0",
        "L77",
        "L78",
        "L78 P3",
        "L80",
        "AWAY(R1,2)",
        "AWAY(1,R2)",
        "MCALL L77",
        "MCALL AWAY(1,2)",
        "MCALL CYCLE81(10,0,2,-3)",
        "MCALL",
        "CYCLE82(10,0,2,-3,,1)",
        "TRANS X1 Y2",
        "ATRANS X=R1",
        "TRANS",
        "ROT RPL=30",
        "AROT RPL=10",
        "SCALE X2 Y2",
        "MIRROR X0",
        "ROT",
        "G54",
        "G55",
        "G500",
        "G18",
        "G17",
        "D2",
        "D1",
        "D0",
        "R5=R1+R2",
        "WIDE=WIDE*1.1",
        "R6=SIN(R1*30)",
        "IF R1==2\nR6=R6+1\nENDIF",
        "M8",
        "M9",
        "G4 F0.1",
        "/G1 X7",
        "/2 L77",
        "G1 X=IC(1) RND=0.1\nY=IC(1)",
        "RNDM=0.1",
        "RNDM=0",
        "$P_UIFR[1]=CTRANS(X,R1)",
        "G9 X2",
        "; COMMENT",
        "MSG(\"HERE\")",
        "S2000",
    ],
};

const OKUMA: Control = Control {
    machine: "okuma-mill",
    overlay: OFFSETS,
    head: "$MAIN.MIN%\nOMAIN\nVC1=0 VC2=0 VC3=0 VC5=0\nG90 G17 G94 F500 S1000 M3\nG15 H1\nG0 X0 Y0 Z5",
    tail: "G40 G80\nM2\n\
           O77\nG91 G1 X1 F200\nG90\nRTS\n\
           O78\nVC5=VC5+1\nG1 Y=VC5/10\nRTS\n\
           O79\nIF [PX GT 2] NFAR\nG1 X=PX Y=PY\nNFAR RTS\n\
           O80\nCALL O77\nCALL O78 Q2\nRTS",
    loops: ["VC@=0\nN@00 VC@=VC@+1", "IF [VC@ LT 3] N@00"],
    jumps: true,
    lines: &[
        "G1 X1 Y1",
        "G1 X5 Y2 F300",
        "X4",
        "Y=VC1+3",
        "G0 X0 Y0",
        "G2 X=VC1*10 Y3 R40",
        "G3 I-1 J0",
        "G91",
        "G90",
        "G41 D1",
        "G42 D2",
        "G40",
        "G1 G41 D1 X6 Y6",
        "G40 G1 X0 Y0",
        "CALL O77",
        "CALL O78",
        "CALL O78 Q3",
        "CALL O80",
        "CALL O79 PX=1 PY=2",
        "CALL O79 PX=VC1 PY=VC2",
        "MODIN O77",
        "MODIN O79 PX=2 PY=1",
        "MODOUT",
        "G81 Z-1 R1 F100",
        "G83 Z-3 R1 Q1 F100",
        "G80",
        "NCYL X3",
        "G11 X1 Y1 P30",
        "G10",
        "G15 H2",
        "G15 H1",
        "G16 H2 X1",
        "G18",
        "G17",
        "G56 H1 Z10",
        "G53",
        "VC5=VC1+VC2",
        "VC50=VC50+1",
        "LL=VC1",
        "VC51=SIN[VC1*30]",
        "M8",
        "M9",
        "T2 M6",
        "G4 F0.1",
        "/G1 X7",
        "VZOFX[1]=VC1",
        "(COMMENT)",
        "NOEX X5",
        "S2000",
    ],
};

const HEIDENHAIN: Control = Control {
    machine: "heidenhain-mill",
    overlay: OFFSETS,
    head: "BEGIN PGM MAIN MM\nTOOL CALL 1 Z S1000\nQ1 = 0\nQ2 = 0\nQ3 = 0\nQ5 = 0\nL X+0 Y+0 Z+5 R0 FMAX M3\nCYCL DEF 200 BOHREN Q200=+2 Q201=-3 Q206=+100 Q202=+1 Q210=+0 Q203=+0 Q204=+10 Q211=+0\nL Z+4 F500\nCC X+2 Y+2",
    tail: "L X+0 Y+0 R0 FMAX\nM2\n\
           LBL 77\nL IX+1 F200\nLBL 0\n\
           LBL 78\nQ5 = Q5 + 1\nL Y+Q5\nLBL 0\n\
           LBL 80\nCALL LBL 77\nCALL LBL 78\nLBL 0\n\
           END PGM MAIN MM",
    loops: ["LBL @\nQ@ = Q@ + 1", "CALL LBL @ REP 2"],
    jumps: true,
    lines: &[
        "L X+1 Y+1 F500",
        "L X+5 Y+2 F300",
        "L X+4",
        "L Y+Q1",
        "L IX+1",
        "L X+0 Y+0 FMAX",
        "L X+0 Y+0 R0",
        "CC X+2 Y+2",
        "L X+2 Y+0 R0\nC X+2 Y+4 DR+",
        "CR IX+1 IY+1 R+4 DR-",
        "L IX+1\nCT IX+4 IY+4",
        "LP PR+3 PA+30",
        "L IX+1\nRND R0.1\nL IY+1",
        "L IX+1\nCHF 0.1\nL IY+1",
        "CALL LBL 77",
        "CALL LBL 78",
        "CALL LBL 80",
        "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 X+Q1",
        "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 IX+1",
        "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 X+0",
        "CYCL DEF 8.0 SPIEGELN\nCYCL DEF 8.1 X",
        "CYCL DEF 8.0 SPIEGELN\nCYCL DEF 8.1",
        "CYCL DEF 10.0 DREHUNG\nCYCL DEF 10.1 ROT+30",
        "CYCL DEF 10.0 DREHUNG\nCYCL DEF 10.1 ROT+0",
        "CYCL DEF 11.0 MASSFAKTOR\nCYCL DEF 11.1 SCL 2",
        "CYCL DEF 11.0 MASSFAKTOR\nCYCL DEF 11.1 SCL 1",
        "CYCL DEF 9.0 VERWEILZEIT\nCYCL DEF 9.1 V.ZEIT 0.1",
        "CYCL DEF 200 BOHREN Q200=+2 Q201=-3 Q206=+100 Q202=+1 Q210=+0 Q203=+0 Q204=+10 Q211=+0",
        "L X+3 Y+3 FMAX M99",
        "CYCL CALL",
        "L X+3 Y+1 FMAX M89",
        "L X+2 M8",
        "L X+1 M91",
        "L X+1 M98",
        "Q5 = Q1 + Q2",
        "Q6 = SIN ( Q1 * 30 )",
        "FN 1: Q50 = +Q50 + +1",
        "FN 0: Q51 = +Q1",
        "QL1 = Q1 + 1",
        "/L X+7",
        "; COMMENT",
        "TOOL CALL 2 Z S2000",
        "TOOL CALL S1500",
        "M8",
        "M9",
        "STOP M9",
    ],
};

/// The text of a program: pieces by their number, a nested list is a loop.
#[derive(Debug, Clone)]
enum Piece {
    Line(usize),
    Loop(Vec<Piece>),
}

fn pieces() -> impl Strategy<Value = Vec<Piece>> {
    let line = any::<prop::sample::Index>().prop_map(|index| Piece::Line(index.index(1 << 20)));
    let inner = prop::collection::vec(line.clone(), 1..10).prop_map(Piece::Loop);
    let outer = prop::collection::vec(prop_oneof![5 => line.clone(), 1 => inner], 1..12).prop_map(Piece::Loop);
    prop::collection::vec(prop_oneof![2 => line, 3 => outer], 1..6)
}

/// Loops are numbered by their depth where the control knows them as loops, and by their order where they are jumps.
fn write(control: &Control, pieces: &[Piece], depth: u8, count: &mut u8, text: &mut String) {
    for piece in pieces {
        match piece {
            Piece::Line(index) => {
                text.push_str(control.lines[index % control.lines.len()]);
                text.push('\n');
            }
            Piece::Loop(inner) => {
                *count += 1;
                let number = if control.jumps { *count } else { depth };
                let [open, close] = control.loops.map(|part| part.replace('@', &number.to_string()));
                text.push_str(&format!("{open}\n"));
                write(control, inner, depth + 1, count, text);
                text.push_str(&format!("{close}\n"));
            }
        }
    }
}

fn program(control: &Control, pieces: &[Piece]) -> String {
    let mut body = String::new();
    write(control, pieces, 1, &mut 0, &mut body);
    format!("{}\n{body}{}\n", control.head, control.tail)
}

fn run(control: &Control, text: &str, trace: &str) -> Done {
    let limits = JobLimits { blocks: 20_000, zero_time_blocks: 5_000, events: 200_000, ..JobLimits::default() };
    let options = JobOptions { limits, trace: trace.to_owned(), ..JobOptions::default() };
    Work::texts(machine(control.machine, control.overlay), &[text], options).run(None).expect("the job can be prepared")
}

fn same_with_and_without(control: &Control, pieces: &[Piece]) {
    let text = program(control, pieces);
    let (kept, traced) = (run(control, &text, ""), run(control, &text, "Z"));
    let told = |done: &Done| -> Vec<Event> {
        let shown = |event: &&Event| !matches!(event.kind, Kind::Trace(_));
        done.events.iter().filter(shown).cloned().collect()
    };
    let (kept_events, traced_events) = (told(&kept), told(&traced));
    for (kept, traced) in kept_events.iter().zip(&traced_events) {
        assert_eq!(kept, traced, "kept, and with a trace\n{text}");
    }
    assert_eq!(kept_events.len(), traced_events.len(), "{text}");
    assert_eq!(kept.summary.diagnostics, traced.summary.diagnostics, "{text}");
}

#[test]
fn every_line_runs() {
    for control in [&FANUC, &SIEMENS, &OKUMA, &HEIDENHAIN] {
        let stopped = |&line: &usize| {
            let done = run(control, &program(control, &[Piece::Loop(vec![Piece::Line(line)])]), "");
            done.summary.diagnostics.iter().any(|told| told.severity >= 8)
        };
        // Each round of the loop would need a MODOUT.
        let closed = |line: &usize| !control.lines[*line].starts_with("MODIN");
        let stopped: Vec<_> =
            (0..control.lines.len()).filter(closed).filter(stopped).map(|line| control.lines[line]).collect();
        assert_eq!(stopped, [""; 0], "{}", control.machine);
    }
}

fn config() -> ProptestConfig {
    ProptestConfig { cases: cases(60), failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn fanuc(pieces in pieces()) {
        same_with_and_without(&FANUC, &pieces);
    }

    #[test]
    fn siemens(pieces in pieces()) {
        same_with_and_without(&SIEMENS, &pieces);
    }

    #[test]
    fn okuma(pieces in pieces()) {
        same_with_and_without(&OKUMA, &pieces);
    }

    #[test]
    fn heidenhain(pieces in pieces()) {
        same_with_and_without(&HEIDENHAIN, &pieces);
    }
}
