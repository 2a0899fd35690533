//! Memory allocations of a pass of a loop, for the statements of each control.
//!
//! Motion in the form of the control allocates nothing once the loop runs; the allocations of a statement of a
//! pre-processor are bounded. Work that a pass repeats although nothing has changed is visible here, regardless of the
//! load.

use std::alloc::System;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, Spec};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::machine;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Passes of a run; the other run has twice as many.
const PASSES: usize = 2_000;

/// A loop: machine, its additions, file, program with `{n}` passes, and maximum allocations of a pass. Calls have names
/// of programs in their events; a statement that becomes words is text that is read again.
const LOOPS: [(&str, &str, &str, &str, f64); 11] = [
    (
        "fanuc-mill-quiet",
        "",
        "p.nc",
        "O1\n#1=0\nG0 X0. Y0.\nF1000.\nWHILE[#1LT{n}]DO1\nG1 X10. Y0.\nG2 X0. Y0. I-5. J0.\nG0 Z5.\nG0 Z0.\n#1=#1+1\nEND1\nM30\n",
        0.0,
    ),
    ("fanuc-mill-quiet", "", "p.nc", "O1\n#1=0\nWHILE[#1LT{n}]DO1\n#2=SIN[#1]*10.+COS[#1]\n#1=#1+1\nEND1\nM30\n", 0.0),
    ("fanuc-mill-quiet", "", "p.nc", "O1\n#1=0\nWHILE[#1LT{n}]DO1\nM98P2\n#1=#1+1\nEND1\nM30\nO2\n#2=#1\nM99\n", 3.0),
    ("siemens-mill-quiet", "", "p.mpf", "R1=0\nWHILE R1<{n}\nR2=SIN(R1)*10+COS(R1)\nR1=R1+1\nENDWHILE\nM30\n", 0.0),
    ("siemens-mill-quiet", "", "p.mpf", "R1=0\nWHILE R1<{n}\nSUB\nR1=R1+1\nENDWHILE\nM30\n", 7.0),
    (
        "siemens-mill-quiet",
        "",
        "p.mpf",
        "G17 G90 G71 G94\nR1=0\nG0 X0 Y0\nF1000\nWHILE R1<{n}\nG2 X10 Y0 I=5 J=0\nG2 X0 Y0 I=AC(5) J=0\nR1=R1+1\nENDWHILE\nM30\n",
        29.0,
    ),
    (
        "heidenhain-mill-quiet",
        "",
        "p.h",
        "BEGIN PGM T MM\nQ1 = 0\nLBL 1\nQ2 = SIN Q1 * 10 + COS Q1\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nEND PGM T MM\n",
        0.0,
    ),
    (
        "heidenhain-mill-quiet",
        "",
        "p.h",
        "BEGIN PGM T MM\nQ1 = 0\nLBL 1\nCALL LBL 2\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nSTOP M30\nLBL 2\nQ2 = Q1\nLBL 0\nEND PGM T MM\n",
        6.0,
    ),
    (
        "heidenhain-mill-quiet",
        "",
        "p.h",
        "BEGIN PGM T MM\nQ1 = 0\nTOOL CALL 1 Z S1000\nL X+0 Y+0 R0 FMAX\nLBL 1\nCC X+5 Y+0\nC X+10 Y+0 DR- F1000\nC X+0 Y+0 DR-\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nEND PGM T MM\n",
        43.0,
    ),
    (
        "fanuc-mill-quiet",
        "preprocessor = \"okuma\"",
        "p.min",
        "O1\nV1=0\nNLOOP V2=SIN[V1]*10+COS[V1]\nV1=V1+1\nIF[V1 LT {n}]NLOOP\nM30\n",
        0.0,
    ),
    (
        "fanuc-mill-quiet",
        "preprocessor = \"okuma\"",
        "p.min",
        "O1\nV1=0\nNLOOP CALL O2\nV1=V1+1\nIF[V1 LT {n}]NLOOP\nM30\nO2\nV2=V1\nRTS\n",
        8.0,
    ),
];

/// Makes results, keeps no log.
struct Results(ResultsBuilder);

impl LogSink for Results {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.0)
    }

    fn is_logged(&self) -> bool {
        false
    }

    fn events(&mut self, _: u64, _: &[Event]) -> bool {
        true
    }
}

/// Allocations of a run with this many passes.
fn allocations(machine_name: &str, overlay: &str, file: &str, program: &str, passes: usize) -> usize {
    let mut files = MemoryFiles::default();
    files.insert(file, program.replace("{n}", &passes.to_string()));
    files.insert("sub.spf", "R2=R1\nRET\n");
    let programs = vec![ProgramSelection { file: file.to_owned(), number: None, section: None, channel: None }];
    let options = JobOptions { threads: 1, ..JobOptions::default() };
    let spec = Spec { machine: machine(machine_name, overlay), programs, options };
    let job = Job::prepare(spec, &files).unwrap();
    // Without a watchdog, which allocates by the clock.
    let (control, mut sink) = (JobControl::new(1), Results(ResultsBuilder::new(job.info())));
    let region = Region::new(ALLOCATOR);
    let outcome = job.run(&files, &control, &mut sink);
    let allocations = region.change().allocations;
    assert_eq!(sink.0.finish(&outcome).summary.diagnostics, [], "{program}");
    allocations
}

#[test]
fn a_pass_of_a_loop_allocates_no_more_than_it_needs() {
    let mut over = Vec::new();
    for (machine, overlay, file, program, most) in LOOPS {
        // Loads the machine and makes the data that a process makes once.
        allocations(machine, overlay, file, program, 10);
        let [few, many] = [PASSES, 2 * PASSES].map(|passes| allocations(machine, overlay, file, program, passes));
        let each = (many as f64 - few as f64) / PASSES as f64;
        println!("{each:8.3} allocations a pass: {machine} {overlay} {program:?}");
        // Results grow, each time to twice their size.
        if each > most + 0.05 {
            over.push(format!("{each} allocations a pass, {most} are enough: {machine} {overlay} {program:?}"));
        }
    }
    assert!(over.is_empty(), "{over:#?}");
}
