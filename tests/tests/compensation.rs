//! Compensation of the cutter radius and local frames under any program: the log keeps its order, the tool's path has
//! no gap, and scheduling changes nothing.

use counterpoint_kernel::log::event::{Event, Kind};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Done, Work, cases, machine};
use proptest::prelude::*;

const OFFSETS: &str = "
[[tool.offsets]]
number = 1
radius = 2
tip = 3

[[tool.offsets]]
number = 2
radius = 0.5
tip = 9
";

fn options(threads: u16) -> JobOptions {
    let limits = JobLimits { blocks: 20_000, zero_time_blocks: 5_000, events: 200_000, ..JobLimits::default() };
    JobOptions { limits, threads, ..JobOptions::default() }
}

fn blocks(mill: bool) -> impl Strategy<Value = String> {
    let [first, second] = if mill { ["X", "Y"] } else { ["Z", "X"] };
    let [i, j] = if mill { ["I", "J"] } else { ["K", "I"] };
    let number = -12_i32..12;
    let straight =
        (0..2_u8, number.clone(), number.clone()).prop_map(move |(g, x, y)| format!("G{g} {first}{x}. {second}{y}."));
    let one = (number.clone(), any::<bool>())
        .prop_map(move |(x, along)| format!("{}{x}.", if along { first } else { second }));
    let arc = (2..4_u8, number.clone(), number.clone(), number.clone(), number.clone())
        .prop_map(move |(g, x, y, a, b)| format!("G{g} {first}{x}. {second}{y}. {i}{a}. {j}{b}."));
    let radius = (2..4_u8, number.clone(), number.clone(), 1..15_u8)
        .prop_map(move |(g, x, y, r)| format!("G{g} {first}{x}. {second}{y}. R{r}."));
    let words = if mill {
        vec![
            "G41 D1",
            "G42 D1",
            "G41 D2",
            "G42 D2",
            "G40",
            "G1 G41 D1 X5. Y5.",
            "G40 G1 X0 Y0",
            "Z1.",
            "Z-3.",
            "M8",
            "M3 S100",
            "G4 P100",
            "G52 X3. Y2.",
            "G52 X0 Y0",
            "G68 X0 Y0 R30.",
            "G69",
            "G51 X1. Y1. P2000",
            "G50",
            "G51.1 X2.",
            "G50.1",
            "G91",
            "G90",
            "G54",
            "G55",
            "G28 X0",
            "G53 X1.",
            "G92 X3.",
            "G81 Z-1. R1.",
            "G80",
            "G93 F2",
            "G94 F500",
            "#500=#500+1",
            "G18",
            "G17",
            "G20",
            "G21",
            "M98 P77",
            "T2 M6",
            "G43 H1",
            "G49",
        ]
    } else {
        vec![
            "G41",
            "G42",
            "G40",
            "T101",
            "T202",
            "T100",
            "M8",
            "M3 S100",
            "G4 P100",
            "#500=#500+1",
            "#1=#500",
            "M100",
            "G52 X3. Z2.",
            "G52 X0 Z0",
            "G68.1 X0 Z0 R30.",
            "G69.1",
            "G28 U0",
            "G50 X3.",
            "G96 S50",
            "G97 S500",
            "G98 F500",
            "G99 F0.2",
            "G54",
            "G55",
            "G32 Z3. F1.",
            "M98 P77",
        ]
    };
    let word = prop::sample::select(words).prop_map(str::to_owned);
    prop_oneof![4 => straight, 3 => one, 1 => arc, 1 => radius, 3 => word]
}

fn program(mill: bool) -> impl Strategy<Value = String> {
    let head = if mill { "G90 G17 G94 F500\nG1 G41 D1 X1. Y1." } else { "G98 F500\nT101\nG42 G1 X5. Z5." };
    prop::collection::vec(blocks(mill), 0..40)
        .prop_map(move |lines| format!("O1\n{head}\n{}\nM30\nO77\nM9\nM99\n", lines.join("\n")))
}

/// Blocks of a Siemens mill: soft approach and retraction, the way around the ends of a contour, allowances.
fn soft_blocks() -> impl Strategy<Value = String> {
    let number = -12_i32..12;
    let straight = (0..2_u8, number.clone(), number.clone()).prop_map(|(g, x, y)| format!("G{g} X{x} Y{y}"));
    let arc = (2..4_u8, number.clone(), number.clone(), number.clone(), number.clone())
        .prop_map(|(g, x, y, a, b)| format!("G{g} X{x} Y{y} I{a} J{b}"));
    let ways = prop::sample::select(vec!["G147", "G247", "G347", "G148", "G248", "G348"]);
    let words = prop::sample::select(vec!["G41", "G42", "G40", "G140", "G141", "G142", "G143", "G340", "G341", ""]);
    let place = prop::sample::select(vec!["X5 Y5 Z0", "X-3 Y8", "Z-2", "Z20", "", "X9", "X0 Y0 Z3"]);
    let level =
        prop::sample::select(vec!["", "DISCL=1", "DISCL=AC(2)", "DISCL=0", "DISRP=4", "FAD=100", "FAD=PR(0.1)"]);
    let soft = (ways, words, place, level, 0..9_u8)
        .prop_map(|(way, word, place, level, size)| format!("{way} {word} {place} {level} DISR={size} F300"));
    let other = prop::sample::select(vec![
        "G41",
        "G42",
        "G40",
        "KONT",
        "NORM",
        "G450",
        "G451",
        "OFFN=1",
        "OFFN=0",
        "OFFN=-1 X4",
        "Z1",
        "M8",
        "G4 F0.1",
        "CUT2DF",
        "CUT2D",
        "G18",
        "G17",
        "X5 RND=1",
        "D2",
        "D1",
        "G91",
        "G90",
        "G95",
        "G94",
        "S100 M3",
        "ROT RPL=30",
    ])
    .prop_map(str::to_owned);
    prop_oneof![4 => straight, 1 => arc, 3 => soft, 2 => other]
}

/// Lines do not go back except for calls, times never do, and every move begins where the one before has ended.
fn check(done: &Done, text: &str) {
    let channels: std::collections::BTreeSet<u16> = done.events.iter().map(|event| event.channel).collect();
    for channel in channels.into_iter().filter(|channel| *channel > 0) {
        let (mut line, mut end, mut at) = (0, 0, None);
        for event in done.events.iter().filter(|event| event.channel == channel) {
            let Event { t_ns, dur_ns, .. } = *event;
            assert!(t_ns >= end, "time goes back at line {} of\n{text}", event.line);
            end = end.max(t_ns);
            match &event.kind {
                Kind::Call(_) | Kind::Return(_) => {
                    line = 0;
                    continue;
                }
                Kind::Verdict(_) => continue,
                _ => {}
            }
            assert!(event.line >= line || event.line == 0, "line {} after {line} in\n{text}", event.line);
            line = event.line.max(line);
            match &event.kind {
                Kind::Motion(motion) => {
                    assert!(
                        motion.to.iter().chain(&motion.center).all(|value| value.is_finite()),
                        "{motion:?} in\n{text}"
                    );
                    if let Some(at) = at {
                        assert_eq!(at, motion.from, "a gap at line {} of\n{text}", event.line);
                    }
                    at = Some(motion.to);
                    end = t_ns + dur_ns;
                }
                Kind::Frame(_) => at = None,
                _ => {}
            }
        }
    }
}

fn run(name: &str, texts: &[String]) {
    let machine = machine(name, OFFSETS);
    let one = Work::texts(machine.clone(), texts, options(1)).run(None).expect("the job can be prepared");
    check(&one, &texts.join("\n--\n"));
    let many = Work::texts(machine.clone(), texts, options(0)).run(None).expect("the job can be prepared");
    assert_eq!(one.events, many.events, "scheduling counts in\n{}", texts.join("\n--\n"));
    let (results, ..) = Work::texts(machine, texts, options(0)).results(None).expect("the job can be prepared");
    assert_eq!(one.summary, results.summary);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(300), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_program_of_a_mill(text in program(true)) {
        run("fanuc-mill-exact", &[text]);
    }

    #[test]
    fn any_soft_approach(lines in prop::collection::vec(soft_blocks(), 0..30)) {
        let head = "$TC_DP6[1,1]=2\n$TC_DP6[1,2]=0.5\nT1 M6\nG17 G90 G94 F500 G0 X0 Y0 Z10";
        let text = format!("{head}\n{}\nM30\n", lines.join("\n"));
        let machine = machine("siemens-mill-exact", "\n[control]\nstops = false\n\n[[diagnostics]]\nnumber = 2900414\nseverity = 4\n");
        let of = |threads| Work::texts(machine.clone(), std::slice::from_ref(&text), options(threads)).run(None).expect("a job");
        let one = of(1);
        check(&one, &text);
        prop_assert_eq!(one.events, of(0).events);
    }

    #[test]
    fn any_programs_of_a_lathe(upper in program(false), lower in program(false)) {
        run("fanuc-2path-lathe-exact", &[upper, lower]);
    }
}
