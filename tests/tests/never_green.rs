//! A job with a channel that did not come to its end, or that went on after an alarm, never counts as succeeded: every way
//! to end × every way to soften what is said about it.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::files::Memory;
use counterpoint_kernel::job::Program;
use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::log::summary::{ChannelState, State, Summary};
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::{Limits, Options};
use counterpoint_tests::{Work, processors};

/// A way to come to an end: its name, machine rows, the startup macro's statements, program, numbers it raises.
struct End {
    name: &'static str,
    machine: &'static str,
    program: &'static str,
    limits: fn(&mut Limits),
    numbers: &'static [u32],
}

const NOTHING: fn(&mut Limits) = |_| {};

const ENDS: &[End] = &[
    End { name: "unknown G", machine: "", program: "G0 X1.\nG199 X5.\nM30\n", limits: NOTHING, numbers: &[2_900_320] },
    End { name: "unknown M", machine: "", program: "M777\nM30\n", limits: NOTHING, numbers: &[2_900_320] },
    End { name: "unknown text", machine: "", program: "POCKET(1)\nM30\n", limits: NOTHING, numbers: &[2_900_321] },
    End { name: "missing program", machine: "", program: "M98 P77\nM30\n", limits: NOTHING, numbers: &[2_900_040] },
    End { name: "missing macro", machine: "", program: "G65 P77\nM30\n", limits: NOTHING, numbers: &[2_900_040] },
    End { name: "jump target", machine: "", program: "GOTO 9\nM30\n", limits: NOTHING, numbers: &[2_900_042] },
    End { name: "division", machine: "", program: "#1=1/0\nM30\n", limits: NOTHING, numbers: &[2_900_061] },
    End { name: "domain", machine: "", program: "#1=SQRT[-1]\nM30\n", limits: NOTHING, numbers: &[2_900_062] },
    End { name: "variable", machine: "", program: "#1=#77777\nM30\n", limits: NOTHING, numbers: &[2_900_063] },
    End { name: "syntax", machine: "", program: "#1=[1\nM30\n", limits: NOTHING, numbers: &[2_900_060] },
    End { name: "loop", machine: "", program: "END1\nM30\n", limits: NOTHING, numbers: &[2_900_064] },
    End { name: "#3000", machine: "", program: "#3000=1(STOP)\nM30\n", limits: NOTHING, numbers: &[2_900_065] },
    End { name: "call without P", machine: "", program: "G65 A1.\nM30\n", limits: NOTHING, numbers: &[2_900_066] },
    End {
        name: "nesting",
        machine: "",
        program: "O1\nM98 P2\nM30\nO2\nM98 P2\nM99\n",
        limits: |limits| limits.nesting = 3,
        numbers: &[2_900_041],
    },
    End {
        name: "alarm in a subprogram",
        machine: "",
        program: "O1\nM98 P2\nM30\nO2\n#1=1/0\nM99\n",
        limits: NOTHING,
        numbers: &[2_900_061],
    },
    End {
        name: "long block",
        machine: "",
        program: "G0 X1. (0123456789)\nM30\n",
        limits: |limits| limits.block_length = 10,
        numbers: &[2_900_014],
    },
    End {
        name: "limit of blocks",
        machine: "",
        program: "N1 G4 P1\nGOTO 1\nM30\n",
        limits: |limits| limits.blocks = 20,
        numbers: &[2_900_070],
    },
    End {
        name: "limit of diagnostics",
        machine: "",
        program: "?A\nM30\n",
        limits: |limits| limits.diagnostics = 0,
        numbers: &[2_900_321],
    },
    End {
        name: "macro that loops",
        machine: "motion = \"loop.mac\"\n",
        program: "G0 X1.\nM30\n",
        limits: NOTHING,
        numbers: &[2_910_055],
    },
    End {
        name: "alarm in a subprogram macro",
        machine: "subprogram_startup = \"jump.mac\"\n",
        program: "O1\nM98 P2\nM30\nO2\nM99\n",
        limits: NOTHING,
        numbers: &[2_900_042],
    },
    End {
        name: "alarm in startup",
        machine: "program_startup = \"jump.mac\"\n",
        program: "G0 X1.\nM30\n",
        limits: NOTHING,
        numbers: &[2_900_042],
    },
    End {
        name: "alarm in shutdown",
        machine: "program_shutdown = \"jump.mac\"\n",
        program: "G0 X1.\nM30\n",
        limits: NOTHING,
        numbers: &[2_900_042],
    },
];

/// How what is said is made softer. The first one says it as it is.
const SOFTENED: &[&str] = &["as it is", "row", "floor", "$FERSEV", "$FERSTA", "$ERRMSG", "$P1=0"];

fn machine(end: &End, soft: &str, stops: bool) -> Arc<Machine> {
    let mut files = Memory::default();
    let mut text = "extends = \"fanuc-mill\"\n".to_owned();
    if soft == "floor" {
        text.push_str("min_severity = 99\n");
    }
    let _ = write!(text, "\n[ce]\nname = \"soft\"\n\n[control]\nstops = {stops}\n\n[macros]\n{}", end.machine);
    let mut declared = String::new();
    for number in end.numbers {
        match soft {
            "$FERSEV" => writeln!(declared, "%G01=$FERSEV({number},4)"),
            "$FERSTA" => writeln!(declared, "%G01=$FERSTA({number},.FALSE.)"),
            _ => Ok(()),
        }
        .expect("text");
    }
    if soft == "$ERRMSG" {
        declared.push_str("$ERRMSG=.FALSE.\n");
    }
    if soft == "$P1=0" {
        text.push_str("diagnostic = \"drop.mac\"\n");
    }
    if end.machine.contains("program_startup") {
        declared.push_str("EXEC/NOW,'GOTO 9'\n");
        files.insert("soft/jump.mac", &declared);
    } else {
        text.push_str("program_startup = \"start.mac\"\n");
        files.insert("soft/start.mac", if declared.is_empty() { "%G01=1\n" } else { &declared });
        files.insert("soft/jump.mac", "EXEC/NOW,'GOTO 9'\n");
    }
    if soft == "row" {
        for number in end.numbers.iter().filter(|number| **number < 2_910_000) {
            let _ = write!(text, "\n[[diagnostics]]\nnumber = {number}\nseverity = 1\n");
        }
    }
    files.insert("soft/machine.toml", text);
    files.insert("soft/drop.mac", "$P1=0\n");
    files.insert("soft/loop.mac", "WHILE/.TRUE.\n%L01=%L01+1\nENDOF/WHILE\n");
    let loaded = load(&Overlay::new(files, shipped()), "soft");
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("{}, {soft}: {findings:#?}", end.name))
}

fn run(end: &End, soft: &str, stops: bool) -> Summary {
    let mut options = Options::default();
    (end.limits)(&mut options.limits);
    let work = Work::texts(machine(end, soft, stops), &[end.program], options);
    let done = work.run(None).expect("the job can be prepared");
    let (results, ..) = work.results(None).expect("the job can be prepared");
    assert_eq!(done.summary, results.summary, "{} {soft}: results without a log differ", end.name);
    done.summary
}

#[test]
fn no_way_to_end_and_no_way_to_soften_it_makes_a_job_succeed() {
    let mut wrong = String::new();
    for end in ENDS {
        for soft in SOFTENED {
            for stops in [true, false] {
                let summary = run(end, soft, stops);
                let told = summary.verdict.is_some() || summary.diagnostics.iter().any(|d| d.severity >= 8);
                if summary.state != State::Failed || !told {
                    let (state, diagnostics) = (summary.state, &summary.diagnostics);
                    let _ = writeln!(wrong, "{}, {soft}, stops = {stops}: {state:?} {diagnostics:#?}", end.name);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn a_family_stops_and_a_control_that_goes_on_comes_to_its_end() {
    for end in ENDS.iter().filter(|end| !end.name.starts_with("limit of b") && !end.name.starts_with("macro that")) {
        let stopped = run(end, "as it is", true).channels[0].state;
        let went_on = run(end, "as it is", false).channels[0].state;
        assert_eq!((stopped, went_on), (ChannelState::Alarmed, ChannelState::Ended), "{}", end.name);
    }
}

#[test]
fn a_job_without_its_program_does_not_start() {
    let end = &ENDS[3];
    for soft in SOFTENED {
        let mut work = Work::texts(machine(end, soft, true), &["G0 X1.\nM30\n"], Options::default());
        work.programs = vec![Program { file: "p2.nc".to_owned(), number: None, channel: None }];
        assert!(work.run(None).is_err(), "{soft}");
    }
}

/// Program Shutdown runs after the alarm of a control that stops, as it does after an end.
#[test]
fn program_shutdown_runs_after_an_alarm() {
    let mut files = Memory::default();
    files.insert(
        "soft/machine.toml",
        "extends = \"fanuc-mill\"\n\n[ce]\nname = \"soft\"\n\n[macros]\nprogram_shutdown = \"end.mac\"\n",
    );
    files.insert("soft/end.mac", "PPRINT/'over'\n");
    let loaded = load(&Overlay::new(files, shipped()), "soft");
    let machine = loaded.machine.map(Arc::new).expect("a machine");
    let done = Work::texts(machine, &["G0 X1.\nG199 X2.\nM30\n"], Options::default()).run(None).expect("a job");
    assert_eq!(done.summary.channels[0].state, ChannelState::Alarmed);
    let messages =
        done.events.iter().filter(|event| matches!(&event.kind, Kind::Message { text, .. } if &**text == "over"));
    assert_eq!(messages.count(), 1);
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS[1..2], "everywhere", &[]);
}
