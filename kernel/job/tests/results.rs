//! Results of real jobs on a shipped machine.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, missing_docs)]

use std::sync::Arc;

use counterpoint_kernel::control::{JobControl, Limit};
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, RunEnd, Spec};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::{Event, VerdictKind};
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::listing;
use counterpoint_kernel::log::summary::{ChannelState, ChannelSummary, JobOutcome, Summary};
use counterpoint_kernel::machine::{load, package};
use counterpoint_kernel::options::{JobLimits, JobOptions};

const S: i64 = 1_000_000_000;

/// A log in memory.
#[derive(Default)]
struct Log(Vec<Event>);

impl LogSink for Log {
    fn events(&mut self, _first_seq: u64, batch: &[Event]) -> bool {
        self.0.extend_from_slice(batch);
        true
    }
}

/// Runs programs, one per channel, on a shipped machine.
fn run(machine: &str, programs: &[&str]) -> (Arc<Info>, Vec<Event>, RunEnd) {
    let loaded = load(&package::shipped(), machine);
    let machine = loaded.machine.expect("shipped machine");
    let mut files = MemoryFiles::default();
    let mut list = Vec::new();
    for (index, text) in programs.iter().enumerate() {
        let name = format!("jobs/p{}.nc", index + 1);
        files.insert(name.clone(), text.as_bytes());
        list.push(ProgramSelection { file: name, number: None, section: None, channel: None });
    }
    let job = Job::prepare(Spec { machine: machine.into(), programs: list, options: JobOptions::default() }, &files)
        .expect("a job that can run");
    let mut log = Log::default();
    let outcome = job.run(&files, &JobControl::new(job.info().channels.len()), &mut log);
    (job.info().clone(), log.0, outcome)
}

fn summary(info: &Arc<Info>, events: &[Event], outcome: &RunEnd) -> Summary {
    let mut builder = ResultsBuilder::new(info);
    events.iter().for_each(|event| builder.event(event));
    builder.finish(outcome).summary
}

fn listing(info: &Arc<Info>, events: &[Event], outcome: &RunEnd) -> String {
    let (mut out, summary) = (Vec::new(), summary(info, events, outcome));
    listing::render(info, 2, &summary, &mut (1..).zip(events.iter().cloned()), &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn times(channel: &ChannelSummary) -> [i64; 5] {
    [channel.end_ns, channel.feed_ns, channel.rapid_ns, channel.misc_ns, channel.wait_ns].map(|ns| ns / 1_000_000)
}

#[test]
fn two_turrets_meet() {
    let (info, events, outcome) =
        run("fanuc-2path-lathe", &["G4P2000\nM101\nG4P1000\nM30\n", "G4P500\nM101\nG4P3000\nM30\n"]);
    let summary = summary(&info, &events, &outcome);
    assert_eq!((summary.state, summary.makespan_ns, &summary.verdict), (JobOutcome::Succeeded, 5 * S, &None));
    assert_eq!(
        summary.channels.iter().map(times).collect::<Vec<_>>(),
        [[3000, 0, 0, 3000, 0], [5000, 0, 0, 3500, 1500]]
    );
    assert!(summary.channels.iter().all(|c| c.state == ChannelState::Ended && c.blocks == 4));
    let [meeting] = &summary.waits[..] else { panic!("{:?}", summary.waits) };
    assert_eq!((&*meeting.key, meeting.release_ns), ("M101", Some(2 * S)));
    let arrivals: Vec<_> = meeting.arrivals.iter().map(|a| (a.channel, a.t_ns, &*a.file, a.line, &*a.block)).collect();
    assert_eq!(arrivals, [(1, 2 * S, "jobs/p1.nc", 2, "M101"), (2, S / 2, "jobs/p2.nc", 2, "M101")]);
}

#[test]
fn a_blocked_channel_ends_at_its_wait() {
    let (info, events, outcome) = run("fanuc-2path-lathe", &["G4P1000\nM101\nG4P1000\nM30\n", "G4P5000\nM30\n"]);
    let summary = summary(&info, &events, &outcome);
    assert_eq!(summary.state, JobOutcome::Failed);
    let states: Vec<_> = summary.channels.iter().map(|c| (c.state, c.end_ns, c.wait_ns)).collect();
    assert_eq!(states, [(ChannelState::Blocked, S, 0), (ChannelState::Ended, 5 * S, 0)]);
    assert_eq!(summary.waits.len(), 1);
    assert_eq!((summary.waits[0].release_ns, summary.waits[0].arrivals.len()), (None, 1));
    let verdict = summary.verdict.expect("a verdict");
    assert_eq!((verdict.kind, verdict.at_ns), (VerdictKind::PartnerEnded, 5 * S));
    let members: Vec<_> = verdict.members.iter().map(|m| (m.channel, &*m.file, m.line, &*m.block)).collect();
    assert_eq!(members, [(1, "jobs/p1.nc", 2, "M101"), (2, "jobs/p2.nc", 2, "M30")]);
    assert_eq!(verdict.members[0].waiting_for, [2]);
}

#[test]
fn a_real_job_lists_every_block() {
    let (info, events, outcome) = run("fanuc-2path-lathe", &["%\nG4P2000\nM101\nM30\n", "M101\nG4P3000\nM30\n"]);
    let listing = listing(&info, &events, &outcome);
    assert!(listing.contains("\n1! M101\nwait mark=101 until 000:02.000\n2! G4P3000\n3! M30\n\nTOOLING"), "{listing}");
    assert!(listing.contains("MISC       00:00:03       60.000\nIDLE       00:00:02       40.000\n"), "{listing}");
}

/// A job of two channels that loop, with a limit.
fn looping(limits: JobLimits) -> (Job, MemoryFiles) {
    two_channels("G0 X50. Z5.\nWHILE[1 EQ 1]DO1\nG4 X1.\nEND1\nM30", limits)
}

/// A job of two channels with the same program, with a limit.
fn two_channels(text: &str, limits: JobLimits) -> (Job, MemoryFiles) {
    let machine = load(&package::shipped(), "fanuc-2path-lathe").machine.expect("shipped machine");
    let mut files = MemoryFiles::default();
    let mut programs = Vec::new();
    for (file, number) in [("a.nc", 1), ("b.nc", 2)] {
        files.insert(file.to_owned(), format!("O{number}\n{text}\n").as_bytes());
        programs.push(ProgramSelection { file: file.to_owned(), number: None, section: None, channel: None });
    }
    let options = JobOptions { limits, ..JobOptions::default() };
    (Job::prepare(Spec { machine: machine.into(), programs, options }, &files).expect("a job that can run"), files)
}

#[test]
fn the_limit_that_ended_a_run_is_known_and_nobody_else_claims_one() {
    let run = |limits| {
        let (job, files) = looping(limits);
        let control = JobControl::new(2);
        job.run(&files, &control, &mut Log::default());
        control.reached()
    };
    let limits = JobLimits::default();
    assert_eq!(run(JobLimits { blocks: 100, ..limits.clone() }), Some(Limit::Blocks));
    assert_eq!(run(JobLimits { simulated_ns: 100 * S, ..limits.clone() }), Some(Limit::SimulatedTime));
    assert_eq!(run(JobLimits { events: 100, ..limits }), Some(Limit::Events));
    let control = JobControl::new(2);
    let (job, files) = looping(JobLimits::default());
    control.cancel();
    job.run(&files, &control, &mut Log::default());
    assert_eq!(control.reached(), None, "a cancelled job has not reached a limit");
}

#[test]
fn the_last_block_is_not_exempt_from_the_limit_of_time() {
    let run = |text: &str, seconds| {
        let (job, files) = two_channels(text, JobLimits { simulated_ns: seconds * S, ..JobLimits::default() });
        let control = JobControl::new(2);
        job.run(&files, &control, &mut Log::default());
        control.reached()
    };
    // The moves start and stop, so they take a little more than 10 s.
    for (text, enough) in [("G4 X10.\nM30", 10), ("G98 G1 W10. F60. M30", 11), ("G98 G1 W10. F60.\n%", 11)] {
        assert_eq!(run(text, enough - 1), Some(Limit::SimulatedTime), "{text}");
        assert_eq!(run(text, enough), None, "{text}");
    }
}

/// The limit that a program reaches on a mill with accelerations, and the time of its last event, s.
fn on_a_mill(text: &str, seconds: i64) -> (Option<Limit>, f64) {
    let machine = load(&package::shipped(), "fanuc-mill").machine.expect("shipped machine");
    let mut files = MemoryFiles::default();
    files.insert("a.nc".to_owned(), text.as_bytes());
    let programs = vec![ProgramSelection { file: "a.nc".to_owned(), number: None, section: None, channel: None }];
    let options =
        JobOptions { limits: JobLimits { simulated_ns: seconds * S, ..JobLimits::default() }, ..JobOptions::default() };
    let job = Job::prepare(Spec { machine: machine.into(), programs, options }, &files).expect("a job that can run");
    let (control, mut log) = (JobControl::new(1), Log::default());
    job.run(&files, &control, &mut log);
    let end = log.0.iter().map(|event| event.t_ns + event.dur_ns).max().unwrap_or(0);
    (control.reached(), end as f64 / 1e9)
}

#[test]
fn the_limit_of_time_counts_the_time_that_moves_take_with_their_accelerations() {
    // Each move of 0.1 mm starts and stops, so it takes far longer than its length at 10 m/min.
    let moves = "G1 X0.1\nX0.\n".repeat(400);
    let (endless, finite) = (format!("G94 F10000\nN10 {moves}GOTO 10\nM30\n"), format!("G94 F10000\n{moves}M30\n"));
    let (limit, whole) = on_a_mill(&finite, 1000);
    assert_eq!(limit, None);
    let by_length = 800.0 * 0.1 / (10_000.0 / 60.0);
    assert!(whole > 5.0 * by_length, "{whole} s, {by_length} s without accelerations");
    let seconds = whole as i64 - 1;
    assert_eq!(on_a_mill(&finite, seconds).0, Some(Limit::SimulatedTime), "{whole} s");
    let (limit, end) = on_a_mill(&endless, 3 * seconds);
    assert_eq!(limit, Some(Limit::SimulatedTime));
    // The moves in the look-ahead, 100 of 800, are still executed.
    let bounds = 3.0 * seconds as f64..=3.0 * seconds as f64 + whole / 4.0;
    assert!(bounds.contains(&end), "{end} s is not in {bounds:?}");
}

/// A clock that advances by a second each time its own thread reads it.
fn ticking() -> std::time::Duration {
    thread_local!(static SECONDS: std::cell::Cell<u64> = const { std::cell::Cell::new(0) });
    SECONDS.set(SECONDS.get() + 1);
    std::time::Duration::from_secs(SECONDS.get())
}

#[test]
fn the_processor_time_of_every_kernel_thread_is_counted() {
    let (job, files) = looping(JobLimits { blocks: 100, ..JobLimits::default() });
    let control = JobControl::new(2).with_cpu_clock(ticking);
    job.run(&files, &control, &mut Log::default());
    assert!(control.cpu().as_secs() >= 2, "a thread for each channel: {:?}", control.cpu());
    let (job, files) = looping(JobLimits { blocks: 100, ..JobLimits::default() });
    let control = JobControl::new(2);
    job.run(&files, &control, &mut Log::default());
    assert_eq!(control.cpu().as_secs(), 0, "nothing is measured without a clock");
}
