//! Bad input: each gets a diagnostic or a clear error within its limit, never a panic or a hang.

use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::log::event::{Kind, OperatorMessage, VerdictKind};
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Done, Work, cases, machine};
use proptest::prelude::*;

fn limited() -> JobOptions {
    let limits = JobLimits { blocks: 20_000, zero_time_blocks: 5_000, events: 200_000, ..JobLimits::default() };
    JobOptions { limits, ..JobOptions::default() }
}

fn run(text: impl AsRef<[u8]>) -> Done {
    Work::texts(machine("fanuc-2path-lathe-exact", ""), &[text], limited()).run(None).expect("the job can be prepared")
}

/// On a machine that continues after everything.
fn going_on(text: impl AsRef<[u8]>) -> Done {
    let machine = machine("fanuc-2path-lathe-exact", "[control]\nunknown_code = \"warn\"\nstops = false\n");
    Work::texts(machine, &[text], limited()).run(None).expect("the job can be prepared")
}

fn numbers(done: &Done) -> Vec<u32> {
    done.summary.diagnostics.iter().map(|d| d.number).collect()
}

fn refused(text: impl AsRef<[u8]>) -> String {
    let error = Work::texts(machine("fanuc-2path-lathe-exact", ""), &[text], limited()).run(None).unwrap_err();
    error.findings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

#[test]
fn an_empty_file_is_refused_by_name() {
    assert!(refused("").contains("p1.nc: error: the file is empty"));
    assert!(refused("\r\n  \n\t\r").contains("the file is empty"));
}

#[test]
fn a_line_of_a_megabyte_is_an_alarm() {
    let done = run("G21\nG1 X".to_owned() + &"1".repeat(1 << 20) + "\nM30\n");
    assert_eq!(numbers(&done), [2900014]);
    assert_eq!(done.summary.diagnostics[0].line, 2);
}

#[test]
fn subprograms_that_call_each_other_for_ever_end_at_the_nesting_limit() {
    let done = run("O1\nM98 P2\nM30\nO2\nM98 P3\nM99\nO3\nM98 P2\nM99\n");
    // The levels of the control come before those of the job.
    assert_eq!(numbers(&done), [2900352]);
}

#[test]
fn subprograms_without_time_end_at_the_limit_of_blocks() {
    // 9999 passes in 9999 passes: no loop statement, no jump, no time.
    let done = run("O1\nM98 P99990002\nM30\nO2\nM98 P99990003\nM99\nO3\nG21\nM99\n");
    assert_eq!(numbers(&done), [2900070]);
    assert!(done.summary.verdict.is_some());
}

#[test]
fn a_missing_subprogram_names_the_places() {
    let done = run("O1\nM98 P1234\nM30\n");
    assert_eq!(numbers(&done), [2900040]);
    assert!(done.summary.diagnostics[0].text.contains("O1234"), "{}", done.summary.diagnostics[0].text);
}

#[test]
fn truncated_words_are_told_and_the_rest_acts() {
    let done = going_on("G1 X\nG\nN\nG1 X10. Z- F100\nM30\n");
    assert!(numbers(&done).iter().filter(|n| **n == 2001005).count() >= 3, "{:#?}", done.summary.diagnostics);
}

#[test]
fn lone_carriage_returns_end_blocks_and_nul_bytes_are_told() {
    let done = run("G21\rG4P1000\rM30\r");
    assert_eq!(done.summary.makespan_ns, 1_000_000_000);
    assert!(numbers(&done).is_empty());
    let done = run(b"G21\nG4\0P1000\nM30\n");
    assert_eq!(numbers(&done), [2900015]);
    assert_eq!(done.summary.makespan_ns, 1_000_000_000);
}

#[test]
fn a_program_beyond_the_machine_is_refused() {
    let mut work = Work::texts(machine("fanuc-mill-exact", ""), &["M30\n", "M30\n"], limited());
    assert!(work.run(None).unwrap_err().findings[0].text.contains("has more programs"));
    work.programs = vec![ProgramSelection { file: "p1.nc".into(), number: Some(77), section: None, channel: None }];
    assert!(work.run(None).unwrap_err().findings[0].text.contains("program O0077 not found"));
    work.programs = vec![ProgramSelection { file: "none.nc".into(), number: None, section: None, channel: None }];
    assert!(work.run(None).unwrap_err().findings[0].text.contains("no file 'none.nc'"));
    work.programs = vec![ProgramSelection { file: "p1.nc".into(), number: None, section: None, channel: Some(9) }];
    assert!(work.run(None).unwrap_err().findings[0].text.contains("no channel 9"));
}

#[test]
fn the_log_limit_ends_a_run_with_a_verdict() {
    let mut work = Work::texts(machine("fanuc-mill-exact", ""), &["N1 G4P1\nGOTO1\n"], limited());
    work.options.limits.events = 1000;
    let done = work.run(None).unwrap();
    assert_eq!(numbers(&done), [2900070]);
    assert_eq!(done.summary.verdict.map(|v| (v.kind, v.members[0].line)), Some((VerdictKind::Limit, 1)));
    // The block that passed the limit is the last one.
    assert!((1001..1010).contains(&done.outcome.events), "{}", done.outcome.events);
}

#[test]
fn diagnostics_of_a_channel_are_capped() {
    let mut text = "G98\n".to_owned();
    text.push_str(&"Y7 Q3 %% ??\n".repeat(5000));
    let done = going_on(text + "M30\n");
    assert!(numbers(&done).contains(&2900018));
    assert!(done.summary.diagnostics.len() <= 1002);
}

#[test]
fn macro_mistakes_are_alarms_with_a_column() {
    for (text, number) in [
        ("#1=[1+\nM30\n", 2900060),
        ("#1=1/0\nM30\n", 2900061),
        ("#1=SQRT[-1]\nM30\n", 2900062),
        ("#9999=1\nM30\n", 2900063),
        ("END1\nM30\n", 2900064),
        ("#3000=1(LIMIT)\nM30\n", 2900065),
        ("G65 A1.\nM30\n", 2900066),
        ("GOTO99\nM30\n", 2900042),
        ("#1=#[#[#[0-1.5]]]\nM30\n", 2900063),
    ] {
        assert_eq!(numbers(&run(text)), [number], "{text}");
    }
}

/// Pieces that programs are made of, good and bad.
fn piece() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("G1".to_owned()),
        Just("G2".to_owned()),
        Just("G28 U0".to_owned()),
        Just("M101".to_owned()),
        Just("S100 M3".to_owned()),
        Just("G83 Z-5. R-2. Q2. F100".to_owned()),
        Just("G84 Z-3. H9. K2".to_owned()),
        Just("G80".to_owned()),
        Just("M98 P1".to_owned()),
        Just("M99".to_owned()),
        Just("IF[#1LT".to_owned()),
        Just("]GOTO".to_owned()),
        Just("WHILE[".to_owned()),
        Just("]DO1".to_owned()),
        Just("END1".to_owned()),
        Just("#1=#1+1".to_owned()),
        Just("(".to_owned()),
        Just(")".to_owned()),
        Just("/2".to_owned()),
        Just("%".to_owned()),
        Just("\n".to_owned()),
        "[A-Z]-?[0-9]{0,12}\\.?[0-9]{0,4}",
        "[#\\[\\]A-Z0-9.+*/=-]{0,12}",
        any::<char>().prop_map(|c| c.to_string()),
    ]
}

/// Pieces of programs with canned cycles.
fn cycle_piece() -> impl Strategy<Value = String> {
    let codes = ["G81", "G82", "G83", "G73", "G84", "G74", "G76", "G85", "G86", "G87", "G88", "G89", "G80", "G79"];
    let others =
        ["G98", "G99", "G90", "G91", "G0", "G1", "G17", "G18", "G19", "G94", "G95", "G93", "M3", "M5", "M29", "\n"];
    prop_oneof![
        prop::sample::select(codes.to_vec()).prop_map(str::to_owned),
        prop::sample::select(others.to_vec()).prop_map(str::to_owned),
        "[XYZRQPFKLIJS]-?[0-9]{1,3}(\\.[0-9]{0,3})?",
        "[XYZRQK]-?(0|0\\.0001|99999999)",
        Just("\nG28 Z0\n".to_owned()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(100), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_cycles_end(pieces in prop::collection::vec(cycle_piece(), 1..120), activator in any::<bool>()) {
        let overlay = if activator { "[[codes]]\nid = \"CODE_CYCLE_ON\"\nword = \"G79\"\n" } else { "" };
        let text = pieces.join(" ") + "\nM30\n";
        let done = Work::texts(machine("fanuc-mill-exact", overlay), &[text], limited()).run(None).unwrap();
        prop_assert!(done.summary.makespan_ns >= 0);
    }
}

/// Every code of circles and threads that the shipped lathe does not have, on words of its own.
fn paths() -> String {
    let codes = [
        "INTERP_LINEAR_X10",
        "INTERP_LINEAR_X100",
        "INTERP_HELIX",
        "INTERP_ARC_CENTER",
        "INTERP_ARC_RADIUS",
        "INTERP_DEF_CENTER",
        "INTERP_DEF_RADIUS",
        "INTERP_DEF_CLW",
        "INTERP_DEF_CCLW",
        "INTERP_ARC_3D",
        "INTERP_THREAD_VAR_INC",
        "INTERP_THREAD_VAR_DEC",
        "INTERP_THREAD_ON",
        "INTERP_THREAD_OFF",
        "THREAD_SINGLE_FACE",
        "THREAD_MULTI_FACE",
        "THREAD_CHAMFER_ON",
        "THREAD_EDGE_ZIGZAG",
        "THREAD_STEP_DEPTH",
        "THREAD_STEP_AMOUNT",
    ];
    let data = [
        ("ARC_ANGLE", "A"),
        ("ARC_TURNS", "L"),
        ("ARC_3D_POINT_X", "I"),
        ("ARC_3D_POINT_Z", "K"),
        ("INTERP_THREAD_PITCH_X", "I"),
        ("INTERP_THREAD_STARTS", "L"),
        ("THREAD_CHAMFER_LENGTH", "D"),
        ("THREAD_CHAMFER_ANGLE", "A"),
        ("THREAD_MULTI_HEIGHT_Z", "K"),
        ("THREAD_MULTI_STEP_Z", "D"),
        ("THREAD_MULTI_STARTS", "L"),
        ("THREAD_MULTI_START_X", "J"),
    ];
    let mut text = String::new();
    for (code, at) in codes.iter().zip(101..) {
        text.push_str(&format!("[[codes]]\nid = \"CODE_{code}\"\nword = \"G{at}\"\n"));
    }
    for (id, register) in data {
        text.push_str(&format!("[[data]]\nid = \"REG_{id}\"\nregister = \"{register}\"\n"));
    }
    text
}

/// Pieces of programs with circles and threads.
fn path_piece() -> impl Strategy<Value = String> {
    prop_oneof![
        (101..121_u32).prop_map(|word| format!("G{word}")),
        prop::sample::select(vec!["G0", "G1", "G2", "G3", "G32", "G34", "G76", "G92", "G80", "\n", "\n", "G17", "G18"])
            .prop_map(str::to_owned),
        prop::sample::select(vec!["G90", "G91", "G96 S100", "G97 S500", "M3", "M5", "G98", "G99"])
            .prop_map(str::to_owned),
        "[XZUWRQPFKLIJAD]-?[0-9]{1,3}(\\.[0-9]{0,3})?",
        "[XZUWRQPFKLIJAD]-?(0|0\\.0001|99999999)",
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(100), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_circles_and_threads_end(pieces in prop::collection::vec(path_piece(), 1..120)) {
        let texts = [pieces.join(" ") + "\nM30\n", "M30\n".to_owned()];
        let mut work = Work::texts(machine("fanuc-2path-lathe-exact", &paths()), &texts, limited());
        let parallel = work.run(None).unwrap();
        work.options.threads = 1;
        let sequential = work.run(None).unwrap();
        prop_assert_eq!(&parallel.events, &sequential.events);
        prop_assert!(parallel.summary.makespan_ns >= 0);
        for event in &parallel.events {
            if let counterpoint_kernel::log::event::Kind::Motion(motion) = &event.kind {
                prop_assert!(motion.to.iter().all(|value| value.is_finite()), "{motion:?}");
            }
        }
    }
}

#[test]
fn a_step_of_almost_nothing_and_many_repeats_end_at_a_limit() {
    let text = "G90 G94 F1000\nG83 X1. Z-400. R2. Q0.001 K9999\nG80\nM30\n";
    let done = Work::texts(machine("fanuc-mill-exact", ""), &[text], limited()).run(None).unwrap();
    let numbers = numbers(&done);
    assert!(numbers.contains(&2900092) && numbers.contains(&2900070), "{numbers:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(300), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 1..2000)) {
        let _ = Work::texts(machine("fanuc-2path-lathe-exact", ""), &[bytes], limited()).run(None);
    }

    #[test]
    fn random_programs_give_the_same_log_in_both_modes(
        first in prop::collection::vec(piece(), 1..60),
        second in prop::collection::vec(piece(), 1..60),
    ) {
        let texts = [first.join(" ") + "\nM30\n", second.join(" ") + "\nM30\n"];
        let mut work = Work::texts(machine("fanuc-2path-lathe-exact", ""), &texts, limited());
        if let Ok(parallel) = work.run(None) {
            work.options.threads = 1;
            let sequential = work.run(None).unwrap();
            prop_assert_eq!(&parallel.events, &sequential.events);
            // A log tells a complete story.
            prop_assert!(parallel.summary.makespan_ns >= 0);
        }
    }
}

/// A machine whose code macros each issue the code of the next one, and whose functions each call the next one.
fn chain_of(macros: usize, functions: usize) -> std::sync::Arc<counterpoint_kernel::machine::Machine> {
    use counterpoint_kernel::files::MemoryFiles;
    use counterpoint_kernel::machine::package::Overlay;
    let mut text = "extends = \"fanuc-mill-exact\"\n[ce]\nname = \"chain\"\n[[registers]]\nindex = 3\nname = \"G\"\nwhole = 4\nfrac = 1\n[macros]\nfunctions = [\"f.mac\"]\n".to_owned();
    let mut files = MemoryFiles::default();
    for at in 1..=macros {
        text += &format!("[[codes]]\nid = \"CODE_C{at}\"\ncustom = true\nword = \"G{}\"\n", 2000 + at);
        text += &format!("[[macros.code]]\nmatch = [\"CODE_C{at}\"]\nfile = \"c{at}.mac\"\n");
        let next = if at < macros { format!("EXEC/NOW,'G{}'\n", 2001 + at) } else { "PPRINT/'!(*)',DEEP0(1)\n".into() };
        files.insert(format!("example/c{at}.mac"), next);
    }
    let mut lines = String::new();
    for at in 0..functions {
        let inner = if at + 1 < functions { format!("DEEP{}(N)+1", at + 1) } else { "N".to_owned() };
        lines += &format!("MACRO/DEEP{at}(REAL,N)\nDEEP{at}={inner}\nENDMAC\n");
    }
    files.insert("example/f.mac", lines);
    files.insert("example/machine.toml", text);
    let loaded = counterpoint_kernel::machine::load(&Overlay::new(files, counterpoint_tests::library()), "example");
    let findings: Vec<_> = loaded.findings.iter().map(ToString::to_string).collect();
    std::sync::Arc::new(loaded.machine.unwrap_or_else(|| panic!("{findings:#?}")))
}

#[test]
fn macros_may_be_active_in_any_number_that_the_stack_bears() {
    let run = |macros| {
        let work = Work::texts(chain_of(macros, 900), &["G2001\nM30\n"], limited()).run(None);
        let done = work.expect("the job can be prepared");
        let told = numbers(&done);
        (done, told)
    };
    let (done, told) = run(200);
    assert_eq!(told, [0_u32; 0]);
    let answer = done
        .events
        .iter()
        .any(|event| matches!(&event.kind, Kind::Message(OperatorMessage { text, .. }) if &**text == "900"));
    assert!(answer, "the innermost macro has run, and its chain of functions");
}
