//! Many meetings: all channels of the largest machine, very many waits, and storms of them at one instant.
//!
//! *Invariant:* the memory of a run without a log does not grow with its meetings beyond their list, in which each has
//! a place; scheduling changes nothing.

use std::sync::{Mutex, MutexGuard, PoisonError};

use counterpoint_kernel::log::event::VerdictKind;
use counterpoint_kernel::options::{JobLimits, JobOptions};
use counterpoint_tests::{Work, machine};

/// Memory of the process is measured, so one test runs at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Most memory that the process has had since the last call, none where the system does not say.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let bytes = line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10;
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    Some(bytes)
}

/// A machine of this many channels with one axis each; SYNC without a list is for all of them.
fn job(channels: u16, program: impl Fn(u16) -> String) -> Work {
    let mut overlay = "[[registers]]\nindex = 60\nname = \"SYNC\"\nwhole = 8\n[[data]]\nid = \"REG_SYNC_PATHS\"\n\
                       register = \"P\"\nmin = 0\n[[waits]]\nword = \"SYNC1-SYNC99999999\"\nprimitive = \"barrier\"\n"
        .to_owned();
    for number in 1..=channels {
        overlay.push_str(&format!("[[axes]]\nname = \"X{number}\"\nrapid = 10_000\nhome = 0\n"));
        overlay.push_str(&format!("[[channels]]\nnumber = {number}\naxes = [\"X{number}\"]\n"));
    }
    let texts: Vec<String> = (1..=channels).map(program).collect();
    let limits = JobLimits { zero_time_blocks: u64::MAX, ..JobLimits::MOST };
    Work::texts(
        machine("fanuc-turning", &format!("[variables]\nshared = [[100, 199], [500, 999]]\nchannel = []\n\n{overlay}")),
        &texts,
        JobOptions { limits, ..JobOptions::default() },
    )
}

/// Runs a job with one thread and with all; returns the meetings and the memory of each.
fn both_modes(mut work: Work, logged: bool) -> (usize, i64, Vec<u64>) {
    let mut memory = Vec::new();
    let mut found = Vec::new();
    for threads in [1, 0, 2] {
        work.options.threads = threads;
        peak();
        let (results, ..) = work.results(None).unwrap();
        memory.extend(peak());
        assert_eq!(results.summary.verdict, None);
        found.push(results.summary);
    }
    assert!(found.windows(2).all(|pair| pair[0] == pair[1]));
    if logged {
        let digest = work.run(None).unwrap().summary.log_digest;
        assert_eq!(digest, found[0].log_digest);
    }
    (found[0].waits.len(), found[0].makespan_ns, memory)
}

/// In each round another channel comes last: 1 s after the others.
fn last_in_turns(channels: u16, rounds: u16) -> impl Fn(u16) -> String {
    move |own| {
        let round = |round: u16| {
            let late = if round % channels + 1 == own { "G4P1000\n" } else { "" };
            format!("{late}SYNC{}\n", round + 1)
        };
        (0..rounds).map(round).collect::<String>() + "M30\n"
    }
}

#[test]
fn channels_up_to_the_most_meet_all_together() {
    let _alone = alone();
    for channels in [2, 17, 31, 32] {
        let (meetings, makespan, _) = both_modes(job(channels, last_in_turns(channels, 64)), true);
        assert_eq!((meetings, makespan), (64, 64_000_000_000), "{channels} channels");
    }
}

/// One of 32 does not come: the verdict names it, and all waiting channels.
#[test]
fn one_of_the_most_is_missing() {
    let _alone = alone();
    let mut work = job(32, |own| if own == 32 { "G4P1000\nM30\n".to_owned() } else { "SYNC1\nM30\n".to_owned() });
    for threads in [1, 0] {
        work.options.threads = threads;
        let verdict = work.run(None).unwrap().summary.verdict.unwrap();
        assert_eq!(
            (verdict.kind, verdict.at_ns, verdict.members.len()),
            (VerdictKind::PartnerEnded, 1_000_000_000, 32)
        );
        assert!(verdict.members.iter().take(31).all(|member| member.waiting_for == [32]), "{verdict:?}");
    }
}

/// All 32 channels poll a variable that the next channel would write.
#[test]
fn the_most_channels_poll_in_a_ring() {
    let _alone = alone();
    let program = |own: u16| {
        let next = 500 + own % 32 + 1;
        format!("#{}=0\nSYNC1\nWHILE[#{}EQ0]DO1\nEND1\n#{next}=1\nM30\n", 500 + own, 500 + own)
    };
    let mut work = job(32, program);
    let mut found = Vec::new();
    for threads in [1, 0, 2] {
        work.options.threads = threads;
        let done = work.run(None).unwrap();
        let verdict = done.summary.verdict.clone().unwrap();
        assert_eq!((verdict.kind, verdict.at_ns, verdict.members.len()), (VerdictKind::PartnerSpinning, 2_000_000, 32));
        assert!(verdict.text.contains("channel 7 polls #507 at "), "{}", verdict.text);
        found.push(done.events);
    }
    assert!(found.windows(2).all(|pair| pair[0] == pair[1]));
}

/// Waits in the text of a program, one after the other, at one instant.
fn storm(waits: u32) -> impl Fn(u16) -> String {
    move |_| (0..waits).map(|wait| format!("SYNC{}\n", wait % 500 + 1)).collect::<String>() + "M30\n"
}

/// A loop of meetings at one instant.
fn whirl(rounds: u32) -> impl Fn(u16) -> String {
    move |_| format!("#1=0\nWHILE[#1LT{rounds}]DO1\n#1=#1+1\nSYNC1\nEND1\nM30\n")
}

#[test]
fn waits_in_the_text_of_a_program() {
    let _alone = alone();
    let (meetings, makespan, _) = both_modes(job(3, storm(2_000)), true);
    assert_eq!((meetings, makespan), (2_000, 0));
}

#[test]
fn a_storm_of_meetings_at_one_instant() {
    let _alone = alone();
    let (meetings, ..) = both_modes(job(4, whirl(2_000)), true);
    assert_eq!(meetings, 2_000);
}

/// `cargo test -p counterpoint-tests --test meetings -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes without optimisation"]
fn a_hundred_thousand_waits_in_a_program() {
    let _alone = alone();
    let (meetings, makespan, memory) = both_modes(job(3, storm(100_000)), false);
    assert_eq!((meetings, makespan), (100_000, 0));
    println!("100,000 waits of three channels: {memory:?} bytes with one thread, all, two");
}

/// Three times the meetings take no more memory than their places in the list of sync points: 1 KiB each for four
/// channels.
#[test]
#[ignore = "takes minutes without optimisation"]
fn memory_stays_flat_in_a_storm() {
    let _alone = alone();
    let rounds = 30_000;
    both_modes(job(4, whirl(1_000)), false);
    let (_, _, less) = both_modes(job(4, whirl(rounds)), false);
    let (_, _, more) = both_modes(job(4, whirl(3 * rounds)), false);
    println!("{rounds} meetings: {less:?}, three times as many: {more:?} bytes with one thread, all, two");
    for (less, more) in less.iter().zip(&more) {
        assert!(more.saturating_sub(*less) < u64::from(2 * rounds) << 10, "{less} bytes become {more}");
    }
}
