//! Checks of programs that are not run: the block up to which a channel is checked, the findings, and that nothing
//! else acts.

use counterpoint_kernel::log::summary::{JobOutcome, Summary};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, cases, machine};

const ENDS_EARLY: u32 = 2_900_441;
const TARGET: u32 = 2_900_442;
const UNREADABLE: u32 = 2_900_443;
const ORDER: u32 = 2_900_444;
const LOOPS: u32 = 2_900_446;

fn work(name: &str, programs: &[&str]) -> Work {
    Work::texts(machine(name, ""), programs, JobOptions { lint: true, ..JobOptions::default() })
}

fn judged(name: &str, programs: &[&str]) -> Summary {
    let summary = work(name, programs).run(None).unwrap().summary;
    assert_eq!(summary.makespan_ns, 0, "blocks take no time");
    summary
}

/// Diagnostics with their channels and lines, except for those of severity 0 that are about the machine.
fn found(summary: &Summary) -> Vec<(u32, u16, u32)> {
    let about_machine = 2_900_445;
    let of = summary.diagnostics.iter().filter(|diagnostic| diagnostic.number != about_machine);
    of.map(|diagnostic| (diagnostic.number, diagnostic.channel, diagnostic.line)).collect()
}

/// The judgement about the first of two paths, whose second one has the waits that it has.
fn path(program: &'static str) -> Summary {
    let own = |line: &'static str| line.split(' ').find(|word| word.starts_with("M1"));
    let waits: Vec<&str> = program.lines().filter_map(own).collect();
    judged("fanuc-2path-lathe", &[program, &format!("O2\n{}\nM30\n", waits.join("\n"))])
}

fn clean(summary: &Summary) {
    assert_eq!((summary.state, found(summary)), (JobOutcome::Succeeded, Vec::new()), "{:#?}", summary.verdict);
    assert!(summary.waits.iter().all(|wait| wait.release_ns.is_some()));
}

#[test]
fn calls_and_jumps_are_followed() {
    clean(&path("O1\nM101\nGOTO 20\n/M98 P99\nN20 M102\nM30\n"));
    let lower = "O2\nM101\nM102\nM102\nM102\nM103\nM30\n";
    clean(&judged("fanuc-2path-lathe", &["O1\nM101\nM98 P10 L3\nM103\nM30\nO10\nM102\nM99\n", lower]));
    clean(&judged("fanuc-2path-lathe", &["O1\nM101\nG65 P10 L3 A1.\nM103\nM30\nO10\nM102\nM99\n", lower]));
    clean(&judged(
        "fanuc-2path-lathe",
        &["O1\nM101\nM98 P10\nM103\nM30\nO10\nM98 P11 L3\nM99\nO11\nM102\nM99\n", lower],
    ));
}

#[test]
fn branches_and_loops_without_waits_are_passed() {
    clean(&path("O1\nM101\nIF [#500 EQ 1] GOTO 10\nG1 X1. F1.\nIF [#501 EQ 1] GOTO 20\nN10 X2.\nN20 M102\nM30\n"));
    clean(&path("O1\nM101\nIF [#500 EQ 1] GOTO 10\nX1.\nGOTO 20\nN10 X2.\nN20 M102\nM30\n"));
    clean(&path("O1\nM101\nIF [#500 EQ 1] THEN #3000=1(BROKEN)\nM102\nM30\n"));
    clean(&path("O1\nM101\nIF [#500 EQ 1] GOTO 10\nM98 P20\nN10 M102\nM30\nO20\nG1 X1. F1.\nM99\n"));
    for looped in [
        "O1\nM101\nWHILE [#1 LT 5] DO1\nX1.\nM98 P20\n#1=#1+1\nEND1\nM102\nM30\nO20\nX2.\nM99\n",
        "O1\nM101\nN10 #1=#1+1\nX1.\nIF [#1 LT 5] GOTO 10\nM102\nM30\n",
        "O1\nM101\nN10 #1=#1+1\nIF [#1 GT 5] GOTO 20\nX1.\nGOTO 10\nN20 M102\nM30\n",
    ] {
        let summary = path(looped);
        let numbers: Vec<u32> = found(&summary).iter().map(|(number, ..)| *number).collect();
        assert_eq!((summary.state, numbers), (JobOutcome::Succeeded, vec![LOOPS]), "{looped}");
        assert_eq!(summary.waits.len(), 2, "{looped}");
    }
}

/// Every reason for which a channel is judged no further, with its line.
#[test]
fn what_only_a_run_can_tell_is_said_with_its_line() {
    for (program, line, says) in [
        ("O1\nIF [#500 EQ 1] GOTO 10\nM101\nN10 M102\nM30\n", 2, "line 3"),
        ("O1\nIF [#500 EQ 1] GOTO 10\nM30\nN10 M102\nM30\n", 2, "line 3"),
        ("O1\nIF [#500 EQ 1] THEN G65 P20\nM30\nO20\nM101\nM99\n", 2, "condition"),
        ("O1\nIF [#500 EQ 1] GOTO 10\nM98 P20\nN10 M30\nO20\nM98 P21\nM99\nO21\nM101\nM99\n", 2, "line 3"),
        ("O1\nWHILE [#1 LT 5] DO1\n#1=#1+1\nM101\nEND1\nM30\n", 2, "line 4"),
        ("O1\nN10 M101\n#1=#1+1\nIF [#1 LT 5] GOTO 10\nM30\n", 4, "line 2"),
        ("O1\nM#1\nM30\n", 2, "the value of M is computed"),
        ("O1\nM98 P#1\nM30\n", 2, "the value of P is computed"),
        ("O1\nM101 P#1\nM30\n", 2, "the value of P is computed"),
        ("O1\nGOTO #1\nM30\n", 2, "computed"),
        ("O1\nN10 X1.\nGOTO 10\n", 3, "without end"),
        ("O1\nG66 P20\nX1.\nM30\nO20\nM101\nM99\n", 2, "waits"),
        ("O1\n#3000=1(STOP)\nM30\n", 2, "alarm"),
    ] {
        let summary = judged("fanuc-2path-lathe", &[program, "O2\nM101\nM30\n"]);
        assert_eq!(found(&summary).last(), Some(&(ENDS_EARLY, 1, line)), "{program}");
        let text = &summary.diagnostics.iter().rfind(|diagnostic| diagnostic.number == ENDS_EARLY).unwrap().text;
        assert!(text.contains(says), "{program}: {text}");
        assert_eq!((summary.state, summary.verdict), (JobOutcome::Succeeded, None), "{program}");
    }
}

/// A channel that is checked only in part can still arrive: a wait for it is not a deadlock. Waits that do not depend
/// on it are checked.
#[test]
fn who_waits_for_a_channel_that_is_judged_in_part_is_not_condemned() {
    let lost = "O1\nIF [#500 EQ 1] GOTO 10\nM101 P12\nN10 M30\n";
    let summary = judged("fanuc-3path-lathe", &[lost, "O2\nM101 P12\nM30\n", "O3\nM30\n"]);
    assert_eq!((summary.state, summary.verdict), (JobOutcome::Succeeded, None));
    let summary = judged("fanuc-3path-lathe", &[lost, "O2\nM105 P23\nM30\n", "O3\nM30\n"]);
    assert_eq!(summary.state, JobOutcome::Failed);
    let text = summary.verdict.unwrap().text;
    assert!(text.contains("channel 2 waits at p2.nc line 2 'M105 P23' for channel 3; channel 3 has ended"), "{text}");
}

#[test]
fn targets_that_are_not_there_and_blocks_that_nobody_can_read_are_found() {
    let summary = path("O1\nIF [#500 EQ 1] GOTO 10\nM101\nM30\n");
    assert_eq!((summary.state, found(&summary)), (JobOutcome::Failed, vec![(TARGET, 1, 2)]));
    for (program, number) in [
        ("O1\nGOTO 10\nM30\n", 2_900_042),
        ("O1\nM98 P10\nM30\n", 2_900_040),
        ("O1\nG65 P10\nM30\n", 2_900_040),
        ("O1\nWHILE [#1 LT 5 DO1\nM30\n", UNREADABLE),
        ("O1\nWHILE [#1 LT 5] DO1\nM30\n", UNREADABLE),
        ("O1\nM101 P9\nM30\n", 2_900_051),
    ] {
        let summary = judged("fanuc-2path-lathe", &[program, "O2\nM30\n"]);
        assert_eq!((summary.state, found(&summary)), (JobOutcome::Failed, vec![(number, 1, 2)]), "{program}");
    }
}

#[test]
fn siemens_programs_are_followed() {
    let both = |one: &str, two: &str| judged("siemens-2ch-millturn", &[one, two]);
    let two = "WAITM(1,1,2)\nWAITM(2,1,2)\nWAITM(1,1,2)\nWAITM(2,1,2)\nM30\n";
    clean(&both("AGAIN:\nWAITM(1,1,2)\nWAITM(2,1,2)\nDONE:\nREPEAT AGAIN DONE\nM30\n", two));
    clean(&both(
        "WAITM(1,1,2)\nIF R1==1\nG1 X1 F1\nELSE\nG1 X2 F1\nENDIF\nWAITM(2,1,2)\nGOTOF MARK\nWAITM(9,1,2)\nMARK: WAITM(1,1,2)\nWAITM(2,1,2)\nM30\n",
        two,
    ));
    let crossed = both("WAITM(1,1,2)\nWAITM(2,1,2)\nM30\n", "WAITM(2,1,2)\nWAITM(1,1,2)\nM30\n");
    assert!(
        crossed.verdict.unwrap().text.starts_with("channel 1 waits at p1.nc line 1 'WAITM(1,1,2)' for channel 2; ")
    );
    let lost = both("FOR R1=1 TO 3\nWAITM(1,1,2)\nENDFOR\nM30\n", "M30\n");
    assert_eq!(found(&lost), [(ENDS_EARLY, 1, 1)]);
    let computed = both("DEF INT MARK\nMARK=3\nWAITM(MARK,1,2)\nM30\n", "M30\n");
    assert_eq!(found(&computed), [(ENDS_EARLY, 1, 3)]);
    let missing = both("IF R1>0 GOTOF NOWHERE\nM30\n", "M30\n");
    assert_eq!((missing.state, found(&missing)), (JobOutcome::Failed, vec![(TARGET, 1, 1)]));
}

/// A cycle that is stored with the machine is not entered if it meets no channel, neither when a block calls it nor when
/// blocks that move do.
#[test]
fn cycles_of_the_machine_are_passed() {
    let one = |machine: &str, program: &str| judged(machine, &[program]);
    clean(&one(
        "siemens-lathe",
        "G18 DIAMON\nT1 D1\nCYCLE97(2,,0,-30,20,20,5,2,1.3,0.05,30,0,5,1,3,1)\nCYCLE95(\"CONT\",2,0.1,0.2,,0.2,0.1,0.1,1)\nM30\n\
         CONT:\n",
    ));
    clean(&one(
        "siemens-mill",
        "T1 M6\nMCALL CYCLE81(10,0,2,-5)\nHOLES2(0,0,20,0,60,6)\nMCALL\nX10 Y10\nMCALL CYCLE83(10,0,2,-20)\nX5\nMCALL\nM30\n",
    ));
    let both = |one: &str, two: &str| judged("siemens-2ch-millturn", &[one, two]);
    let waits = both("MCALL MEET\nX1\nMCALL\nM30\n%_N_MEET_SPF\nWAITM(1,1,2)\nM17\n", "WAITM(1,1,2)\nM30\n");
    assert_eq!(found(&waits), [(ENDS_EARLY, 1, 1)]);
    let missing = both("MCALL NOWHERE\nX1\nM30\n", "M30\n");
    assert_eq!(found(&missing), [(ENDS_EARLY, 1, 1)]);
}

#[test]
fn okuma_citizen_and_isg_programs_are_followed() {
    let okuma = |one: &str, two: &str| judged("okuma-2saddle-lathe", &[one, two]);
    clean(&okuma("P10\nIF[V1 EQ 1] NA1\nX1\nNA1 P20\nM02\n", "P10\nP20\nM02\n"));
    let short = okuma("P10\nM02\n", "P10\nM30\n");
    assert_eq!(short.state, JobOutcome::Succeeded);
    let isg = |programs: &[&str]| judged("isg-3ch", programs);
    clean(&isg(&["#SIGNAL [ID7 CH2]\nM30\n", "#WAIT [ID7 CH1]\nM30\n", "M30\n"]));
    let never = isg(&["M30\n", "#WAIT [ID7 CH1]\nM30\n", "M30\n"]);
    assert!(never.verdict.unwrap().text.contains("channel 2 waits at p2.nc line 1 '#WAIT [ID7 CH1]' for channel 1"));
}

/// Nothing but waits acts: no word of an axis and no tool is looked at.
#[test]
fn nothing_else_acts() {
    clean(&path("O1\nT9999 X99999.\nM101\nG1 X1.\nG2 X1. R0.001\nM30\n"));
}

/// A run stops at the first word that the machine lacks; here all of them are named at once, each once, in branches too
/// and after blocks where the waits are judged no further.
#[test]
fn all_unknown_words_are_reported_in_one_go() {
    let program =
        "O1\nM428\nG411 F12.\nM428\nIF [#1 EQ 1] GOTO 10\nM429\nM101\nN10 M430\nM98 P20\nM30\nO20\nM431\nM99\n";
    let summary = judged("fanuc-2path-lathe", &[program, "O2\nM101\nM432\nM30\n"]);
    assert_eq!(summary.state, JobOutcome::Failed);
    let unknown = 2_900_320;
    let mut lines = found(&summary);
    lines.retain(|(number, ..)| *number == unknown);
    lines.sort_unstable();
    let own = [2, 3, 6, 8].map(|line| (unknown, 1, line));
    assert_eq!(lines, [own.as_slice(), &[(unknown, 2, 3)]].concat());
    let called = "O1\nM98 P20\nM30\nO20\nM431\nM99\n";
    let summary = judged("fanuc-2path-lathe", &[called, "O2\nM30\n"]);
    assert_eq!((summary.state, found(&summary)), (JobOutcome::Failed, vec![(unknown, 1, 5)]));
}

/// Results that depend on the order of arrival of channels are not judged: an axis that changes its channel twice, a
/// flag whose waiting channels name different partners.
#[test]
fn waits_that_depend_on_the_order_of_channels_are_no_deadlock() {
    let lease = judged(
        "siemens-2ch-millturn",
        &["G4 F2\nRELEASE(C1)\nG4 F1\nGET(C1)\nG4 F1\nM30\n", "G4 F0.5\nGET(C1)\nG4 F2\nRELEASE(C1)\nM30\n"],
    );
    assert_eq!((lease.state, lease.verdict.as_ref()), (JobOutcome::Succeeded, None));
    assert_eq!(found(&lease), [(ORDER, 1, 2), (ORDER, 2, 2)]);
    let barrier = judged("siemens-2ch-millturn", &["SETM(1)\nM30\n", "WAITM(2,1,2)\nM30\n"]);
    assert_eq!((barrier.state, barrier.verdict), (JobOutcome::Succeeded, None));
}

/// Programs that a run brings to their end are never condemned without it.
#[test]
fn a_program_that_runs_is_never_condemned() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut ran = 0;
    for _ in 0..cases(300) {
        let programs = [(); 2].map(|()| {
            let mut text = String::new();
            for _ in 0..random.u8(1..6) {
                let line = match random.u8(0..8) {
                    0 | 1 => format!("G4 F0.{}", random.u8(1..9)),
                    2 => "GET(C1)".to_owned(),
                    3 => "RELEASE(C1)".to_owned(),
                    4 => format!("SETM({})", random.u8(1..3)),
                    5 => format!("CLEARM({})", random.u8(1..3)),
                    _ => format!("WAITM({},1,2)", random.u8(1..3)),
                };
                text.push_str(&line);
                text.push('\n');
            }
            text + "M30\n"
        });
        let texts = [programs[0].as_str(), programs[1].as_str()];
        let options = JobOptions::default();
        let run = Work::texts(machine("siemens-2ch-millturn", ""), &texts, options).run(None).unwrap().summary;
        if run.state != JobOutcome::Succeeded {
            continue;
        }
        ran += 1;
        let judged = judged("siemens-2ch-millturn", &texts);
        assert_eq!((judged.state, judged.verdict), (JobOutcome::Succeeded, None), "{programs:#?}");
    }
    assert!(ran > 50, "only {ran} programs ran to their end");
}

/// The log of the judgement depends on nothing but the programs.
#[test]
fn the_judgement_is_the_same_for_any_number_of_threads() {
    let programs = [
        "O1\nM101 P12\nM98 P20 L50\nM30\nO20\nM102 P12\nM99\n",
        "O2\nM101 P12\nM98 P20 L50\nM30\nO20\nM102 P12\nM99\n",
    ];
    let digest = |threads| {
        let mut work = work("fanuc-3path-lathe", &[programs[0], programs[1], "O3\nM30\n"]);
        work.options.threads = threads;
        work.run(None).unwrap().summary.log_digest
    };
    let alone = digest(1);
    assert!([0, 2, 8].into_iter().all(|threads| digest(threads) == alone));
}
