//! Compares the drilling cycles that a control generates itself with the same cycles as NC programs. Both must have the
//! same moves, dwells, spindle commands and alarms. The programs are in `fixtures/siemens-drilling` and
//! `fixtures/heidenhain-drilling`; in the machine of a user they replace the cycles of the control.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_kernel::machine::{Machine, load, package};
use counterpoint_kernel::options::{JobOptions, MoveTiming};
use counterpoint_tests::{Work, machine};

/// Cycles of a control as programs, with the programs that they call: paths in the machine, and texts.
macro_rules! programs {
    ($fixtures:literal, $folder:literal: $($name:literal),*) => {
        &[$((concat!($folder, "/", $name), include_str!(concat!("../fixtures/", $fixtures, "/", $name)))),*]
    };
}

type Programs = &'static [(&'static str, &'static str)];

const SIEMENS: Programs = programs!("siemens-drilling", "siemens-common/resident/cst.dir":
    "cycle81.spf", "cycle82.spf", "cycle83.spf", "cycle84.spf", "cycle840.spf", "cycle85.spf", "cycle86.spf",
    "cycle87.spf", "cycle88.spf", "cycle89.spf", "sc_stroke.spf", "sc_tap.spf", "sc_thread.spf");

const HEIDENHAIN: Programs = programs!("heidenhain-drilling", "heidenhain-milling/cycles":
    "200.h", "201.h", "203.h", "205.h", "206.h", "207.h", "240.h");

/// A machine with the programs as files of the user.
fn with_programs(name: &str, programs: Programs) -> Arc<Machine> {
    let mut own = MemoryFiles::default();
    for (path, text) in programs {
        own.insert(*path, text);
    }
    load(&package::Overlay::over_shipped(own), name).machine.expect("a machine").into()
}

/// State of the job, and numbers of the alarms that a cycle raises.
type End = (JobOutcome, Vec<String>);

/// Runs a program; returns the events that must be the same, and the end. Blocks, calls and returns differ: a generated
/// cycle is one block of the program, not a program of many blocks.
fn run(machine: &Arc<Machine>, text: &str) -> (Vec<(i64, Kind)>, End) {
    // The path stops where it has too many blocks without moves, of which a program has more.
    let options = JobOptions { timing: MoveTiming::SIMPLE, ..JobOptions::default() };
    let done = Work::texts(Arc::clone(machine), &[text], options).run(None).expect("a job");
    let is_kept = |kind: &Kind| {
        !matches!(kind, Kind::Block(_) | Kind::Call(_) | Kind::Return(_) | Kind::Diagnostic(_) | Kind::Verdict(_))
    };
    let events = done.events.into_iter().filter(|event| is_kept(&event.kind)).map(|event| (event.dur_ns, event.kind));
    let alarms = done.summary.diagnostics.iter().filter(|found| found.severity >= 8).map(|found| {
        let number = found.text.find("alarm 6").map(|at| &found.text[at..at + 11]);
        number.unwrap_or(&found.name).to_owned()
    });
    (events.collect(), (done.summary.state, alarms.collect()))
}

/// A random spelling of an argument; an empty spelling omits the argument.
fn one_of(random: &mut fastrand::Rng, spellings: &[&str]) -> String {
    random.choice(spellings).copied().unwrap_or_default().to_owned()
}

/// A number whose digits do not exceed those of `most`, or no text.
fn modes(random: &mut fastrand::Rng, most: &str) -> String {
    if random.bool() {
        return String::new();
    }
    most.bytes().map(|most| char::from(random.u8(b'0'..=most))).collect()
}

/// A call of a cycle with plausible arguments, most of them valid.
fn call(random: &mut fastrand::Rng) -> String {
    const DWELL: &[&str] = &["", "0", "0.5", "-3"];
    let (name, further, most): (&str, Vec<&[&str]>, &str) = match random.u8(0..11) {
        0 => ("CYCLE81", vec![DWELL], "22"),
        1 => ("CYCLE82", vec![DWELL], "22"),
        2 | 3 => (
            "CYCLE83",
            vec![
                &["", "-3", "-1", "-100"],
                &["", "3", "0.7"],
                &["", "0", "1", "0.3", "-0.8"],
                DWELL,
                DWELL,
                &["", "1", "0.5", "80", "-1"],
                &["0", "1", "0", "1", "2"],
                &["", "3"],
                &["", "0.5", "2"],
                &["", "1", "0.4"],
                DWELL,
                &["", "1"],
            ],
            "12222222",
        ),
        4 => (
            "CYCLE84",
            vec![
                DWELL,
                &["3", "5", "6"],
                &["", "8", "-6", "2"],
                &["", "1.25", "-1.5"],
                &["0", "90"],
                &["200", "100"],
                &["", "300"],
                &[""],
                &["", "0", "2", "3"],
                &[""],
                &["0", "1", "2", "3"],
                &["", "2", "5"],
                &["", "1.5"],
                &["\"M\""],
                &[""],
                &[""],
            ],
            "2992992",
        ),
        5 => (
            "CYCLE840",
            vec![
                DWELL,
                &["0", "3", "4"],
                &["3", "4", "5"],
                &["0", "1", "11", "20"],
                &["", "8"],
                &["1.25", "", "0.5"],
                &[""],
                &["", "3"],
                &[""],
                &[""],
                &[""],
                &[""],
            ],
            "2992992",
        ),
        6 => ("CYCLE85", vec![DWELL, &["", "80"], &["", "300"]], "22"),
        7 => ("CYCLE86", vec![DWELL, &["3", "4", "5"], &["0", "-1"], &["0", "0.5"], &["0", "1"], &["0", "45"]], "22"),
        8 => ("CYCLE87", vec![&["3", "4", "5"]], ""),
        9 => ("CYCLE88", vec![DWELL, &["3", "4"]], ""),
        _ => ("CYCLE89", vec![DWELL], ""),
    };
    let levels: [&[&str]; 5] = [
        &["10", "10", "5", "2", "-5"],
        &["0", "0", "0", "1.5", "-2"],
        &["2", "1", "0", "-1"],
        &["-10", "-10", "-33.3333333", "", "12"],
        &["", "", "", "3", "10.123456789012"],
    ];
    let mut arguments: Vec<String> =
        levels.into_iter().chain(further).map(|spellings| one_of(random, spellings)).collect();
    if !most.is_empty() && random.bool() {
        arguments.push(one_of(random, &["", "", "1", "10"]));
        arguments.push(one_of(random, &["", "1", "2", "3", "11", "4"]));
        arguments.push(modes(random, most));
    }
    format!("{name}({})", arguments.join(","))
}

fn program(random: &mut fastrand::Rng) -> String {
    let units = one_of(random, &["G90 G71", "G90 G71", "G91 G71", "G90 G70", "G90 G700"]);
    let plane = one_of(random, &["G17", "G17", "G18", "G19"]);
    let mut text = format!("{units} {plane}\nT1 M6\nD1 S1000 M3 F100\n$TC_DP24[1,1]=118\n$TC_DP6[1,1]=4\n");
    text.push_str("G0 X0 Y0 Z50\n");
    let frame = ["", "", "TRANS X5 Z-3\n", "ROT Z30\n", "SCALE X2 Y2 Z2\n", "MIRROR X0\n", "G55\n", "G95 F0.1\n"];
    text.push_str(&one_of(random, &frame));
    for _ in 0..random.u8(1..4) {
        let call = call(random);
        let _ = match random.u8(0..4) {
            0 => write!(text, "MCALL {call}\nX1 Y0\nG1 X2 F200\nG0 X=R1+3\nMCALL\n"),
            1 => writeln!(text, "{call} P2"),
            _ => writeln!(text, "{call}"),
        };
        text.push_str(&one_of(random, &["X5\n", "G1 X7 Z1\n", "G0 Z20\n", "M5\n", "F50 X1\n"]));
    }
    text.push_str("M30\n");
    text
}

/// A program of a Heidenhain control: a cycle with random parameters, called in several ways.
fn conversational(random: &mut fastrand::Rng) -> String {
    let unit = one_of(random, &["MM", "MM", "MM", "INCH"]);
    let mut text = format!("BEGIN PGM T {unit}\nTOOL CALL 1 Z S1000 F200 DR+2\nL X+0 Y+0 Z+100 R0 FMAX M3\n");
    let before = [
        "",
        "",
        "",
        "M136\n",
        "L X+1 FU0.2\n",
        "M4\n",
        "TRANS DATUM AXIS X+5 Z-3\n",
        "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30\n",
        "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\n",
        "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.5\n",
    ];
    text.push_str(&one_of(random, &before));
    for _ in 0..random.u8(1..4) {
        let cycle = one_of(random, &["200", "201", "203", "203", "205", "205", "206", "207", "240"]);
        let parameters: [(u32, &[&str]); 23] = [
            (200, &["2", "1", "0"]),
            (201, &["-10", "-10", "-33.3333333", "-5", "0", "5"]),
            (202, &["3", "0", "4", "50", "0.7"]),
            (203, &["0", "0", "1.5", "-2"]),
            (204, &["10", "50", "1", "0"]),
            (205, &["0.5", "1", "0"]),
            (206, &["100", "80", "99999"]),
            (208, &["0", "300", "99999"]),
            (210, &["0", "0.5"]),
            (211, &["0", "0.2"]),
            (212, &["0", "0.5", "1"]),
            (213, &["0", "1", "3"]),
            (239, &["1", "-1.5", "1.25"]),
            (253, &["750", "0", "99999"]),
            (256, &["0.2", "1"]),
            (257, &["0", "1.5", "2", "20"]),
            (258, &["0.2", "1"]),
            (259, &["0.2", "2"]),
            (343, &["0", "1"]),
            (344, &["-8", "6"]),
            (379, &["0", "0", "2"]),
            (395, &["0", "0", "1"]),
            (336, &["0"]),
        ];
        let _ = write!(text, "CYCL DEF {cycle}");
        for (number, spellings) in parameters {
            if random.u8(0..60) == 0 {
                continue;
            }
            let _ = write!(text, " Q{number}={}", one_of(random, spellings));
        }
        text.push_str(&one_of(
            random,
            &[
                "\nL X+10 Y+5 R0 FMAX M99\nL X+20 F500 M99\nL Y+9\n",
                "\nCYCL CALL\nL X+3 Y+8 F300\nRND R1\nL X+9 Y+2\n",
                "\nCYCL CALL POS X+5 Y+5 Z+1 FMAX\nL X+7 F100\nCT X+9 Y+9\n",
                "\nL X+1 R0 FMAX M89\nL X+2 Y+2\nL X+3 M99\nL Z+20\n",
                "\nL X+4 Y+4 RL F200\nL X+8\nCYCL CALL\nL X+12 R0\n",
                "\nL X+5 Y+5 RL F100\nL X+20 M99\nL Y+30\nDEP LT LEN10\n",
                "\nL X+5 Y+5 RR F100\nL X+20\nCYCL CALL\nDEP LCT X+50 Y+5 R3\n",
                "\nL X+20 Y+5 R0 F100 M99\nRND R1\nL Y+20\n",
                "\nL X+20 Y+5 R0 F100 M99\nL Y+20\nCHF 1\nL X+1\n",
            ],
        ));
    }
    let _ = write!(text, "L Z+100 R0 FMAX M30\nEND PGM T {unit}\n");
    text
}

/// Compares random programs until at least `counts` of them have succeeded and failed.
fn compare(name: &str, programs: Programs, counts: [u32; 2], program: fn(&mut fastrand::Rng) -> String) {
    let (own, as_programs) = (machine(name, ""), with_programs(name, programs));
    let (mut ends, mut seed) = ([0; 2], 0);
    while ends[0] < counts[0] || ends[1] < counts[1] {
        seed += 1;
        let text = program(&mut fastrand::Rng::with_seed(seed));
        let ((events, end), (expected, expected_end)) = (run(&own, &text), run(&as_programs, &text));
        assert_eq!(end, expected_end, "seed {seed}\n{text}");
        // A generated cycle checks its arguments before the first move; a program checks some arguments after it.
        let succeeded = end.0 == JobOutcome::Succeeded;
        if succeeded {
            for (event, expected) in events.iter().zip(&expected) {
                assert_eq!(event, expected, "seed {seed}\n{text}");
            }
            assert_eq!(events.len(), expected.len(), "seed {seed}\n{text}");
        }
        ends[usize::from(!succeeded)] += 1;
        // Neither the random arguments nor the checks may make nearly all programs end the same way.
        assert!(seed < 800, "{ends:?} of {seed}");
    }
}

#[test]
fn a_hole_of_sinumerik_has_the_moves_that_its_cycle_makes_as_a_program() {
    compare("siemens-mill", SIEMENS, [40, 40], program);
}

#[test]
fn a_hole_of_heidenhain_has_the_moves_that_its_cycle_makes_as_a_program() {
    compare("heidenhain-mill", HEIDENHAIN, [80, 10], conversational);
}

#[test]
fn an_alarm_of_a_cycle_names_the_cycle_and_the_block_that_calls() {
    let text = "G0 Z50\nT1 D1 M6\nS1000 M3 F200\nMCALL CYCLE81(10,0,2)\nX5\nM30";
    let work = Work::texts(machine("siemens-mill", ""), &[text], JobOptions::default());
    let (results, ..) = work.results(None).expect("a job");
    let found = results.summary.diagnostics.iter().find(|found| found.text.contains("61101")).expect("the alarm");
    assert_eq!((found.line, found.block.as_str()), (5, "X5"), "{found:?}");
    assert!(found.text.contains("CYCLE81") && found.origin.is_none(), "{found:?}");
}

/// Diagnostics by name, with the state of the job.
fn diagnostics(name: &str, text: &str) -> (JobOutcome, Vec<(String, u32, String)>) {
    let (results, ..) = Work::texts(machine(name, ""), &[text], JobOptions::default()).results(None).expect("a job");
    let found = results.summary.diagnostics.iter();
    (results.summary.state, found.map(|found| (found.name.clone(), found.line, found.text.clone())).collect())
}

#[test]
fn a_parameter_of_a_hole_without_a_value_is_a_warning_that_names_it() {
    let text = "BEGIN PGM T MM\nTOOL CALL 1 Z S1000 F200\nL Z+50 R0 FMAX M3\nCYCL DEF 200 Q200=2 Q201=-5\nL X1 FMAX M99\n\
                L Z+100 R0 FMAX M30\nEND PGM T MM\n";
    let (_, found) = diagnostics("heidenhain-mill", text);
    for parameter in ["Q202", "Q203", "Q204", "Q206", "Q211"] {
        let is = |(name, line, text): &(String, u32, String)| {
            name == "parameter-not-set" && *line == 5 && text.starts_with(&format!("{parameter} "))
        };
        assert!(found.iter().any(is), "{parameter}: {found:?}");
    }
}

#[test]
fn the_file_of_a_cycle_called_as_a_program_makes_the_hole() {
    let text = "BEGIN PGM T MM\nTOOL CALL 1 Z S1000 F200\nL X+1 Y+1 Z+50 R0 FMAX M3\nCYCL DEF 201 Q200=2 Q201=-5 Q206=100 \
                Q208=0 Q211=0 Q203=0 Q204=10\nCALL PGM 201.H\nL Z+100 R0 FMAX M30\nEND PGM T MM\n";
    let (events, end) = run(&machine("heidenhain-mill", ""), text);
    let (expected, expected_end) = run(&with_programs("heidenhain-mill", HEIDENHAIN), text);
    assert_eq!((end, events), (expected_end, expected));
}

#[test]
fn a_way_off_the_wall_along_an_axis_that_the_lathe_does_not_have_is_an_alarm() {
    let text = |aside: &str| {
        format!("G90 G17\nT1 D1\nG95 S1000 M3 F0.1\nG0 X0 Z50\nCYCLE86(10,0,2,-10,,,3,0,{aside},0,0)\nG0 Z60\nM30")
    };
    let (state, found) = diagnostics("siemens-lathe", &text("1"));
    assert!(
        state == JobOutcome::Failed && found.iter().any(|(_, line, text)| *line == 5 && text.contains("12550")),
        "{found:?}"
    );
    let (state, found) = diagnostics("siemens-lathe", &text("0"));
    assert_eq!(state, JobOutcome::Succeeded, "{found:?}");
}

#[test]
fn a_corner_before_a_hole_never_moves_the_hole() {
    for cycle in ["CYCLE81(10,0,2,-20)", "CYCLE83(10,0,2,-20,,-5,,1,,,,1)", "CYCLE85(10,0,2,-20)"] {
        let text = format!("G90 G17\nT1 D1 M6\nS1000 M3 F100\nG0 X0 Y0 Z20\nG1 X10 Y0 Z20 RND=2\n{cycle}\nG1 Y20\nM30");
        let (state, found) = diagnostics("siemens-mill", &text);
        assert_eq!(state, JobOutcome::Failed, "{cycle}: {found:?}");
        let modal = text.replace("RND=", "RNDM=");
        let (events, (state, _)) = run(&machine("siemens-mill", ""), &modal);
        assert_eq!(state, JobOutcome::Succeeded, "{cycle}");
        let to_the_bottom = |kind: &Kind| match kind {
            Kind::Motion(motion) if motion.to[2] <= -20.0 && motion.from[2] > motion.to[2] => {
                Some((motion.to[0], motion.to[1]))
            }
            _ => None,
        };
        let bottoms: Vec<(f64, f64)> = events.iter().filter_map(|(_, kind)| to_the_bottom(kind)).collect();
        assert!(!bottoms.is_empty() && bottoms.iter().all(|at| *at == (10.0, 0.0)), "{cycle}: {bottoms:?}");
    }
}

#[test]
fn a_dwell_in_revolutions_behind_g63_dwells() {
    let text = "G90 G17\nT1 D1 M6\nS1000 M3 F100\nG0 Z50\nG63 Z40\nG4 S3\nM30";
    let done = Work::texts(machine("siemens-mill", ""), &[text], JobOptions::default()).run(None).expect("a job");
    let dwells: Vec<_> = done.events.iter().filter(|event| matches!(event.kind, Kind::Dwell(_))).collect();
    assert_eq!(dwells.iter().map(|event| event.dur_ns).collect::<Vec<_>>(), [180_000_000], "{:?}", done.summary);
}

/// A trace shows each block of a cycle, so all words are sorted. Without a trace, known moves are not sorted.
#[test]
fn the_moves_of_a_hole_are_the_same_with_and_without_a_trace() {
    let mut random = fastrand::Rng::with_seed(83);
    for _ in 0..120 {
        for (name, text) in [("siemens-mill", program(&mut random)), ("heidenhain-mill", conversational(&mut random))] {
            let events = |trace: &str| {
                let options = JobOptions { trace: trace.to_owned(), ..JobOptions::default() };
                let done = Work::texts(machine(name, ""), &[text.as_str()], options).run(None).expect("a job");
                let events = done.events.into_iter().filter(|event| !matches!(event.kind, Kind::Trace(_)));
                let events = events.map(|event| (event.t_ns, event.dur_ns, event.line, event.kind)).collect::<Vec<_>>();
                (done.summary.state, events)
            };
            assert_eq!(events(""), events("C"), "{text}");
        }
    }
}
