//! Random programs of two to five channels that meet in every way: waits of each primitive, variables, polls, loops,
//! subprograms, spindles, alarms, and macros with a variable and a file of all channels. Scheduling, the number of
//! threads and the lack of a log change no byte of any result, and times and ends are those of a model that shares
//! nothing with the kernel.

mod machine;
mod model;
mod programs;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use counterpoint_kernel::job::WrittenFiles;
use counterpoint_kernel::log::builder::{JobResults, ResultsBuilder};
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::summary::{ChannelState, ChannelSummary};
use counterpoint_kernel::log::{jsonl, listing};
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::options::{JobLimits, JobOptions, RacePolicy};
use counterpoint_tests::{Work, cases, processors};
use model::End;
use programs::{Content, Numbers, Step, Text, Writer};

const MOST_CHANNELS: u16 = 5;

fn machines() -> Vec<Arc<Machine>> {
    (2..=MOST_CHANNELS).map(machine::machine).collect()
}

/// Says which case it was if a test panics in it.
struct Case(u64, Vec<String>);

impl Drop for Case {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("case {}: {:#?}", self.0, self.1);
        }
    }
}

fn texts(programs: &[Vec<Step>]) -> Vec<String> {
    (1..).zip(programs).map(|(own, steps)| Text::of(own, steps)).collect()
}

/// Every result file: those that kernels make, and if there is a log those that are rendered from it.
fn files(done: &Finished) -> BTreeMap<String, Vec<u8>> {
    let Finished { info, results, written, events } = done;
    let mut files: BTreeMap<String, Vec<u8>> =
        written.iter().map(|(name, text)| (format!("files/{name}"), text.as_bytes().to_vec())).collect();
    files.insert("summary.json".into(), serde_json::to_vec(&results.summary).unwrap());
    files.insert("timeline.json".into(), serde_json::to_vec(&results.timeline).unwrap());
    files.insert("timeline.svg".into(), results.timeline.svg().into_bytes());
    files.insert("toolpath.json".into(), serde_json::to_vec(&results.toolpath).unwrap());
    files.insert("toolpath.svg".into(), results.toolpath.svg().into_bytes());
    let Some(events) = events else { return files };
    let log = || (1..).zip(events.iter().cloned());
    let mut lines = Vec::new();
    log().for_each(|(seq, event)| jsonl::write_event(info, seq, &event, &mut lines));
    files.insert("events.jsonl".into(), lines);
    let mut merged = Vec::new();
    listing::render_merged(info, &results.summary, &mut log(), &mut merged).unwrap();
    files.insert("p.lce".into(), merged);
    for channel in 1..=info.channels.len() as u16 {
        let mut own = Vec::new();
        listing::render(info, channel, &results.summary, &mut log(), &mut own).unwrap();
        files.insert(format!("p.{channel}.lce"), own);
        let mut own = Vec::new();
        listing::render_log(info, channel, &results.summary, &mut log(), &mut own).unwrap();
        files.insert(format!("p.{channel}.log"), own);
    }
    files
}

/// A job that has run.
struct Finished {
    info: Arc<Info>,
    results: JobResults,
    written: WrittenFiles,
    events: Option<Vec<Event>>,
}

fn run(work: &Work, threads: u16, logged: bool, jitter: Option<fn(u16)>) -> Finished {
    let work = Work { options: JobOptions { threads, ..work.options.clone() }, ..work.clone() };
    if !logged {
        let (results, _, written) = work.results(jitter).unwrap();
        return Finished { info: work.info(), results, written, events: None };
    }
    let done = work.run(jitter).unwrap();
    let mut builder = ResultsBuilder::new(&done.info);
    done.events.iter().for_each(|event| builder.event(event));
    Finished { info: done.info, results: builder.finish(&done.outcome), written: done.files, events: Some(done.events) }
}

/// Limits of which one stops many jobs in their midst.
fn limits(numbers: &mut Numbers) -> JobLimits {
    let usual = JobLimits { blocks: 4_000, zero_time_blocks: 2_000, ..JobLimits::default() };
    match numbers.below(8) {
        0 => JobLimits { simulated_ns: 1_000_000 * (1 + numbers.below(40) as i64), ..usual },
        1 => JobLimits { blocks: 10 + numbers.below(60), ..usual },
        2 => JobLimits { events: 20 + numbers.below(150), ..usual },
        3 => JobLimits { diagnostics: 1 + numbers.below(3) as u32, ..usual },
        _ => usual,
    }
}

/// Lets another kernel go first now and then.
fn disturb(channel: u16) {
    static TURN: AtomicU64 = AtomicU64::new(1);
    let turn = TURN.fetch_add(0x9e37_79b9_7f4a_7c15, Relaxed) ^ u64::from(channel);
    if (turn >> 7).is_multiple_of(5) {
        std::thread::yield_now();
    }
}

#[test]
fn scheduling_changes_no_byte_of_any_result() {
    let machines = machines();
    let mut ends = BTreeMap::new();
    for case in 1..=u64::from(cases(80)) {
        let mut numbers = Numbers::of(case);
        let channels = 2 + numbers.below(u64::from(MOST_CHANNELS) - 1) as u16;
        let texts = texts(&Writer::new(&mut numbers, channels, Content::All).programs());
        let races = [RacePolicy::Off, RacePolicy::Warn, RacePolicy::Alarm][numbers.below(3) as usize];
        let options = JobOptions { limits: limits(&mut numbers), races, ..JobOptions::default() };
        let work = Work::texts(Arc::clone(&machines[usize::from(channels) - 2]), &texts, options);
        let _case = Case(case, texts.clone());
        let oracle = run(&work, 1, true, None);
        let expected = files(&oracle);
        for (threads, logged) in [(1, false), (2, true), (8, false), (64, true), (0, false)] {
            let other = run(&work, threads, logged, (case % 2 == 0).then_some(disturb as fn(u16)));
            for (name, bytes) in files(&other) {
                assert!(
                    expected.get(&name) == Some(&bytes),
                    "case {case}, {threads} threads, {}: {name} is another one: {texts:#?}",
                    if logged { "with a log" } else { "without a log" }
                );
            }
        }
        let summary = &oracle.results.summary;
        let end = format!("{:?}/{:?}", summary.state, summary.verdict.as_ref().map(|verdict| verdict.kind));
        *ends.entry(end).or_insert(0) += 1;
    }
    println!("{ends:#?}");
    // The jobs are not all alike.
    assert!(cases(80) < 80 || ends.len() >= 6, "{ends:?}");
}

#[test]
fn times_and_ends_are_those_of_the_model() {
    let machines = machines();
    let (mut ties, mut whole, mut dead) = (0, 0, 0);
    for case in 1..=u64::from(cases(600)) {
        let mut numbers = Numbers::of(case);
        let channels = 2 + numbers.below(u64::from(MOST_CHANNELS) - 1) as u16;
        let programs = Writer::new(&mut numbers, channels, Content::Spaced).programs();
        let Some(expected) = model::ends(&programs) else {
            ties += 1;
            continue;
        };
        let texts = texts(&programs);
        let limits = JobLimits { simulated_ns: i64::MAX, ..JobLimits::default() };
        let options = JobOptions { limits, threads: 1, ..JobOptions::default() };
        let work = Work::texts(Arc::clone(&machines[usize::from(channels) - 2]), &texts, options);
        let summary = work.results(None).unwrap().0.summary;
        let end = |channel: &ChannelSummary| match channel.state {
            ChannelState::Ended => End::At(channel.end_ns),
            ChannelState::Alarmed => End::Alarm,
            _ => End::Never,
        };
        let found: Vec<End> = summary.channels.iter().map(end).collect();
        assert_eq!(found, expected, "case {case}: {texts:#?} {:#?}", summary.verdict);
        let all_end = !expected.contains(&End::Never);
        assert_eq!(summary.verdict.is_none(), all_end, "case {case}: {texts:#?} {:#?}", summary.verdict);
        *(if all_end { &mut whole } else { &mut dead }) += 1;
    }
    println!("{whole} jobs end, {dead} never do, {ties} are not for the model");
    let all = cases(600);
    assert!(all < 600 || whole > all / 10 && dead > all / 10 && ties < all / 8, "{whole} {dead} {ties}");
}

/// Programs are judged without a run as the model says, and never found good when they are not.
#[test]
fn what_is_judged_without_a_run_is_true() {
    let machines = machines();
    let (mut clean, mut wrong, mut open) = (0, 0, 0);
    for case in 1..=u64::from(cases(2000)) {
        let mut numbers = Numbers::of(case);
        let channels = 2 + numbers.below(u64::from(MOST_CHANNELS) - 1) as u16;
        let programs = Writer::new(&mut numbers, channels, Content::Spaced).programs();
        let Some(expected) = model::ends(&programs) else { continue };
        let texts = texts(&programs);
        let options = JobOptions { threads: 1, lint: true, ..JobOptions::default() };
        let work = Work::texts(Arc::clone(&machines[usize::from(channels) - 2]), &texts, options);
        let summary = work.results(None).unwrap().0.summary;
        let says = |number| summary.diagnostics.iter().any(|diagnostic| diagnostic.number == number);
        let all_end = !expected.contains(&End::Never) && !expected.contains(&End::Alarm);
        // A loop may wait for a variable.
        if says(2_900_441) || says(2_900_444) || says(2_900_446) {
            open += 1;
        } else if summary.state == counterpoint_kernel::log::summary::JobOutcome::Succeeded {
            clean += 1;
            assert!(all_end, "case {case}: {texts:#?} {expected:?}");
        } else {
            wrong += 1;
            assert!(!all_end, "case {case}: {texts:#?} {:#?} {:#?}", summary.verdict, summary.diagnostics);
        }
    }
    println!("{clean} without a mistake, {wrong} with one, {open} open");
    assert!(cases(2000) < 2000 || clean > 60 && wrong > 8, "{clean} {wrong} {open}");
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS, "everywhere", &[("MIXED_CASES", "8")]);
}
