//! Jobs that benches run; their programs are made here, so a bench needs nothing else.

#![allow(dead_code, reason = "every bench takes what it needs")]

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, Spec};
use counterpoint_kernel::log::builder::{JobResults, ResultsBuilder};
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_kernel::machine::{Machine, load, package};
use counterpoint_kernel::options::{JobOptions, MoveTiming};

pub(crate) struct Count(pub(crate) u64);

impl LogSink for Count {
    fn events(&mut self, _: u64, batch: &[Event]) -> bool {
        self.0 += batch.len() as u64;
        true
    }
}

/// Results without a log, as `counterpoint run` builds them.
pub(crate) struct Fold(ResultsBuilder);

impl LogSink for Fold {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.0)
    }

    fn is_logged(&self) -> bool {
        false
    }

    fn events(&mut self, _: u64, _: &[Event]) -> bool {
        false
    }
}

pub(crate) fn results(job: &Job, files: &MemoryFiles, channels: usize) -> JobResults {
    let mut sink = Fold(ResultsBuilder::new(job.info()));
    let outcome = job.run(files, &JobControl::new(channels), &mut sink);
    std::hint::black_box(sink.0.finish(&outcome))
}

pub(crate) fn machine(name: &str) -> Arc<Machine> {
    Arc::new(load(&package::shipped(), name).machine.expect("a shipped machine"))
}

/// A job with times without accelerations.
pub(crate) fn job(machine: &Arc<Machine>, texts: &[String]) -> (Job, MemoryFiles) {
    job_with(machine, texts, JobOptions { timing: MoveTiming::SIMPLE, ..JobOptions::default() })
}

/// A job with options of its own.
pub(crate) fn job_with(machine: &Arc<Machine>, texts: &[String], options: JobOptions) -> (Job, MemoryFiles) {
    let mut files = MemoryFiles::default();
    let mut programs = Vec::new();
    for (index, text) in texts.iter().enumerate() {
        let file = format!("p{index}.nc");
        files.insert(file.clone(), text);
        programs.push(ProgramSelection { file, number: None, section: None, channel: None });
    }
    let spec = Spec { machine: machine.clone(), programs, options };
    let job = Job::prepare(spec, &files).expect("a job");
    // A job that stops at an alarm would be fast.
    let summary = results(&job, &files, machine.channels.len()).summary;
    assert_eq!(summary.state, JobOutcome::Succeeded, "{:?}", summary.diagnostics);
    (job, files)
}

pub(crate) fn mill(blocks: usize) -> String {
    let mut text = "G17 G21 G90 G94 G40\nG0 X0. Y0. Z5.\nS3000 M3\nG1 Z-1. F500.\n".to_owned();
    let mut last = [0.0; 2];
    for k in 0..blocks {
        let x = 50.0 + (k % 977) as f64 * 0.0173;
        let y = 40.0 + (k % 613) as f64 * 0.0291;
        let _ = match k % 5 {
            0 => writeln!(text, "G1 X{x:.4} Y{y:.4} Z-{:.3} F{}.", (k % 1000) as f64 * 0.001, 500 + k % 200),
            1 => writeln!(text, "X{x:.4} Y{y:.4}"),
            2 => writeln!(text, "X{x:.4}"),
            3 => writeln!(text, "G1 X{x:.4} Y{y:.4}"),
            // From where the tool is, though a coordinate begins again in this block.
            _ => writeln!(text, "G3 X{:.4} Y{:.4} R{:.2}", last[0] + 2.0, last[1], 2.0 + (k % 7) as f64 * 0.25),
        };
        last = [x, y];
    }
    text.push_str("G0 Z5.\nM5\nM30\n");
    text
}

pub(crate) fn lathe(blocks: usize, path: usize, waits: bool) -> String {
    let mut text = format!("O{path}\nG18 G21 G97 G98 G40\nF200.\n");
    for k in 0..blocks {
        let (z, x) = ((k % 50) as f64 * 0.5, 40.0 - (k % 20) as f64 * 0.2 + path as f64);
        let _ = if k % 3 == 0 {
            writeln!(text, "G0 X{:.1} Z-{z:.1}", x + 5.0)
        } else {
            writeln!(text, "G1 X{x:.1} Z-{z:.1}")
        };
        if waits && k % 20 == 19 {
            let _ = writeln!(text, "M{} P12", 101 + k / 20 % 90);
        }
    }
    text.push_str("M30\n");
    text
}
