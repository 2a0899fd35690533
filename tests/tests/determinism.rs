//! The same job gives the same log under any schedule of threads.

use std::cell::Cell;
use std::time::Duration;

use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Done, Work, cases, machine, processors};

thread_local! {
    static STATE: Cell<u64> = const { Cell::new(0) };
}

/// Delays a kernel by a different small time at every shared operation; each thread has its own sequence.
fn disturb(channel: u16) {
    let value = STATE.with(|state| {
        let mut x = state.get();
        if x == 0 {
            let start = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
            x = start.subsec_nanos() as u64 ^ (u64::from(channel) << 32) | 1;
        }
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        state.set(x);
        x
    });
    match value % 8 {
        0 => std::thread::sleep(Duration::from_micros(value >> 8 & 127)),
        1..=3 => std::thread::yield_now(),
        _ => {}
    }
}

/// Three turrets that meet in pairs and all together, share variables, poll, and command one spindle.
fn busy() -> Work {
    let path = |own: u16| {
        let mut text = format!("O{own}\nG98 F200.\n#1=0\nG97 S{}00 M3\n", own + 4);
        for round in 0..12_u16 {
            text.push_str(&format!(
                "G0 X{}. Z{}.\nG1 Z-{}. F{}\n",
                40 + own,
                5 + round,
                10 + own * 3 + round,
                150 + round
            ));
            text.push_str(&format!("#{}=#{}+{}\n", 500 + round % 3, 500 + (round + 1) % 3, own));
            text.push_str(&format!("IF[#{}GT40]THEN #500=0\n", 500 + round % 3));
            match round % 4 {
                0 => text.push_str("M110P123\n"),
                1 if own != 3 => text.push_str("M111P12\n"),
                2 if own != 1 => text.push_str("M112P23\n"),
                _ => text.push_str(&format!("G4P{}\n", 10 * own)),
            }
            text.push_str(&format!("G1 X[#{}+30] F{}\n", 500 + round % 3, 300 + own));
        }
        text.push_str(match own {
            1 => "#520=1\nM30\n",
            _ => "WHILE[#520NE1]DO1\nEND1\nM30\n",
        });
        text
    };
    let preset = "#500=1\n#501=2\n#502=3\n#520=0\n";
    let texts: Vec<String> = (1..=3)
        .map(|own| if own == 1 { format!("{preset}M110P123\n{}", path(1)) } else { format!("M110P123\n{}", path(own)) })
        .collect();
    Work::texts(machine("fanuc-3path-lathe-exact", ""), &texts, JobOptions::default())
}

#[test]
fn two_hundred_runs_give_one_log() {
    let mut work = busy();
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    let waits = oracle.summary.waits.len();
    assert!(waits >= 9, "the job must meet often, it met {waits} times: {:#?}", oracle.summary);
    assert_eq!(
        oracle.summary.diagnostics.iter().filter(|d| d.severity >= 8).count(),
        0,
        "{:#?}",
        oracle.summary.diagnostics
    );
    for run in 0..cases(200) as usize {
        work.options.threads = [1, 2, 8, 0][run % 4];
        let done = work.run((run % 3 != 0).then_some(disturb as fn(u16))).unwrap();
        assert_eq!(done.summary.log_digest, oracle.summary.log_digest, "run {run}, threads {}", work.options.threads);
        assert_eq!(done.events, oracle.events, "run {run}");
    }
}

/// Results without an ordered log are those of the log.
fn same_results(work: &Work, oracle: &Done, run: usize) {
    let (results, outcome, _) = work.results((!run.is_multiple_of(3)).then_some(disturb as fn(u16))).unwrap();
    assert_eq!(results.summary.log_digest, oracle.summary.log_digest, "run {run}, threads {}", work.options.threads);
    assert_eq!(results.summary, oracle.summary, "run {run}, threads {}", work.options.threads);
    assert_eq!(outcome, oracle.outcome, "run {run}");
}

#[test]
fn results_that_kernels_feed_are_those_of_the_log() {
    let mut work = busy();
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    for run in 0..cases(100) as usize {
        work.options.threads = [1, 2, 8, 0][run % 4];
        same_results(&work, &oracle, run);
    }
    work.options.limits.simulated_ns = 30_000_000_000;
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    assert!(oracle.summary.verdict.is_some());
    for run in 0..cases(60) as usize {
        work.options.threads = [0, 2, 1][run % 3];
        same_results(&work, &oracle, run);
    }
}

/// Two turrets that meet all the time, with a command to their spindle and a shared variable between some meetings.
#[test]
fn two_kernels_that_meet_often_give_one_log() {
    let path = |own: usize| {
        let mut text = format!("O{own}\nG98 F200.\nG97 S800 M3\n");
        for round in 0..300_usize {
            text.push_str(&format!("G1 X{}. Z-{}.\n", 40 + (round * own) % 7, round % 9));
            match (round + own * 7) % 23 {
                0 => text.push_str(&format!("#50{own}=#50{}+1\n", 3 - own)),
                1 => text.push_str(&format!("S{}\n", 700 + round)),
                _ => {}
            }
            text.push_str(&format!("M{}{}\n", 101 + round % 5, if round % 2 == 0 { "" } else { " P12" }));
        }
        text + "M30\n"
    };
    let mut work = Work::texts(machine("fanuc-2path-lathe-exact", ""), &[path(1), path(2)], JobOptions::default());
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    assert_eq!((oracle.summary.waits.len(), &oracle.summary.verdict), (300, &None), "{:#?}", oracle.summary.verdict);
    for run in 0..cases(60) as usize {
        work.options.threads = [0, 2, 1][run % 3];
        same_results(&work, &oracle, run);
        let done = work.run((run % 2 == 0).then_some(disturb as fn(u16))).unwrap();
        assert_eq!(done.events, oracle.events, "run {run}");
    }
}

#[test]
fn a_job_that_is_stopped_by_a_limit_gives_one_log() {
    let mut work = busy();
    work.options.limits.simulated_ns = 30_000_000_000;
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    assert!(oracle.summary.verdict.is_some());
    for run in 0..cases(40) as usize {
        work.options.threads = [0, 2, 1][run % 3];
        let done = work.run(Some(disturb)).unwrap();
        assert_eq!(done.events, oracle.events, "run {run}");
    }
}

#[test]
fn a_full_log_is_cut_at_the_same_event() {
    let mut work = busy();
    work.options.limits.events = 300;
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    for run in 0..cases(60) as usize {
        work.options.threads = [0, 2, 1][run % 3];
        let done = work.run(Some(disturb)).unwrap();
        assert_eq!(done.events, oracle.events, "run {run}");
    }
}

#[test]
fn a_panic_in_one_kernel_reaches_the_owner_of_the_job() {
    let work = busy();
    let result = std::panic::catch_unwind(|| {
        work.run(Some(|channel| {
            if channel == 2 {
                panic!("on purpose");
            }
        }))
    });
    let panic = result.expect_err("the panic must not be lost and nothing may hang");
    assert_eq!(panic.downcast_ref::<&str>(), Some(&"on purpose"));
}

/// One channel runs thousands of blocks beyond the time at which the other channel ends the job.
fn far_ahead(before: &str, idle_before: &str) {
    let ahead: String = (0..12_000).map(|n| format!("G1 X{}. Z-{}.\n", 20 + n % 7, n % 11)).collect();
    let idle = "G40\n".repeat(6_000);
    let texts = [format!("O1\nG98 F100.\n{before}{ahead}M30\n"), format!("O2\n{idle_before}{idle}M30\n")];
    let mut work = Work::texts(machine("fanuc-2path-lathe-exact", ""), &texts, JobOptions::default());
    work.options.limits.zero_time_blocks = 5_000;
    work.options.threads = 1;
    let oracle = work.run(None).unwrap();
    assert!(oracle.summary.verdict.is_some(), "{:#?}", oracle.summary.diagnostics);
    for run in 0..cases(40) as usize {
        work.options.threads = [0, 2][run % 2];
        same_results(&work, &oracle, run);
    }
}

#[test]
fn a_kernel_that_ran_far_ahead_of_a_stop_leaves_nothing_behind_it() {
    far_ahead("", "");
}

#[test]
fn a_partner_that_stood_for_long_may_still_stop_the_job() {
    let long: String = (0..3_000).map(|n| format!("G1 X{}. Z-{}.\n", 10 + n % 5, n % 13)).collect();
    far_ahead(&format!("{long}M100\n"), "M100\n");
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS, "everywhere", &[("MIXED_CASES", "6")]);
}

/// A program of a channel for random jobs: marks with lists of all kinds, starts of other channels, and loops around
/// them.
fn marks(own: u16, channels: u16, seed: &mut u64) -> String {
    let mut next = |below: u64| {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        *seed % below
    };
    let mut text = String::new();
    for _ in 0..4 + next(8) {
        let other = 1 + (u64::from(own) + next(u64::from(channels) - 1)) % u64::from(channels);
        let mark = next(3);
        text += &match next(12) {
            0..=2 => format!("G4 F{}\n", 1 + next(4)),
            3 | 4 => format!("WAITM({mark},{other})\n"),
            5 => format!("WAITMC({mark},{})\n", (1..=channels).map(|c| c.to_string()).collect::<Vec<_>>().join(",")),
            6 => format!("SETM({mark})\n"),
            7 => format!("CLEARM({mark})\n"),
            8 => format!("WAITE({channels})\n"),
            9 => format!("INIT({channels},\"SIDE\")\nSTART({channels})\n"),
            10 => format!("FOR R1=1 TO {}\nSETM({mark})\nG4 F1\nENDFOR\n", 1 + next(3)),
            _ => "G1 X10 F100\n".to_owned(),
        };
    }
    text + "M30\n"
}

/// The last channel has no program: the first channel to arrive starts it.
#[test]
fn random_programs_with_marks_and_starts_give_one_log() {
    let machine = machine("siemens-4ch", "");
    let mut kinds = std::collections::BTreeMap::new();
    for case in 1..=u64::from(cases(300)) {
        let mut seed = case.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let texts: Vec<String> = (1..4).map(|own| marks(own, 4, &mut seed)).collect();
        let mut work = Work::texts(machine.clone(), &texts, JobOptions::default());
        work.files.insert("side.mpf", "G4 F2\nWAITM(1,1)\nSETM(0)\nM30\n");
        work.options.threads = 1;
        let oracle = work.run(None).unwrap();
        for threads in [0, 2] {
            work.options.threads = threads;
            let done = work.run(Some(disturb)).unwrap();
            assert_eq!(done.events, oracle.events, "case {case}, threads {threads}: {texts:#?}");
        }
        let (results, ..) = work.results(None).unwrap();
        assert_eq!(results.summary, oracle.summary, "case {case}: {texts:#?}");
        *kinds.entry(format!("{:?}", oracle.summary.verdict.map(|verdict| verdict.kind))).or_insert(0) += 1;
    }
    // The jobs are not all alike.
    assert!(kinds.len() >= 4, "{kinds:?}");
}
