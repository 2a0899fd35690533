//! Moves whose times later ones decide: random programs of two channels that meet, share a variable and exchange an
//! axis.
//!
//! Properties of every program: one log for any number of threads, events of a channel in the order of their times,
//! the same moves as with simple times, none of them faster than those.

use counterpoint_kernel::log::event::{Event, Kind};
use counterpoint_kernel::log::summary::Summary;
use counterpoint_kernel::options::{JobOptions, MoveTiming};
use counterpoint_tests::{Done, Work, cases, machine};

/// One program of a channel; `own` and `other` are its number and that of its partner.
fn program(random: &mut fastrand::Rng, own: u16, meetings: &[(usize, u8)]) -> String {
    let other = 3 - own;
    let (x, z, c) = ("X", "Z", "C1");
    let mut text = String::from("DIAMOF G94 G18 G64\nG0 X50 Z0\nG1 F3000\n");
    let mut next = meetings.iter().peekable();
    let (mut at_x, mut at_z) = (50_i32, 0_i32);
    let mut beside = false;
    for step in 0..40 {
        if let Some((_, kind)) = next.next_if(|(at, _)| *at == step) {
            let word = if *kind == 0 || random.bool() { "WAITM" } else { "WAITMC" };
            text.push_str(&format!("{word}({},1,2)\n", step % 10));
        }
        match random.u8(0..24) {
            0..=8 => {
                at_x += random.i32(-8..=8);
                text.push_str(&format!("G1 {x}{at_x} {z}{at_z}\n"));
            }
            9..=12 => {
                at_z += random.i32(-8..=8);
                text.push_str(&format!("G1 {z}{at_z} F{}\n", random.u16(500..9000)));
            }
            13 => {
                at_z -= 4;
                at_x += 4;
                text.push_str(&format!("G{} {x}{at_x} {z}{at_z} CR=4\n", random.u8(2..=3)));
            }
            14 => {
                at_x += random.i32(1..=20);
                text.push_str(&format!("G0 {x}{at_x}\n"));
            }
            15 => text.push_str("G4 F0.05\n"),
            16 => text.push_str("M8\n"),
            17 => text.push_str(if random.bool() { "G60\n" } else { "G64\n" }),
            18 => {
                at_z += 3;
                text.push_str(&format!("G9 G1 {z}{at_z}\n"));
            }
            19 => text.push_str(&format!("R1=R1+{other}\n")),
            20 if own == 1 => text.push_str(&format!("G1 {c}=IC(5)\n")),
            21 => {
                text.push_str(if beside { "G40\n" } else { "G41\n" });
                beside = !beside;
            }
            22 => text.push_str("M3 S500\n"),
            _ => text.push_str("MSG(\"on\")\n"),
        }
    }
    text.push_str("G40\nM30\n");
    text
}

fn work(seed: u64) -> Work {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut meetings: Vec<(usize, u8)> =
        (0..random.usize(0..5)).map(|_| (random.usize(0..40), random.u8(0..2))).collect();
    meetings.sort_unstable();
    meetings.dedup_by_key(|meeting| meeting.0);
    let overlay = format!(
        "[time]\nlook_ahead = {}\ncorner_deviation = {}\nblock_time = {}\n[tool]\noffsets = [{{ number = 1, radius = 1 }}]\n\
         [compensation]\nwithout_tool = \"contour\"\nbeyond_looked_through = \"ends\"\n",
        random.u8(1..20),
        f64::from(random.u8(1..50)) / 100.0,
        f64::from(random.u8(0..3)) / 100.0,
    );
    let texts: Vec<String> = (1..=2).map(|own| program(&mut random, own, &meetings)).collect();
    Work::texts(machine("siemens-2ch-tm1", &overlay), &texts, JobOptions { threads: 1, ..JobOptions::default() })
}

/// The moves of a channel, with their times.
fn moves(done: &Done, channel: u16) -> Vec<(&Event, [u64; 4])> {
    let own = done.events.iter().filter(|event| event.channel == channel);
    own.filter_map(|event| match &event.kind {
        Kind::Motion(motion) => Some((event, [0, 1, 2, 3].map(|axis| motion.to[axis].to_bits()))),
        _ => None,
    })
    .collect()
}

/// The summary with times as the machine makes them.
fn check(seed: u64) -> Summary {
    let mut work = work(seed);
    let oracle = work.run(None).unwrap();
    for channel in 1..=2 {
        let mut last = (0, 0);
        for event in oracle.events.iter().filter(|event| event.channel == channel) {
            let at = (event.t_ns, event.micro);
            assert!(at >= last, "seed {seed}: {event:?} comes after {last:?}");
            last = at;
        }
        let mut end = 0;
        for (event, _) in moves(&oracle, channel) {
            assert!(event.t_ns >= end, "seed {seed}: {event:?} begins before {end}");
            end = event.t_ns + event.dur_ns;
        }
    }
    for threads in [2, 8, 0] {
        work.options.threads = threads;
        let done = work.run(None).unwrap();
        assert_eq!(done.events, oracle.events, "seed {seed}, {threads} threads");
        let (results, ..) = work.results(None).unwrap();
        assert_eq!(results.summary, oracle.summary, "seed {seed}, {threads} threads, without a log");
    }
    work.options.timing = MoveTiming::SIMPLE;
    let simple = work.run(None).unwrap();
    for channel in 1..=2 {
        let [full, simple] = [&oracle, &simple].map(|done| moves(done, channel));
        let ends = |moves: &[(&Event, [u64; 4])]| moves.iter().map(|(_, to)| *to).collect::<Vec<_>>();
        assert_eq!(ends(&full), ends(&simple), "seed {seed}: the same moves");
        let faster = full.iter().find(|(event, _)| event.dur_ns + 1 < shortest(event));
        assert_eq!(faster, None, "seed {seed}");
    }
    oracle.summary
}

/// The least time of a move: its length by its feed, ns.
fn shortest(event: &Event) -> i64 {
    match &event.kind {
        Kind::Motion(motion) if motion.feed > 0.0 => (motion.length / motion.feed * 60e9) as i64,
        _ => 0,
    }
}

/// Blocks without a move between two moves: few are seen through, many stop the path, and none of them piles up.
#[test]
fn a_path_that_runs_out_of_moves_stops() {
    for (blocks, seconds) in [(1000, 2.1), (5000, 2.2)] {
        let text = format!("DIAMOF G94\nG1 X100 F6000\n{}X200\nM30\n", "R1=R1+1\n".repeat(blocks));
        let work = Work::texts(machine("siemens-2ch-tm1", ""), &[text], JobOptions::default());
        let done = work.run(None).unwrap();
        assert_eq!(done.summary.makespan_ns, (seconds * 1e9_f64) as i64, "{blocks} blocks");
    }
}

#[test]
fn random_programs_have_one_log_and_the_moves_of_simple_times() {
    let (mut met, mut succeeded) = (0, 0);
    let seeds = u64::from(cases(60));
    for seed in 0..seeds {
        let summary = check(seed);
        met += u64::from(summary.waits.iter().any(|wait| wait.key.starts_with("WAITMC")));
        succeeded += u64::from(summary.verdict.is_none() && summary.highest_severity < 8);
    }
    assert!(met * 8 > seeds && succeeded * 2 > seeds, "of {seeds}, {met} have met at WAITMC and {succeeded} succeeded");
}
