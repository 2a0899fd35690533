//! Shipped cycles are no programs of the user: a diagnostic, a bar, a tool and a count of blocks name the block that
//! called the cycle, and the block inside is the origin.

use counterpoint_kernel::job::RunEnd;
use counterpoint_kernel::log::builder::JobResults;
use counterpoint_kernel::log::event::{self, Kind};
use counterpoint_kernel::log::summary::{DiagnosticSummary, JobOutcome};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};

const SIEMENS: &str = "siemens-mill";
const TNC: &str = "heidenhain-mill";

/// Machine, program, the line that the diagnostic names, and a word of the diagnostic.
const CASES: &[(&str, &str, u32, &str)] = &[
    // A call in a block, and with a calculation behind it.
    (SIEMENS, "G0 Z50\nT1 D1 M6\nS1000 M3 F200\nHOLES1(0,0,0,0,10)\nM30", 4, "61103"),
    (SIEMENS, "G0 Z50\nT1 D1 M6\nS1000 M3 F200\nR1=2\nSLOT1(10,0,2)\nM30", 5, "61101"),
    // From a subprogram of the user.
    (
        SIEMENS,
        "%_N_MAIN_MPF\nT1 D1 M6\nS1000 M3 F200\nHOLE\nM30\n%_N_HOLE_SPF\nPROC HOLE\nG0 X10 Z50\nHOLES1(0,0,0,0,10)\nM17",
        9,
        "61103",
    ),
    // A modal cycle acts in the block that positions.
    (SIEMENS, "G0 Z50\nT1 D1 M6\nS1000 M3 F200\nMCALL HOLES2(0,0,10)\nX5\nX10\nMCALL\nM30", 5, "61103"),
    // A defined cycle that a position calls.
    (
        TNC,
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nCYCL DEF 251 P Q215=0 Q218=60 Q219=20\nL X0 Y0 Z50 R0 FMAX M3\n\
         L X+0 Y+0 R0 FMAX M99\nEND PGM A MM",
        5,
        "Q201",
    ),
];

fn results(machine_name: &str, text: &str) -> (JobResults, RunEnd) {
    let work = Work::texts(machine(machine_name, ""), &[text], JobOptions::default());
    let (results, outcome, _) = work.results(None).expect("a job");
    (results, outcome)
}

#[test]
fn a_diagnostic_in_a_shipped_cycle_names_the_block_of_the_user() {
    for (machine, text, line, word) in CASES {
        let (results, _) = results(machine, text);
        let found = results.summary.diagnostics.iter().find(|found| found.text.contains(word) || found.severity >= 8);
        let Some(DiagnosticSummary { file, line: at, block, text: says, origin, .. }) = found else {
            panic!("no diagnostic: {text}")
        };
        let user = text.lines().nth(*line as usize - 1).unwrap_or_default().trim();
        assert!(!file.starts_with("//"), "{file}: {text}");
        assert_eq!((*at, block.as_str()), (*line, user), "{says}: {text}");
        let origin = origin.as_ref().expect("the block inside the cycle");
        assert!(origin.file.starts_with("//ICAMFS/") && origin.line > 0, "{origin:?}");
        assert!(!origin.statement.is_empty() && !says.contains(&*origin.statement), "{says}");
    }
}

#[test]
fn no_diagnostic_of_a_shipped_cycle_is_placed_in_it_whatever_its_arguments() {
    // Arguments that are missing, zero, negative or too many, as a mistake in a post-processor writes them.
    let arguments = ["", "0", "-5", "10,0", "10,0,2,-20", ",,,", "10,0,-2,20,,1", "1E9,0,0,-1E9"];
    let mut seen = 0;
    for cycle in ["CYCLE81", "CYCLE82", "CYCLE83", "CYCLE84", "CYCLE86", "POCKET3", "HOLES1", "HOLES2", "SLOT1"] {
        for arguments in arguments {
            let text = format!("G0 X0 Y0 Z50\nT1 D1 M6\nS1000 M3 F200\n{cycle}({arguments})\nG0 Z100\nM30\n");
            let (results, _) = results(SIEMENS, &text);
            for found in &results.summary.diagnostics {
                assert!(!found.file.starts_with("//"), "{}:{} {}: {text}", found.file, found.line, found.text);
                seen += u32::from(found.origin.is_some());
            }
            let channel = &results.timeline.channels[0];
            for bar in &channel.bars {
                let file = channel.file_name(bar.file, bar.line);
                assert!(!file.starts_with("//") && bar.end_line <= 6, "{bar:?}: {text}");
            }
        }
    }
    assert!(seen > 20, "the arguments reach the cycles: {seen}");
}

#[test]
fn blocks_of_shipped_cycles_are_not_counted_and_bars_end_with_the_call() {
    let text = "$TC_DP6[1,1]=2 G0 X0 Y0 Z50\nT1 D1 M6\nS1000 M3 F200\nPOCKET1(10,0,2,-5,,20,10,5,0,0,0)\nX50\nPOCKET1(10,0,2,-5,,20,10,5,0,0,0)\nM30\n";
    let work = Work::texts(machine(SIEMENS, ""), &[text], JobOptions::default());
    let done = work.run(None).expect("a job");
    assert_eq!(done.summary.state, JobOutcome::Succeeded, "{:?}", done.summary.diagnostics);
    let read = done.events.iter().filter(|event| matches!(event.kind, Kind::Block(_))).count();
    assert!(read > 20, "{read}");
    assert_eq!(done.summary.channels[0].blocks, 7);
    let (results, _, _) = work.results(None).expect("results");
    assert_eq!(results.summary.channels[0].blocks, 7);
    let feeds: Vec<_> =
        results.timeline.channels[0].bars.iter().filter(|bar| bar.kind == event::WorkClass::Feed).collect();
    assert_eq!(feeds.iter().map(|bar| (bar.line, bar.end_line)).collect::<Vec<_>>(), [(4, 4), (6, 6)]);
}

#[test]
fn a_cycle_in_the_folder_of_the_users_machine_is_the_users_program() {
    use counterpoint_kernel::files::{JobFiles, MemoryFiles};
    use counterpoint_kernel::machine::{load, package};

    let shipped = package::shipped();
    let mut own = MemoryFiles::default();
    let family = "siemens-common/resident/cst.dir/sc_levels.spf";
    let content = shipped.read(family).expect("a shipped cycle");
    own.insert(family, [&b"; ours\n"[..], &content].concat());
    let machine = load(&package::Overlay::over_shipped(own), SIEMENS).machine.expect("a machine");
    let text = "G0 Z50\nT1 D1 M6\nS1000 M3 F200\nPOCKET1(10,0,2)\nM30";
    let (results, _, _) = Work::texts(machine.into(), &[text], JobOptions::default()).results(None).expect("a job");
    let found = results.summary.diagnostics.iter().find(|found| found.text.contains("61101")).expect("the alarm");
    assert_eq!((found.file.as_str(), found.origin.is_none()), ("//ICAMFS/cst.dir/sc_levels.spf", true));
}
