//! The rate of a channel that meets another one every 20 blocks, beside the rate of a channel alone.
//!
//! It needs two cores that are free at the same time, which a virtual machine has only sometimes. So samples alternate
//! with two independent jobs, and count if these ran side by side as fast as alone.

#![allow(clippy::expect_used, clippy::print_stdout, missing_docs, reason = "a bench prints, and stops on nonsense")]

mod jobs;

use std::time::Instant;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::Job;
use jobs::{job, lathe, machine, results};

/// Samples without an argument.
const SAMPLES: usize = 200;
const BLOCKS: usize = 100_000;
/// Two jobs side by side take at most this much longer than one where two cores are free.
const FREE: f64 = 1.1;

fn ms(work: impl FnOnce()) -> f64 {
    let begin = Instant::now();
    work();
    begin.elapsed().as_secs_f64() * 1e3
}

/// Median, first and third quartile.
fn quartiles(mut samples: Vec<f64>) -> (f64, f64, f64) {
    samples.sort_by(f64::total_cmp);
    let at = |part: usize| samples.get(samples.len() * part / 4).copied().unwrap_or(f64::NAN);
    (at(2), at(1), at(3))
}

fn main() {
    // cargo gives `--bench` too.
    let samples = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(SAMPLES);
    let machine = machine("fanuc-2path-lathe");
    let (alone, other) = (job(&machine, &[lathe(BLOCKS, 1, false)]), job(&machine, &[lathe(BLOCKS, 2, false)]));
    let two = job(&machine, &[lathe(BLOCKS, 1, true), lathe(BLOCKS, 2, true)]);
    let run = |(job, files): &(Job, MemoryFiles)| drop(results(job, files, 2));
    let apart = || {
        ms(|| {
            std::thread::scope(|scope| {
                scope.spawn(|| run(&other));
                run(&alone);
            });
        })
    };
    let mut before = apart();
    let mut rounds = Vec::new();
    for _ in 0..samples {
        let (one, pair) = (ms(|| run(&alone)), ms(|| run(&two)));
        let after = apart();
        rounds.push((one, pair, before.max(after)));
        before = after;
    }
    let (one, low, high) = quartiles(rounds.iter().map(|round| round.0).collect());
    println!("one channel, {BLOCKS} blocks        {one:.2} ms ({low:.2} to {high:.2})");
    let free: Vec<_> = rounds.into_iter().filter(|round| round.0.max(round.2) <= FREE * one).collect();
    println!("two cores free in {} of {samples} samples", free.len());
    if free.is_empty() {
        println!("nothing can be said: run it again on a quieter machine");
        return;
    }
    let (apart, low, high) = quartiles(free.iter().map(|round| round.2).collect());
    println!("two jobs apart                     {apart:.2} ms ({low:.2} to {high:.2})");
    let (pair, low, high) = quartiles(free.iter().map(|round| round.1).collect());
    // The waiting codes are blocks too.
    let rate = |pair: f64| (BLOCKS + BLOCKS / 20) as f64 / pair / (BLOCKS as f64 / one);
    println!("two channels, 5,000 meetings       {pair:.2} ms ({low:.2} to {high:.2})");
    println!("rate of a channel beside one alone {:.2} ({:.2} to {:.2})", rate(pair), rate(high), rate(low));
}
