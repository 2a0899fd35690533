//! Jobs that do as much as they can in every unit of work: each ends within its limits and its memory, and each can be
//! cancelled wherever it is.
//!
//! With `TIMES=1` and `--nocapture` it prints the time of each.

mod cases;
mod storms;

use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use cases::Case;
use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::job::{Job, LogSink, Spec};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::{Event, VerdictKind};
use counterpoint_kernel::log::summary::Summary;
use counterpoint_kernel::options::{JobLimits, JobOptions};

/// Most memory of the whole process: all cases, with programs and machines.
const MEMORY: u64 = 512 << 20;
/// After this time a cancelled job counts as one that does not end.
const WATCHDOG: Duration = Duration::from_secs(10);

/// Feeds results, keeps no event.
struct Quiet {
    builder: ResultsBuilder,
    /// As if the log were kept.
    logged: bool,
}

impl LogSink for Quiet {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.builder)
    }

    fn is_logged(&self) -> bool {
        self.logged
    }

    fn events(&mut self, _: u64, _: &[Event]) -> bool {
        true
    }
}

/// Small enough that a job comes to one of them soon.
fn small() -> JobLimits {
    JobLimits {
        blocks: 20_000,
        zero_time_blocks: 5_000,
        events: 200_000,
        memory: 64 << 20,
        macro_steps: 6_000_000,
        ..JobLimits::default()
    }
}

/// So large that no job reaches them.
fn large() -> JobLimits {
    JobLimits { memory: 128 << 20, block_length: 1 << 20, ..JobLimits::MOST }
}

/// Runs a case from its programs to its results; nothing comes out when it is cancelled before it begins.
fn run(case: &Case, limits: JobLimits, control: &JobControl, logged: bool) -> Option<Summary> {
    let options = JobOptions { limits, ..JobOptions::default() };
    let work = case.work(options);
    let spec = Spec { machine: work.machine.clone(), programs: work.programs.clone(), options: work.options.clone() };
    let job = match Job::prepare_until(spec, &work.files, control.stop()) {
        Ok(job) => job,
        Err(error) if error.cancelled => return None,
        Err(error) => panic!("{}: {error}", case.name),
    };
    let mut sink = Quiet { builder: ResultsBuilder::new(job.info()), logged };
    let outcome = job.run(&work.files, control, &mut sink);
    Some(sink.builder.finish(&outcome).summary)
}

fn measured() -> bool {
    std::env::var_os("TIMES").is_some()
}

/// Most memory that the process has had since the last call, none where the system does not say.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let bytes = line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10;
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    Some(bytes)
}

/// The memory of the process is measured, so one test runs at a time.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn every_hostile_job_ends_within_its_limits() {
    let _alone = alone();
    let mut wrong = Vec::new();
    for case in cases::all() {
        peak();
        let start = Instant::now();
        let summary = run(&case, small(), &case.control(), true).expect("nobody cancels it");
        let memory = peak();
        let mut numbers: Vec<u32> = summary.diagnostics.iter().map(|diagnostic| diagnostic.number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let limit = summary.verdict.as_ref().is_some_and(|verdict| verdict.kind == VerdictKind::Limit);
        if measured() {
            let (seconds, mebibytes) = (start.elapsed().as_secs_f64(), memory.unwrap_or(0) >> 20);
            println!("{:40} {seconds:7.2} s {mebibytes:5} MiB  limit {limit}, {numbers:?}", case.name);
        }
        let found = numbers.iter().find(|number| case.ends_with.contains(number));
        if found.is_none() || memory.is_some_and(|bytes| bytes >= MEMORY) {
            let texts: Vec<&str> =
                summary.diagnostics.iter().map(|diagnostic| diagnostic.text.as_ref()).take(5).collect();
            wrong.push(format!("{}: {numbers:?} {texts:?} {:?}, {memory:?} bytes", case.name, summary.verdict));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Cancels a job so long after it was requested; returns the time from there to its end, nothing if it ended before.
fn cancelled(case: Case, after: Duration, logged: bool) -> Option<Duration> {
    let control = Arc::new(case.control());
    let (ended, end) = channel();
    let (name, job) = (case.name, Arc::clone(&control));
    let thread = std::thread::spawn(move || {
        run(&case, large(), &job, logged);
        // There is no listener once the watchdog has given up.
        let _ = ended.send(());
    });
    let early = end.recv_timeout(after).is_ok();
    control.cancel();
    let since = Instant::now();
    assert!(
        early || end.recv_timeout(WATCHDOG).is_ok(),
        "{name}: it has not ended {} s after it was cancelled, at block {:?}",
        WATCHDOG.as_secs(),
        control.progress()
    );
    let took = since.elapsed();
    thread.join().unwrap_or_else(|_| panic!("{name}: it panicked"));
    (!early).then_some(took)
}

/// Cancelled at several moments of its life: while it is prepared, at its start, at its work; with a log and without.
#[test]
fn every_hostile_job_can_be_cancelled() {
    let _alone = alone();
    let mut worst = (Duration::ZERO, String::new());
    for case in cases::all() {
        let name = case.name;
        let mut times = Vec::new();
        for (after, logged) in [(20, true), (60, false), (250, true)] {
            times.push(cancelled(case.clone(), Duration::from_millis(after), logged));
        }
        if measured() {
            let shown = times.iter().map(|time| match time {
                Some(time) => format!("{:8.1} ms", time.as_secs_f64() * 1e3),
                None => "  ended before".to_owned(),
            });
            println!("{name:50} {}", shown.collect::<Vec<_>>().join(" "));
        }
        let longest = times.into_iter().flatten().max().unwrap_or_default();
        if longest > worst.0 {
            worst = (longest, name.to_owned());
        }
    }
    if measured() {
        println!("longest from cancel to end: {:.1} ms, {}", worst.0.as_secs_f64() * 1e3, worst.1);
    }
}

#[test]
fn the_verdict_names_who_keeps_most() {
    let _alone = alone();
    let case = cases::all().into_iter().find(|case| case.name == "macro: OBJECT sequence of texts").unwrap();
    let summary = run(&case, small(), &case.control(), false).unwrap();
    let verdict = summary.verdict.expect("a verdict");
    assert_eq!(verdict.kind, VerdictKind::Limit);
    assert!(verdict.text.contains("the OBJECT variable HOARD"), "{}", verdict.text);
}

#[test]
fn whether_memory_is_used_up_does_not_depend_on_scheduling() {
    let _alone = alone();
    let case = cases::all().into_iter().find(|case| case.name == "macro: GLOBAL variables of two channels").unwrap();
    let told = |threads| {
        let options = JobOptions { limits: small(), threads, ..JobOptions::default() };
        let results = case.work(options).results(None).unwrap().0;
        (results.summary.verdict.map(|verdict| verdict.text), results.summary.log_digest)
    };
    let first = told(1);
    assert!(first.0.as_ref().is_some_and(|text| text.contains("GLOBAL variables")), "{:?}", first.0);
    for threads in [0, 1, 2, 0] {
        assert_eq!(told(threads), first);
    }
}

#[test]
fn limits_beyond_the_most_count_as_the_most() {
    let _alone = alone();
    let limits = JobLimits { diagnostics: u32::MAX, block_length: 100 << 20, memory: u64::MAX, ..JobLimits::default() };
    let work = cases::all().remove(0).work(JobOptions { limits, ..JobOptions::default() });
    let spec = Spec { machine: work.machine.clone(), programs: work.programs.clone(), options: work.options.clone() };
    let job = Job::prepare(spec, &work.files).unwrap();
    let capped = &job.spec().options.limits;
    assert_eq!((capped.diagnostics, capped.block_length), (10_000, 1 << 20));
    assert_eq!(capped.memory, JobLimits::MOST.memory);
}

/// Bytes of memory, a program, and the subject of the verdict.
#[test]
fn results_count_as_memory() {
    let _alone = alone();
    let moves = "F9999.\nN1 G91 G2 X.01 I.005\nG2 X-.01 I-.005\nGOTO1\n";
    for (memory, named) in
        [(100 << 10, "the toolpath"), (40 << 10, "the toolpath"), (64 << 20, "more than 20000 blocks")]
    {
        let limits = JobLimits { memory, ..small() };
        let options = JobOptions { limits, ..JobOptions::default() };
        let work =
            counterpoint_tests::Work::texts(counterpoint_tests::machine("fanuc-mill-exact", ""), &[moves], options);
        for threads in [0, 1] {
            let mut work = work.clone();
            work.options.threads = threads;
            let logged = work.run(None).unwrap().summary;
            let verdict = logged.verdict.clone().expect("a verdict");
            assert_eq!(verdict.kind, VerdictKind::Limit);
            assert!(verdict.text.contains(named), "{memory}: {}", verdict.text);
            assert_eq!(work.results(None).unwrap().0.summary, logged);
        }
    }
}

/// A path takes no more than its part, however many arcs there are: it becomes coarser.
#[test]
fn a_path_has_no_more_than_its_part_of_the_memory() {
    let _alone = alone();
    let arcs = "F9999.\nN1 G91 G2 X.01 I.005\nG1 Y.01\nG2 X-.01 I-.005\nG1 Y.01\nGOTO1\n";
    let limits = JobLimits { memory: 4 << 20, ..small() };
    let work = counterpoint_tests::Work::texts(
        counterpoint_tests::machine("fanuc-mill-exact", ""),
        &[arcs],
        JobOptions { limits, ..JobOptions::default() },
    );
    let path = &work.results(None).unwrap().0.toolpath.channels[0].path;
    let bytes = size_of_val(path.moves.as_slice()) + size_of_val(path.curves.as_slice());
    assert!(bytes > 100 << 10 && bytes <= 512 << 10, "{bytes}");
}
