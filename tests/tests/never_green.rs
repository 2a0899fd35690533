//! A job with a channel that did not reach its end, or that continued after an alarm, never counts as succeeded: every
//! way to end × every way to soften the reports about it.

use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::{Bytes, FileError, JobFiles, MemoryFiles};
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, Spec};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::{Event, Kind, OperatorMessage};
use counterpoint_kernel::log::summary::{ChannelState, JobOutcome, Summary};
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, processors};

/// A path to end: its name, machine rows, the startup macro's statements, program, numbers it raises.
struct End {
    name: &'static str,
    machine: &'static str,
    program: &'static str,
    limits: fn(&mut JobLimits),
    numbers: &'static [u32],
}

const NOTHING: fn(&mut JobLimits) = |_| {};

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
        name: "limit of time",
        machine: "",
        program: "G4 X100.\nG4 X100.\nM30\n",
        limits: |limits| limits.simulated_ns = 1_000_000_000,
        numbers: &[2_900_070],
    },
    End {
        name: "limit of blocks without time",
        machine: "",
        program: "N1 G0 X0\n#1=#1+1\nGOTO 1\nM30\n",
        limits: |limits| limits.zero_time_blocks = 20,
        numbers: &[2_900_070],
    },
    End {
        name: "limit of events",
        machine: "",
        program: "N1 G0 X1.\nX2.\nGOTO 1\nM30\n",
        limits: |limits| limits.events = 50,
        numbers: &[2_900_070],
    },
    End {
        name: "limit of macro steps",
        machine: "motion = \"step.mac\"\n",
        program: "N1 G0 X1.\nX2.\nGOTO 1\nM30\n",
        limits: |limits| limits.macro_steps = 2_000,
        numbers: &[2_900_070],
    },
    End {
        name: "limit of memory",
        machine: "motion = \"grow.mac\"\n",
        program: "%\nN1 G0 X1.\nX2.\nGOTO 1\nM30\n",
        limits: |limits| limits.memory = 200_000,
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

/// Ways to soften the reports. The first one leaves them unchanged.
const SOFTENED: &[&str] = &["as it is", "row", "floor", "$FERSEV", "$FERSTA", "$ERRMSG", "$P1=0"];

fn machine(end: &End, soft: &str, stops: bool) -> Arc<Machine> {
    let mut files = MemoryFiles::default();
    let mut text = "extends = \"fanuc-mill-exact\"\n".to_owned();
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
    files.insert("soft/step.mac", "%L01=0\nWHILE/%L01<50\n%L01=%L01+1\nENDOF/WHILE\nOUTPUT\n");
    files.insert("soft/grow.mac", "%G02=%G02//'0123456789012345678901234567890123456789'\nOUTPUT\n");
    files.insert("soft/loop.mac", "WHILE/.TRUE.\n%L01=%L01+1\nENDOF/WHILE\n");
    let loaded = load(&Overlay::new(files, counterpoint_tests::library()), "soft");
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("{}, {soft}: {findings:#?}", end.name))
}

fn run(end: &End, soft: &str, stops: bool) -> Summary {
    let mut options = JobOptions::default();
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
                if summary.state != JobOutcome::Failed || !told {
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
    for end in ENDS.iter().filter(|end| {
        !(end.name.starts_with("macro that") || end.name.starts_with("limit of") && end.numbers == [2_900_070])
    }) {
        let stopped = run(end, "as it is", true).channels[0].state;
        let went_on = run(end, "as it is", false).channels[0].state;
        assert_eq!((stopped, went_on), (ChannelState::Alarmed, ChannelState::Ended), "{}", end.name);
    }
}

#[test]
fn a_job_without_its_program_does_not_start() {
    let end = &ENDS[3];
    for soft in SOFTENED {
        let mut work = Work::texts(machine(end, soft, true), &["G0 X1.\nM30\n"], JobOptions::default());
        work.programs = vec![ProgramSelection { file: "p2.nc".to_owned(), number: None, section: None, channel: None }];
        assert!(work.run(None).is_err(), "{soft}");
    }
}

/// Program Shutdown runs after the alarm of a control that stops, as it does after an end.
#[test]
fn program_shutdown_runs_after_an_alarm() {
    let mut files = MemoryFiles::default();
    files.insert(
        "soft/machine.toml",
        "extends = \"fanuc-mill-exact\"\n\n[ce]\nname = \"soft\"\n\n[macros]\nprogram_shutdown = \"end.mac\"\n",
    );
    files.insert("soft/end.mac", "PPRINT/'over'\n");
    let loaded = load(&Overlay::new(files, counterpoint_tests::library()), "soft");
    let machine = loaded.machine.map(Arc::new).expect("a machine");
    let done = Work::texts(machine, &["G0 X1.\nG199 X2.\nM30\n"], JobOptions::default()).run(None).expect("a job");
    assert_eq!(done.summary.channels[0].state, ChannelState::Alarmed);
    let messages = done
        .events
        .iter()
        .filter(|event| matches!(&event.kind, Kind::Message(OperatorMessage { text, .. }) if &**text == "over"));
    assert_eq!(messages.count(), 1);
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS[1..2], "everywhere", &[]);
}

/// Keeps nothing; asks the job to end at its first events.
struct Cancels<'a>(&'a JobControl, ResultsBuilder);

impl LogSink for Cancels<'_> {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.1)
    }

    fn events(&mut self, _: u64, _: &[Event]) -> bool {
        self.0.cancel();
        true
    }
}

#[test]
fn a_cancelled_job_does_not_succeed() {
    let program = "O1\nN1 G4 P1\nGOTO 1\nM30\n";
    for (name, threads) in [("fanuc-mill", 1), ("fanuc-2path-lathe", 1), ("fanuc-2path-lathe", 2)] {
        let machine = counterpoint_tests::machine(name, "");
        let texts: Vec<&str> = machine.channels.iter().map(|_| program).collect();
        let work = Work::texts(machine, &texts, JobOptions { threads, ..JobOptions::default() });
        let spec =
            Spec { machine: work.machine.clone(), programs: work.programs.clone(), options: work.options.clone() };
        let job = Job::prepare(spec, &work.files).expect("a job");
        let control = JobControl::new(work.machine.channels.len());
        let mut sink = Cancels(&control, ResultsBuilder::new(job.info()));
        let outcome = job.run(&work.files, &control, &mut sink);
        let summary = sink.1.finish(&outcome).summary;
        assert_ne!(summary.state, JobOutcome::Succeeded, "{name}, {threads} threads");
        assert!(summary.channels.iter().all(|channel| channel.state != ChannelState::Ended), "{summary:?}");
    }
}

/// A fault of a kernel itself: the caller of the job sees it, and it is never a result.
#[test]
fn a_kernel_that_panics_leaves_no_result() {
    fn fails(channel: u16) {
        if channel == 2 {
            std::panic::panic_any("a fault of the kernel");
        }
    }
    for threads in [1, 2] {
        let machine = counterpoint_tests::machine("fanuc-2path-lathe-exact", "");
        let texts = ["O1\nM101\nG4 P100\nM30\n", "O2\nM101\nM30\n"];
        let work = Work::texts(machine, &texts, JobOptions { threads, ..JobOptions::default() });
        let run = std::panic::AssertUnwindSafe(|| work.run(Some(fails)));
        assert!(std::panic::catch_unwind(run).is_err(), "{threads} threads");
    }
}

/// Files of which only the first few can be read.
struct Failing {
    files: MemoryFiles,
    left: AtomicUsize,
}

impl JobFiles for Failing {
    fn read(&self, path: &str) -> Result<Bytes, FileError> {
        let left = |left: usize| left.checked_sub(1);
        match self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, left) {
            Ok(_) => self.files.read(path),
            Err(_) => Err(FileError::Unreadable { name: path.to_owned(), reason: "the disk is gone".to_owned() }),
        }
    }

    fn list(&self) -> Vec<String> {
        self.files.list()
    }
}

#[test]
fn a_job_whose_files_become_unreadable_does_not_succeed() {
    let mut files = MemoryFiles::default();
    files.insert("p1.nc", "O1\nM98 P2\nM98 P3\nM30\n");
    files.insert("O0002.nc", "O2\nG0 X1.\nM99\n");
    files.insert("O0003.nc", "O3\nG0 X2.\nM99\n");
    let mut states = Vec::new();
    for left in 0..12 {
        let failing = Failing { files: files.clone(), left: AtomicUsize::new(left) };
        let programs = vec![ProgramSelection { file: "p1.nc".to_owned(), number: None, section: None, channel: None }];
        let machine = counterpoint_tests::machine("fanuc-mill-exact", "");
        let Ok(job) = Job::prepare(Spec { machine, programs, options: JobOptions::default() }, &failing) else {
            continue;
        };
        let control = JobControl::new(1);
        let mut sink = Keeps(ResultsBuilder::new(job.info()));
        let outcome = job.run(&failing, &control, &mut sink);
        let summary = sink.0.finish(&outcome).summary;
        let moves = summary.channels[0].blocks;
        let all = failing.left.load(Ordering::Relaxed) > 0;
        states.push(summary.state);
        assert_eq!(summary.state == JobOutcome::Succeeded, all || moves == 10, "{left}: {summary:#?}");
    }
    assert!(states.contains(&JobOutcome::Failed) && states.contains(&JobOutcome::Succeeded), "{states:?}");
}

/// Keeps the results.
struct Keeps(ResultsBuilder);

impl LogSink for Keeps {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.0)
    }

    fn events(&mut self, _: u64, _: &[Event]) -> bool {
        true
    }
}
