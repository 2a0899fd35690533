//! The block loop: blocks a second of one channel, two channels with waits, statements.
//!
//! The programs are made here, so the bench needs nothing else. Figures and their meaning: docs/performance.md.

#![allow(clippy::expect_used, missing_docs, reason = "a bench stops on what cannot happen")]

mod jobs;

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::{Machine, load, package};
use counterpoint_kernel::options::JobOptions;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use jobs::{Count, job, job_with, lathe, machine, mill, results};

/// The mill with 64 rules of the tape editor: none matches, or some match on most blocks.
fn with_rules(hit: bool) -> Arc<Machine> {
    let mut text = "extends = \"fanuc-mill\"\n[ce]\nname = \"rules\"\n".to_owned();
    for rule in 0..64 {
        let find = match rule % 4 {
            0 => format!("^MSG{rule} *(\\\\([^)]*\\\\))"),
            1 => format!("CALL *O{rule}\\\\>"),
            2 => format!("H{rule}=[0-9.]*"),
            _ if hit && rule < 12 => format!("G{}\\\\>", rule % 3),
            _ => format!("G{}\\\\.1", 50 + rule),
        };
        let replace = if hit && rule % 4 == 3 && rule < 12 { format!("G0{}", rule % 3) } else { String::new() };
        let _ = writeln!(text, "[[tape_editor]]\nfind = \"{find}\"\nreplace = \"{replace}\"");
    }
    let mut files = MemoryFiles::default();
    files.insert("rules/machine.toml", text);
    let loaded = load(&package::Overlay::over_shipped(files), "rules");
    assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
    Arc::new(loaded.machine.expect("a machine"))
}

/// The mill with a block startup macro, a motion event macro and two code macros.
fn with_macros() -> Arc<Machine> {
    let mut user = MemoryFiles::default();
    user.insert(
        "m/machine.toml",
        r#"extends = "fanuc-mill"
[ce]
name = "macros"
[macros]
block_startup = "block.mac"
motion = "motion.mac"
[[macros.code]]
name = "feeds"
match = ["CODE_INTERP_LINEAR"]
file = "code.mac"
[[macros.code]]
name = "feeds with a depth"
match = ["CODE_INTERP_LINEAR", "CODE_INTERP_ARC_CCLW"]
present = ["REG_AXIS_X"]
file = "other.mac"
"#,
    );
    user.insert("m/block.mac", "IF/$P2.EQ.'STOP'\n$P1=0\nENDOF/IF");
    user.insert("m/motion.mac", "IF/$P2(3).LT.-100\nTERMAC\nENDOF/IF\nOUTPUT");
    user.insert("m/code.mac", "%G01=%G01+1\nOUTPUT");
    user.insert("m/other.mac", "%G02=%G02+$P2\nOUTPUT");
    let loaded = load(&package::Overlay::over_shipped(user), "m");
    Arc::new(loaded.machine.expect("a machine with macros"))
}

fn block_loop(c: &mut Criterion) {
    let mut group = c.benchmark_group("block_loop");
    let blocks = 20_000;
    group.throughput(Throughput::Elements(blocks as u64));
    group.sample_size(20);
    let (mill_job, files) = job(&machine("fanuc-mill"), &[mill(blocks)]);
    group.bench_function("milling", |b| b.iter(|| mill_job.run(&files, &JobControl::new(1), &mut Count(0))));
    group.bench_function("milling_results", |b| b.iter(|| results(&mill_job, &files, 1)));
    let (planned, files) = job_with(&machine("fanuc-mill"), &[mill(blocks)], JobOptions::default());
    group.bench_function("milling_results_look_ahead", |b| b.iter(|| results(&planned, &files, 1)));
    let (macro_job, files) = job(&with_macros(), &[mill(blocks)]);
    group.bench_function("macros", |b| b.iter(|| macro_job.run(&files, &JobControl::new(1), &mut Count(0))));
    let (edited, files) = job(&with_rules(false), &[mill(blocks)]);
    group.bench_function("tape_64_rules", |b| b.iter(|| edited.run(&files, &JobControl::new(1), &mut Count(0))));
    let (edited, files) = job(&with_rules(true), &[mill(blocks)]);
    group.bench_function("tape_64_rules_hit", |b| b.iter(|| edited.run(&files, &JobControl::new(1), &mut Count(0))));
    let text = format!(
        "#1=0\nF1000.\nWHILE[#1LT{}]DO1\n#2=#1*0.36\nG1 X[40*COS[#2]] Y[40*SIN[#2]]\n#1=#1+1\nEND1\nM30\n",
        blocks / 5
    );
    let (statements, files) = job(&machine("fanuc-mill"), &[text]);
    group.bench_function("statements", |b| b.iter(|| statements.run(&files, &JobControl::new(1), &mut Count(0))));
    group.finish();
}

/// One channel of 100,000 blocks; two such jobs at once, which shows the speed of two independent threads on this
/// machine; and two channels with 5,000 waits, whose waiting codes are 5,000 blocks more. The rate is that of one
/// channel.
fn channels(c: &mut Criterion) {
    let mut group = c.benchmark_group("channels");
    let blocks = 100_000;
    group.throughput(Throughput::Elements(blocks as u64));
    group.sample_size(20);
    let (one, files) = job(&machine("fanuc-2path-lathe"), &[lathe(blocks, 1, false)]);
    group.bench_function("one_channel", |b| b.iter(|| one.run(&files, &JobControl::new(2), &mut Count(0))));
    group.bench_function("one_channel_results", |b| b.iter(|| results(&one, &files, 2)));
    let (other, other_files) = job(&machine("fanuc-2path-lathe"), &[lathe(blocks, 2, false)]);
    group.bench_function("two_jobs_at_once_results", |b| {
        b.iter(|| {
            std::thread::scope(|scope| {
                scope.spawn(|| results(&other, &other_files, 2));
                results(&one, &files, 2);
            });
        });
    });
    group.throughput(Throughput::Elements((blocks + blocks / 20) as u64));
    let (two, files) = job(&machine("fanuc-2path-lathe"), &[lathe(blocks, 1, true), lathe(blocks, 2, true)]);
    group.bench_function("two_channels_5000_waits", |b| b.iter(|| two.run(&files, &JobControl::new(2), &mut Count(0))));
    group.bench_function("two_channels_5000_waits_results", |b| b.iter(|| results(&two, &files, 2)));
    group.finish();
}

criterion_group!(benches, block_loop, channels);
criterion_main!(benches);
