//! Cost of a block while the job is stepped through: free runs, runs that continue under a console, and steps of many
//! blocks and of one. Figures and their meaning: docs/performance.md.

#![allow(clippy::expect_used, clippy::print_stdout, missing_docs, reason = "a bench stops on what cannot happen")]

mod jobs;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::Job;
use counterpoint_kernel::operator::{
    BreakLocation, Breakpoint, Console, Heard, StepCalls, StepCommand, StepReply, Whom,
};
use jobs::{job, machine, results};

/// Blocks of a program.
const BLOCKS: usize = 200_000;

/// Runs of each kind, of which the fastest counts.
const RUNS: u32 = 7;

/// Answers each stop with the same command.
struct Always {
    first: std::sync::Mutex<Option<StepCommand>>,
    command: StepCommand,
    stops: AtomicU64,
}

impl Console for Always {
    fn has_news(&self) -> bool {
        false
    }

    fn poll(&self) -> Heard {
        Heard::Nothing
    }

    fn wait(&self, _at_most: Duration) -> Heard {
        let first = self.first.lock().expect("no panic").take();
        Heard::Command(first.unwrap_or_else(|| self.command.clone()))
    }

    fn say(&self, said: StepReply) {
        self.stops.fetch_add(u64::from(matches!(said, StepReply::Stopped(_))), Relaxed);
    }
}

fn fastest(run: impl Fn()) -> Duration {
    let time = || {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    (0..RUNS).map(|_| time()).min().unwrap_or_default()
}

/// Runs a job at whose stops one command is given; the stops.
fn stepped(
    job: &Job,
    files: &MemoryFiles,
    channels: usize,
    (first, command): (Option<StepCommand>, StepCommand),
) -> u64 {
    let console = Arc::new(Always { first: std::sync::Mutex::new(first), command, stops: AtomicU64::new(0) });
    let control = JobControl::new(channels).with_console(console.clone());
    let mut sink = jobs::Count(0);
    job.run(files, &control, &mut sink);
    console.stops.load(Relaxed)
}

fn measure(name: &str, (job, files): &(Job, MemoryFiles), programs: usize) {
    let (blocks, channels) = ((BLOCKS * programs) as f64, 2);
    let free = fastest(|| {
        results(job, files, channels);
    });
    let logged = fastest(|| {
        job.run(files, &JobControl::new(channels), &mut jobs::Count(0));
    });
    println!("{name:<14} results {:>6.1} ns a block; events counted {:>6.1} ns", ns(free, blocks), ns(logged, blocks));
    let line =
        Breakpoint { id: 0, spot: BreakLocation::Line { file: "none.nc".into(), line: 5 }, count: 0, once: false };
    let next = |blocks| StepCommand::Step { whom: Whom::Next, blocks, calls: StepCalls::Into };
    for (what, first, command) in [
        ("continue", None, StepCommand::Continue),
        ("continue, a breakpoint elsewhere", Some(StepCommand::Add(line)), StepCommand::Continue),
        ("step 10000", None, next(10_000)),
        ("step 10", None, next(10)),
        ("step 1", None, next(1)),
    ] {
        let stops = std::cell::Cell::new(0);
        let took = fastest(|| stops.set(stepped(job, files, channels, (first.clone(), command.clone()))));
        let more = ns(took.saturating_sub(logged), blocks);
        println!("{name:<14} {what:<34} {:>8.1} ns a block, {more:>8.1} more; {} stops", ns(took, blocks), stops.get());
    }
}

fn ns(time: Duration, blocks: f64) -> f64 {
    time.as_secs_f64() * 1e9 / blocks
}

fn main() {
    let lathe = |channel| jobs::lathe(BLOCKS, channel, false);
    measure("one program", &job(&machine("fanuc-2path-lathe"), &[lathe(1)]), 1);
    measure("two programs", &job(&machine("fanuc-2path-lathe"), &[lathe(1), lathe(2)]), 2);
}
