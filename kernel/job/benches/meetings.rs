//! Mutual cost of channels: a meeting on one thread, by the number of channels; operations on shared data; two channels
//! that do not meet, one after the other and side by side; many meetings beside busy processes.
//!
//! The fastest of several runs counts, since disturbances only make a run slower. Runs that are compared alternate.
//! Figures and their meaning: docs/performance.md.

#![allow(clippy::expect_used, clippy::print_stdout, missing_docs, reason = "a bench prints, and stops on nonsense")]

mod jobs;

use std::fmt::Write as _;
use std::process::{Child, Command};
use std::sync::Arc;
use std::time::{Duration, Instant};

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::Job;
use counterpoint_kernel::machine::{Machine, load, package};
use counterpoint_kernel::options::{JobOptions, MoveTiming};
use jobs::{job_with, lathe, machine, results};

/// Runs of each kind.
const RUNS: usize = 15;
const MEETINGS: usize = 10_000;
/// The argument that asks for the meetings beside other processes only.
const BESIDE: &str = "--beside";
/// The argument that makes this program one that is only busy.
const BUSY: &str = "--busy";

/// A lathe of this many channels with an axis each; SYNC is for all of them.
fn many(channels: usize) -> Arc<Machine> {
    let mut text = "extends = \"fanuc-turning\"\n[ce]\nname = \"many\"\n[[registers]]\nindex = 60\nname = \"SYNC\"\nwhole = 8\n[[data]]\n\
                    id = \"REG_SYNC_PATHS\"\nregister = \"P\"\nmin = 0\n[[waits]]\nword = \"SYNC1-SYNC99999999\"\n\
                    primitive = \"barrier\"\n\
                    [variables]\nshared = [[100, 199], [500, 999]]\nchannel = []\n"
        .to_owned();
    for number in 1..=channels {
        let _ = writeln!(text, "[[axes]]\nname = \"X{number}\"\nrapid = 10_000\nhome = 0");
        let _ = writeln!(text, "[[channels]]\nnumber = {number}\naxes = [\"X{number}\"]");
    }
    let mut files = MemoryFiles::default();
    files.insert("many/machine.toml", &text);
    let loaded = load(&package::Overlay::over_shipped(files), "many");
    Arc::new(loaded.machine.expect("a machine of many channels"))
}

/// Times without accelerations, this many threads.
fn threads(threads: u16) -> JobOptions {
    JobOptions { threads, timing: MoveTiming::SIMPLE, ..JobOptions::default() }
}

/// The fastest run of each job, taken in turns.
fn fastest<const N: usize>(jobs: [&(Job, MemoryFiles); N], channels: usize) -> [f64; N] {
    let mut best = [Duration::MAX; N];
    for _ in 0..RUNS {
        for (best, (job, files)) in best.iter_mut().zip(jobs) {
            let start = Instant::now();
            results(job, files, channels);
            *best = start.elapsed().min(*best);
        }
    }
    best.map(|best| best.as_secs_f64())
}

/// A move and a wait in each round: `rounds` of them, the channels take turns in being last.
fn meeting(own: usize, channels: usize, rounds: usize) -> String {
    let mut text = "G98 F6000\nG0 X0\n".to_owned();
    for round in 0..rounds {
        let far = if round % channels == own { 2 } else { 1 };
        let _ = writeln!(text, "G1 X{}\nSYNC{}", if round % 2 == 0 { far } else { 0 }, round % 90 + 1);
    }
    text + "M30\n"
}

fn meetings(channels: &[usize]) {
    println!("meetings, one thread: {MEETINGS} of all channels, a move between two of them");
    for &channels in channels {
        let machine = many(channels);
        let texts: Vec<_> = (0..channels).map(|own| meeting(own, channels, MEETINGS)).collect();
        let all: Vec<u16> = (1..=channels).filter_map(|number| u16::try_from(number).ok()).collect();
        let met = job_with(&machine, &texts, threads(1));
        let passed = job_with(&machine, &texts, JobOptions { ignore_waits: all, ..threads(1) });
        let [met, passed] = fastest([&met, &passed], channels);
        let each = (met - passed) * 1e9 / MEETINGS as f64;
        println!(
            "{channels:>2} channels   {:>8.2} ms, {:>8.2} ms if waits are passed: {each:>7.0} ns a meeting, {:>5.0} a channel",
            met * 1e3,
            passed * 1e3,
            each / channels as f64
        );
    }
}

/// Each round reads and writes a common variable, at a time of its own.
fn sharing(own: usize, rounds: usize) -> String {
    let mut text = format!("G98 F6000\nG0 X{own}\n");
    for round in 0..rounds {
        let _ = writeln!(text, "G1 X{}\n#500=#500+1", own + round % 2 * (own + 1));
    }
    text + "M30\n"
}

fn shared() {
    println!("shared operations: two channels, each reads and writes #500 after every move");
    let machine = many(2);
    let texts = [sharing(0, MEETINGS), sharing(1, MEETINGS)];
    for count in [1, 2] {
        let job = job_with(&machine, &texts, threads(count));
        let [took] = fastest([&job], 2);
        let rate = 4.0 * MEETINGS as f64 / took;
        println!("{count} thread(s)    {:>8.2} ms: {rate:>10.0} operations a second", took * 1e3);
    }
}

fn side_by_side() {
    let machine = machine("fanuc-2path-lathe");
    let texts = [lathe(200_000, 1, false), lathe(200_000, 2, false)];
    let (one, two) = (job_with(&machine, &texts, threads(1)), job_with(&machine, &texts, threads(2)));
    let [one, two] = fastest([&one, &two], 2);
    println!("two channels that do not meet, 200,000 blocks each");
    println!("one thread {:.2} ms, two {:.2} ms: {:.2} times", one * 1e3, two * 1e3, one / two);
}

/// A process that does nothing but use a processor, until it is dropped.
struct Busy(Child);

impl Busy {
    fn new() -> Self {
        let own = std::env::current_exe().expect("a path");
        Self(Command::new(own).arg(BUSY).spawn().expect("a process"))
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn beside_others() {
    let machine = machine("fanuc-2path-lathe");
    let texts = [lathe(100_000, 1, true), lathe(100_000, 2, true)];
    println!("two channels, 5,000 meetings in 105,000 blocks each, alone and beside two busy processes");
    for count in [1, 2] {
        let job = job_with(&machine, &texts, threads(count));
        let run = || {
            let start = Instant::now();
            results(&job.0, &job.1, 2);
            start.elapsed().as_secs_f64()
        };
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..RUNS {
            times[0].push(run());
            let _others = [Busy::new(), Busy::new()];
            run();
            times[1].push(run());
        }
        let [alone, beside] = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
        });
        println!(
            "{count} thread(s)    {:.2} ms, {:.2} ms beside: {:.2} times",
            alone * 1e3,
            beside * 1e3,
            beside / alone
        );
    }
}

fn main() {
    if std::env::args().any(|argument| argument == BUSY) {
        // It ends by itself too: a busy process that is left over would spoil every later figure.
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs(60) {
            std::hint::spin_loop();
        }
        return;
    }
    // A number argument means a number of channels: only their meetings are measured.
    if let Some(channels) = std::env::args().find_map(|argument| argument.parse().ok()) {
        meetings(&[channels]);
        return;
    }
    if std::env::args().any(|argument| argument == BESIDE) {
        beside_others();
        return;
    }
    meetings(&[2, 4, 8, 16, 32]);
    shared();
    side_by_side();
    beside_others();
}
