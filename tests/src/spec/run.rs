//! Runs an example: with one thread, with many and shared operations out of step, and with results only; all must
//! agree.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use counterpoint_kernel::diag;
use counterpoint_kernel::log::event::{Diagnostic, Kind};
use counterpoint_kernel::log::summary::JobOutcome;
use counterpoint_mdspec::{Check, Example, counted, severity_name};

use super::{Case, observe, outcome};
use crate::Done;

/// Compares an example with its result.
pub fn check(example: &Example, check: &mut Check<'_>) {
    let case = match Case::of(example) {
        Ok(case) => case,
        Err((line, text)) => return check.wrong(line, &text),
    };
    check.required("findings", &case.findings);
    let (Some(one), Some(many)) = (case.work(|options| options.threads = 1), case.work(|options| options.threads = 0))
    else {
        return;
    };
    let done = match one.run(None) {
        Ok(done) => done,
        Err(error) => {
            let reasons: String = error.findings.iter().map(|finding| format!("{}\n", finding.text)).collect();
            return check.required("refused", &reasons);
        }
    };
    check.required("refused", "");
    let (Ok(out_of_step), Ok((results, _, files))) = (many.run(Some(jitter)), many.results(None)) else {
        return check.wrong(example.line, "the job starts with one thread and is refused with more");
    };
    if done.events != out_of_step.events {
        check.wrong(example.line, "the log depends on scheduling");
    }
    if done.files != out_of_step.files || done.files != files {
        check.wrong(example.line, "the files depend on scheduling, or on the log");
    }
    if done.summary != results.summary {
        check.wrong(example.line, "results without a log differ");
    }
    observe::check(example, &case, &done, check);
    judge(example, &case, &done, check);
    compare(example, &case, &done, check);
}

/// A program that runs without an error is not refused when it is judged without a run. Waits may depend on macros of
/// the machine, which are not executed then.
fn judge(example: &Example, case: &Case, done: &Done, check: &mut Check<'_>) {
    const ERROR: u8 = 8;
    if done.summary.state != JobOutcome::Succeeded || done.summary.highest_severity >= ERROR {
        return;
    }
    let judged = case.work(|options| options.lint = true).and_then(|work| work.run(None).ok());
    let macros = case.machine.as_ref().is_some_and(|machine| machine.macros.is_some());
    let unsure = |judged: &Done| macros && judged.summary.verdict.is_some();
    let refused = judged.filter(|judged| judged.summary.state == JobOutcome::Failed && !unsure(judged));
    let Some(judged) = refused else { return };
    let texts: String = judged.summary.diagnostics.iter().map(|found| format!("{}\n", found.text)).collect();
    check.wrong(example.line, &format!("the program runs, and lint refuses it:\n{texts}"));
}

/// A pause before every tenth shared operation for a while, so that thousands of them do not take long.
fn jitter(channel: u16) {
    static TURN: AtomicU64 = AtomicU64::new(0);
    let turn = TURN.fetch_add(1, Ordering::Relaxed);
    if turn.is_multiple_of(10) && turn < 10_000 {
        std::thread::sleep(Duration::from_micros(u64::from(channel % 3) * 50));
    }
}

fn compare(example: &Example, case: &Case, done: &Done, check: &mut Check<'_>) {
    let info = &done.info;
    diagnostics(example, case, done, check);
    let (mut events, mut timed) = (String::new(), String::new());
    for event in &done.events {
        if let Some(text) = outcome::event(info, event) {
            let _ = writeln!(events, "{text}");
            let _ = writeln!(timed, "{} {text}", (event.t_ns + event.dur_ns) as f64 / 1e9);
        }
    }
    check.given("events", || events);
    check.given("timed", || timed);
    check.given("texts", || outcome::texts(done));
    check.given("ran", || outcome::ran(done));
    for fence in &example.fences {
        let channel = fence.words.parse().unwrap_or(1);
        match fence.kind.as_str() {
            "written" => {
                let file = done.files.iter().find(|(path, _)| *path == fence.words);
                check.outcome(fence, file.map_or("no such file\n", |(_, text)| text));
            }
            kind @ ("trace" | "listing" | "log" | "merged" | "console") => {
                check.outcome(fence, &outcome::listing(kind, channel, info, done));
            }
            "shows" => {
                let found = outcome::listing("listing", channel, info, done);
                if !format!("\n{found}").contains(&format!("\n{}", fence.body.text)) {
                    check.wrong(fence.line, &format!("the listing does not show these lines:\n{found}"));
                }
            }
            _ => {}
        }
    }
}

/// Diagnostics: beside the line of the fence they are about, in a fence `diagnostics` when their line is nowhere here.
fn diagnostics(example: &Example, case: &Case, done: &Done, check: &mut Check<'_>) {
    let mut beside: Vec<BTreeMap<u32, Vec<String>>> = vec![BTreeMap::new(); example.fences.len()];
    let mut elsewhere = Vec::new();
    for event in &done.events {
        let Kind::Diagnostic(diagnostic) = &event.kind else { continue };
        let file = done.info.files.get(usize::from(event.file)).map_or("", |file| file.name.as_str());
        let fence = case.fences.iter().find(|(name, _)| name == file).map(|(_, at)| *at);
        let lines = fence.and_then(|at| example.fences.get(at)).map_or(0, |fence| fence.body.text.lines().count());
        match fence.and_then(|at| beside.get_mut(at)).filter(|_| (1..=lines).contains(&(event.line as usize))) {
            Some(marks) => marks.entry(event.line).or_default().push(named(diagnostic)),
            None if event.line == 0 => elsewhere.push(named(diagnostic)),
            None => elsewhere.push(format!("{} at {file}:{}", named(diagnostic), event.line)),
        }
    }
    for (fence, mut marks) in example.fences.iter().zip(beside) {
        if matches!(fence.kind.as_str(), "nc" | "file") {
            marks.values_mut().for_each(|marks| *marks = counted(marks));
            check.marks(fence, marks);
        }
    }
    let elsewhere: String = counted(&elsewhere).iter().map(|one| format!("{one}\n")).collect();
    check.required("diagnostics", &elsewhere);
}

/// Severity and word, or number where there is no word.
fn named(diagnostic: &Diagnostic) -> String {
    let severity = severity_name(diagnostic.severity);
    match diag::name(diagnostic.number) {
        Some(name) => format!("{severity} {name}"),
        None => format!("{severity} {:08}", diagnostic.number),
    }
}
