//! Random programs for the Heidenhain pre-processor: for any text the run ends within its limits, and neither
//! scheduling nor the lack of a log changes anything.

use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, cases, machine};
use proptest::prelude::*;

fn options(threads: u16) -> JobOptions {
    let limits = JobLimits { blocks: 3_000, zero_time_blocks: 1_000, events: 30_000, ..JobLimits::default() };
    JobOptions { limits, threads, ..JobOptions::default() }
}

/// Formulas.
fn value() -> impl Strategy<Value = String> {
    let leaves =
        ["Q1", "QL2", "QR3", "QS1", "Q108", "Q109", "Q2000", "1", "-2.5", "0", "90", "99999999999", "PI", "\"A\""];
    let leaf = prop::sample::select(leaves.to_vec()).prop_map(str::to_owned);
    leaf.prop_recursive(4, 12, 3, |inner| {
        let operators = [" + ", " - ", " * ", " / ", " % ", " ^ ", " || "];
        let functions =
            ["", "-", "SIN ", "TAN ", "SQRT ", "INT ", "EXP ", "LN ", "ACOS ", "SQ ", "FRAC ", "NEG ", "HALF"];
        prop_oneof![
            (inner.clone(), prop::sample::select(operators.to_vec()), inner.clone())
                .prop_map(|(a, operator, b)| format!("{a}{operator}{b}")),
            (prop::sample::select(functions.to_vec()), inner.clone()).prop_map(|(name, a)| format!("{name}({a})")),
            inner.clone().prop_map(|a| format!("TOCHAR ( DAT{a} DECIMALS3 )")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("SUBSTR ( SRC_{a} BEG{b} LEN2 )")),
        ]
    })
}

/// Blocks, good and bad.
fn block() -> impl Strategy<Value = String> {
    let fixed = [
        "BEGIN PGM A MM",
        "BEGIN PGM A INCH",
        "END PGM A MM",
        "LBL 1",
        "LBL 2",
        "LBL 0",
        "LBL \"A\"",
        "CALL LBL 1",
        "CALL LBL 2 REP 3",
        "CALL LBL \"A\" REP Q1",
        "CALL PGM p1",
        "CALL PGM TNC:\\x.h",
        "FN 9: IF Q1 EQU Q2 GOTO LBL 1",
        "FN 12: IF Q1 LT 3 GOTO LBL 2",
        "FN 1: Q1 = Q1 + 1",
        "FN 18: SYSREAD Q1 = ID270 NR1 IDX1",
        "FN 16: F-PRINT p1.nc / SCREEN:",
        "FN 14: ERROR = 1",
        "D01 Q1 P01 Q1 P02 1",
        "TOOL CALL 5 Z S2000 F300",
        "TOOL CALL \"A\"",
        "TOOL DEF 3 L+10 R+4",
        "CC X+10 Y+10",
        "CC",
        "L X+10 Y+5 R0 F500 M3",
        "L IX+1 IY-2 FMAX",
        "L X1,5 Y,5 FU0,1",
        "L X+3 FZ0.1",
        "; on ~",
        "/ L X+4 ~",
        "CYCL DEF 7.1 IX+1",
        "CYCL DEF 10.1 IROT+5",
        "L X+20 F AUTO",
        "C X+20 Y+10 DR+",
        "CR X+5 Y+5 R-10 DR-",
        "CT X+7 Y-3",
        "LP PR+20 PA+30",
        "CP IPA+800 IZ+3 DR-",
        "CP PA+30",
        "CTP PR+9 PA+200",
        "RND R2 F100",
        "CHF 1",
        "APPR LCT X+3 Y+4 R2 RL",
        "APPR LT X+3 Y+4 LEN5 RR F100",
        "APPR CT X+3 Y+4 CCA180 R+2 RL",
        "DEP LCT X+30 Y+4 R2",
        "DEP CT CCA200 R+2",
        "DEP LN LEN+3",
        "CYCL DEF 200 X ~",
        "  Q200=2 ~",
        "CYCL DEF 12.0 PGM CALL",
        "CYCL DEF 12.1 PGM p1.nc",
        "CYCL DEF 7.0",
        "CYCL DEF 7.1 X+Q1",
        "CYCL CALL",
        "CYCL CALL POS X+1",
        "CYCL CALL POS X+1 Z-2 F100",
        "FL X+30 AN+20",
        "FLT LEN5",
        "FC DR+ R10 CCX+5 CCY+5 CCA400",
        "FCT DR- R3",
        "FCT X+1 Y+2",
        "FL AN+10",
        "FL X+50 Y+50 AN-60 CLSD+",
        "FL CLSD-",
        "FSELECT2",
        "FCT DR+ R24",
        "FL PAR 2 DPQ1 AN+180",
        "FL PDX+50 PDYQ2 D5 LEN9",
        "L X+1 RL M197 DL2",
        "L X+1 M112 T0.01 A10",
        "M142",
        "M114",
        "PLANE SPATIAL SPA-90 SPB+0 SPC+0 TURN FMAX",
        "CYCL DEF 28 X Q1=-5 Q3=0 Q6=2 Q10=Q1 Q11=100 Q12=200 Q16=Q2 Q17=0 Q20=12 Q21=0.01",
        "CYCL DEF 29 X Q1=-5 Q3=0 Q6=2 Q10=2 Q11=100 Q12=200 Q16=25 Q17=1 Q20=Q1",
        "CYCL DEF 39 X Q1=Q2 Q3=0 Q6=2 Q10=2 Q11=100 Q12=200 Q16=25 Q17=1",
        "CYCL DEF 275 X Q215=0 Q219=Q1 Q368=0 Q436=Q2 Q207=500 Q351=1 Q201=-5 Q202=2 Q206=150 Q338=1 Q385=500 Q200=2 Q203=0 Q204=9 Q366=2",
        "CYCL DEF 276 X Q1=-5 Q3=0 Q7=50 Q10=Q2 Q11=100 Q12=200 Q15=0",
        "CYCL DEF 233 X Q215=0 Q389=Q1 Q350=1 Q218=60 Q219=40 Q227=2 Q386=0 Q369=0 Q202=2 Q370=1 Q207=500 Q385=500 Q253=750 Q357=2 Q200=2 Q204=50 Q347=1 Q348=-2 Q349=0 Q220=0 Q368=1 Q338=0 Q367=0",
        "CYCL DEF 225 QS500=\"A%time08\\\\B\" Q513=Q1 Q514=0 Q515=0 Q516=Q2 Q374=0 Q517=20 Q207=500 Q201=-0.3 Q206=150 Q200=2 Q203=0 Q204=50",
        "FPOL X+1 Y+2",
        "FC IX+3 RX 5 CCX+9 CCY+3 DR+",
        "CYCL DEF 8.1 X",
        "CYCL DEF 26.1 X1.5 YQ1",
        "CYCL DEF 247 Q339=2",
        "SEL PATTERN \"p1.nc\"",
        "SEL TABLE \"p1.nc\"",
        "CYCL DEF 7.1 #2",
        "SL READ",
        "CYCL DEF 14.1 CONTOUR LABEL1 /3",
        "CYCL DEF 20 X Q1=-5 Q2=1 Q3=Q1 Q4=0 Q5=0 Q6=2 Q7=50 Q8=0 Q9=1",
        "CYCL DEF 22 X Q10=2 Q11=100 Q12=200 Q18=0 Q19=0",
        "CYCL DEF 25 X Q1=-5 Q3=0 Q5=0 Q7=50 Q10=2 Q11=100 Q12=200 Q15=0",
        "CYCL DEF 251 X Q215=0 Q218=Q1 Q219=30 Q220=0 Q368=0 Q224=0 Q367=0 Q207=500 Q351=1 Q201=-5 Q202=Q2 Q369=0",
        "CYCL DEF 208 X Q200=2 Q201=-10 Q206=150 Q334=Q1 Q203=0 Q204=50 Q335=20 Q342=0",
        "CYCL DEF 220 X Q216=0 Q217=0 Q244=60 Q245=0 Q246=360 Q247=0 Q241=3 Q200=2 Q203=0 Q204=9 Q301=0 Q365=0",
        "PATTERN DEF POS1 (X+1 Y+2 Z+0)",
        "PATTERN DEF ROW1 (X+1 IY+2 D+3 NUM4 ROT+5 Z+0)",
        "CYCL CALL PAT FMAX",
        "TRANS DATUM AXIS IX+5",
        "TRANS DATUM RESET",
        "M140 MB MAX",
        "L X+1 M140 MB 5 F100",
        "FN 17: SYSWRITE ID50 NR2 IDX5 = Q1",
        "D17 ID50 NR4 = +1",
        "FN 18: SYSREAD Q1 = ID50 NR2 IDXQ2",
        "Q200=2 Q201=-3",
        "L X+1 M99",
        "L X+2 M89",
        "STOP M5",
        "%A G71 *",
        "N5 %A G71 *",
        "%p1.nc",
        "G98 L3",
        "G98 L0",
        "L3,2",
        "N10 G01 X+5 *",
        "N10 G02 I+5 J+5 X+10 *",
        "G11 R5 H30",
        "G13 H400",
        "G16 R5 H3",
        "G06 X+3 Y+8",
        "G91",
        "G90 G18",
        "G25 R3",
        "X+3",
        "C+90",
        "/ 5 X+3",
        "/1 Q1 = 3",
        "* - structure",
        "~",
        "M30",
    ];
    prop_oneof![
        8 => prop::sample::select(fixed.to_vec()).prop_map(str::to_owned),
        2 => value().prop_map(|value| format!("Q1 = {value}")),
        1 => value().prop_map(|value| format!("QS1 = {value}")),
        1 => value().prop_map(|value| format!("QL2 = {value}")),
        1 => value().prop_map(|value| format!("FN 38: SEND /\"%5.2F\"/{value}")),
        1 => prop::sample::select(vec!["X", "IY", "F", "S", "PR", "M", "R"]).prop_map(|name| format!("L {name}Q1 Y-QL2")),
        1 => "[A-Z0-9=+*/,.() %;~\"-]{0,16}",
        1 => any::<String>(),
    ]
}

fn program() -> impl Strategy<Value = String> {
    prop::collection::vec(block(), 1..30).prop_map(|blocks| {
        format!(
            "{}\nM30\nLBL 1\nL IX+1\nLBL 0\nLBL 3\nL X+0 Y+0 RL\nL X+40\nL Y+30\nL X+0 Y+0\nLBL 0\n",
            blocks.join("\n")
        )
    })
}

/// Tables of a conversational machine, or those of the family alone.
const CONVERSATIONAL: &str = "
[[registers]]
index = 4
name = \"X\"
second = \"IX\"
whole = 5
frac = 3
signed = true

[[codes]]
id = \"CODE_INTERP_LINEAR\"
text = \"L\"

[[codes]]
id = \"CODE_RAPID\"
text = \"FMAX\"
order = 490
modality = \"non-modal\"

[[codes]]
id = \"CODE_INTERP_DEF_CENTER\"
text = \"CC\"

[[codes]]
id = \"CODE_INTERP_ARC_CENTER\"
text = \"C\"

[[codes]]
id = \"CODE_INTERP_ARC_RADIUS\"
text = \"CR\"

[[codes]]
id = \"CODE_COMP_DIAM_LEFT\"
text = \"RL\"

[[codes]]
id = \"CODE_COMP_DIAM_OFF\"
text = \"R0\"

[[codes]]
id = \"CODE_UNITS_SECONDARY\"
text = \"INCH\"
";

fn numbers(text: &str) -> Vec<u32> {
    let machine = machine("fanuc-mill-exact", "preprocessor = \"heidenhain\"\n");
    let done = Work::texts(machine, &[text], options(1)).run(None).unwrap();
    done.summary.diagnostics.iter().map(|diagnostic| diagnostic.number).collect()
}

#[test]
fn what_has_no_end_comes_to_a_limit() {
    for (text, number) in [
        ("LBL 1\nCALL LBL 1\nLBL 0\n", 2900352),
        ("CALL PGM p1.nc\n", 2900352),
        ("LBL 1\nFN 9: IF 1 EQU 1 GOTO LBL 1\n", 2900070),
        ("Q1 = 0\nLBL 1\nCALL LBL 1 REP 60000\n", 2900070),
        ("CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 PGM p1.nc\nM99\n", 2900352),
    ] {
        let found = numbers(text);
        assert!(found.contains(&number), "{text}: {found:?}");
    }
}

#[test]
fn deep_and_long_blocks_are_told_or_carried_out() {
    let deep = |open: &str| format!("Q1 = {}1\n", open.repeat(1500));
    for text in [deep("("), deep("SIN "), deep("-"), deep("HALF("), format!("Q1 = {}1\n", "1+".repeat(3000))] {
        let found = numbers(&text);
        assert!(found.iter().all(|number| [2900060, 2900016].contains(number)), "{found:?}");
    }
    let found = numbers(&"L X+1 ~\n".repeat(3000));
    assert_eq!(found, [2900321]);
    let found = numbers("Q1 = 10 ^ 400\n");
    assert_eq!(found, [2900062]);
    let found = numbers("Q1 = 1 / 0\n");
    assert_eq!(found, [2900061]);
    let found = numbers("Q5000 = 1\n");
    assert_eq!(found, [2900063]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(150), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_programs_end_in_one_way(text in program(), which in 0..4) {
        let machine = match which {
            0 => machine("fanuc-mill-exact", "preprocessor = \"heidenhain\"\n"),
            1 => machine("fanuc-mill-exact", &format!("preprocessor = \"heidenhain\"\n{CONVERSATIONAL}")),
            2 => machine("heidenhain-mill-exact", "[[tool.offsets]]\nnumber = 5\nradius = 3\n"),
            _ => machine("heidenhain-mill-5axis", "[[tool.offsets]]\nnumber = 5\nradius = 3\n"),
        };
        let work = |threads| Work::texts(machine.clone(), &[&text], options(threads));
        // A job that cannot start has no log.
        if let Ok(one) = work(1).run(None) {
            let many = work(0).run(None).unwrap();
            prop_assert_eq!(&one.events, &many.events);
            let (results, ..) = work(0).results(None).unwrap();
            prop_assert_eq!(one.summary, results.summary);
        }
    }
}

/// Statements that take no axis word, in both languages of the control, and the axes that they do take.
const WITHOUT_AXES: &[(&str, &str)] = &[
    ("CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 1", ""),
    ("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL0.5", ""),
    ("CYCL DEF 13.0 ORIENTATION\nCYCL DEF 13.1 ANGLE 90", ""),
    ("CYCL DEF 19.0 PLANE\nCYCL DEF 19.1", "ABC"),
    ("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05", ""),
    ("TOOL CALL 2 Z S600", ""),
    ("TOOL DEF 5", ""),
    ("STOP", ""),
    ("PLANE RESET STAY", ""),
    ("FUNCTION RESET TCPM", ""),
    ("G04 F1", ""),
    ("G36 S90", ""),
    ("G62 T0.05", ""),
    ("G72 F0.5", ""),
    ("G73 G90 H+30", ""),
    ("G99 T5 L+0 R+5", ""),
];

#[test]
fn statements_without_axes_refuse_axis_words() {
    for (statement, takes) in WITHOUT_AXES {
        let iso = statement.starts_with('G');
        for axis in ["X", "Y", "Z", "A", "C"] {
            let (head, moves, end) = if iso {
                (
                    "%T G71 *\nN10 G00 G40 G90 X+0 Y+0 *\nN20 G01 F500 X+1 *\n",
                    "N40 G01 X+20 Y+10 *\n",
                    "N9999 %T G71 *\n",
                )
            } else {
                ("BEGIN PGM T MM\nL X+0 Y+0 R0 FMAX\nL X+1 F500\n", "L X+20 Y+10\n", "END PGM T MM\n")
            };
            let (number, close) = if iso { ("N30 ", " *") } else { ("", "") };
            let text = format!("{head}{number}{statement} {axis}+5{close}\n{moves}{end}");
            let work = Work::texts(machine("heidenhain-mill-5axis", ""), &[&text], JobOptions::default());
            let done = work.run(None).expect("a job");
            let state = done.summary.state;
            if takes.contains(axis) {
                assert_eq!(state, JobOutcome::Succeeded, "{text}{:?}", done.summary.diagnostics);
                continue;
            }
            assert_eq!(state, JobOutcome::Failed, "{text}");
            let reached: Vec<u32> =
                done.events.iter().filter(|e| matches!(e.kind, Kind::Motion(_))).map(|e| e.line).collect();
            // The block itself moves nothing.
            assert!(
                reached.iter().all(|line| !(4..4 + statement.lines().count() as u32).contains(line)),
                "{text}{reached:?}"
            );
        }
    }
}
