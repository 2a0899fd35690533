//! Runs the emulator guide: every page of `tests/spec/emulator`.
//!
//! An example begins with a `toml` block, the machine, and goes up to the next one. `macro NAME` is a file of the
//! machine's folder, `nc` a program (one for each channel from the left), `file NAME` another file of the job,
//! `options` options of the job as TOML. What comes out: `events` all events but blocks and lifecycles, one line each
//! (with the channel in front on machines with several), `timed` the same with the second of their end in front,
//! `diagnostics` one line `number line` for each diagnostic, `texts` their texts, each with the line of the macro that raised it, `trace` the whole trace of channel
//! 1, `listing` its whole listing and `shows` lines of it one behind the other (`listing N`, `shows N` of another
//! channel, `log` the log file of channel 1, `merged` the listing and `console` the console of all; VERSION stands for that of this project), `ran`
//! the program of each channel in the summary, `written NAME` a file that macros have written, `findings` what
//! loading the machine finds. `events`, `timed`, `texts`, `trace` and written files are only compared where they are given; no diagnostics and no findings are expected where none
//! are given. Every example is run with one thread, with results only, and with shared operations out of step; all
//! must agree.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::files::Memory;
use counterpoint_kernel::log::event::{Call, Dwell, Event, Function, Kind, Message, Motion, MotionKind, ToolChange};
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::listing;
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::Options;
use counterpoint_tests::{Done, Work};

#[derive(Default)]
struct Example {
    line: usize,
    machine: Memory,
    programs: Vec<String>,
    files: Vec<(String, String)>,
    options: Options,
    events: Option<String>,
    timed: Option<String>,
    texts: Option<String>,
    trace: Option<String>,
    /// Kind of listing, channel, text.
    listings: Vec<(String, u16, String)>,
    ran: Option<String>,
    written: Vec<(String, String)>,
    diagnostics: String,
    findings: String,
}

fn examples(page: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(kind) = line.strip_prefix("```").map(str::trim).filter(|kind| !kind.is_empty()) else { continue };
        let mut text = String::new();
        for (_, line) in lines.by_ref().take_while(|(_, line)| line.trim_end() != "```") {
            text.push_str(line);
            text.push('\n');
        }
        if kind == "toml" {
            examples.push(Example { line: number + 1, ..Example::default() });
        }
        let Some(example) = examples.last_mut() else { panic!("line {}: no machine before this", number + 1) };
        match kind.split_once(' ').unwrap_or((kind, "")) {
            ("toml", _) => example.machine.insert("example/machine.toml", text),
            ("macro", name) => example.machine.insert(format!("example/{name}"), text),
            ("nc", _) => example.programs.push(text),
            ("file", name) => example.files.push((name.to_owned(), text)),
            ("options", _) => example.options = toml::from_str(&text).expect("options"),
            ("events", _) => example.events = Some(text),
            ("timed", _) => example.timed = Some(text),
            ("texts", _) => example.texts = Some(text),
            ("trace", _) => example.trace = Some(text),
            ("listing" | "shows" | "log" | "merged" | "console", channel) => {
                example.listings.push((
                    kind.split(' ').next().unwrap_or_default().to_owned(),
                    channel.parse().unwrap_or(1),
                    text,
                ));
            }
            ("written", name) => example.written.push((name.to_owned(), text)),
            ("ran", _) => example.ran = Some(text),
            ("diagnostics", _) => example.diagnostics = text,
            ("findings", _) => example.findings = text,
            (other, _) => panic!("line {}: no block is called {other}", number + 1),
        }
    }
    examples
}

fn machine(example: &Example) -> (Option<Arc<Machine>>, String) {
    let loaded = load(&Overlay::new(example.machine.clone(), shipped()), "example");
    let mut findings = String::new();
    for finding in &loaded.findings {
        let _ = writeln!(findings, "{}", finding.to_string().trim_start_matches("example/"));
    }
    (loaded.machine.map(Arc::new), findings)
}

fn motion(info: &Info, event: &Event, motion: &Motion) -> String {
    let kind = match motion.kind {
        MotionKind::Rapid => "rapid",
        MotionKind::Linear => "linear",
        MotionKind::ArcCw => "arc cw",
        MotionKind::ArcCcw => "arc ccw",
        MotionKind::ArcSpace => "arc space",
        MotionKind::Thread => "thread",
    };
    let mut text = kind.to_owned();
    let axes = info.channel(event.channel).map_or(&[][..], |channel| &channel.axes);
    for (at, axis) in axes.iter().enumerate() {
        if motion.moving & 1 << at != 0 {
            let _ = write!(text, " {}{}", axis.name, (motion.to[at] * 1e6).round() / 1e6);
        }
    }
    if motion.feed != 0.0 {
        let _ = write!(text, " f={}", motion.feed);
    }
    text
}

fn event(info: &Info, event: &Event) -> Option<String> {
    let text = match &event.kind {
        Kind::Motion(m) => motion(info, event, m),
        Kind::Message(Message { text, .. }) => format!("message {text}"),
        Kind::Mode(mode) => format!("mode {mode}"),
        Kind::Tool(ToolChange { action, tool, .. }) => format!("tool {} {tool}", format!("{action:?}").to_lowercase()),
        Kind::Spindle(s) => {
            let of = if s.spindle > 1 { format!(" of {}", s.spindle) } else { String::new() };
            format!("spindle {} {}{of}", format!("{:?}", s.direction).to_lowercase(), s.speed)
        }
        Kind::Coolant(coolant) => coolant.to_string(),
        Kind::Function(Function { letter, value }) => format!("function {letter}{value}"),
        Kind::Call(Call { program, .. }) => format!("call {program}"),
        Kind::Return(_) => "return".to_owned(),
        Kind::Stop(stop) => format!("stop {}", format!("{stop:?}").to_lowercase()),
        Kind::Dwell(Dwell) => format!("dwell {}", event.dur_ns as f64 / 1e9),
        Kind::Wait(wait) => format!("wait {}", wait.key),
        Kind::Release(release) => format!("release {}", release.key),
        Kind::Verdict(verdict) => format!("verdict {:?}", verdict.kind).to_lowercase(),
        _ => return None,
    };
    Some(if info.channels.len() > 1 { format!("{}! {text}", event.channel) } else { text })
}

fn run(example: &Example, machine: &Arc<Machine>) -> (Done, Arc<Info>) {
    let work = |threads: u16| {
        let options = Options { threads, ..example.options.clone() };
        let mut work = Work::texts(Arc::clone(machine), &example.programs, options);
        for (name, text) in &example.files {
            work.files.insert(name.clone(), text);
        }
        work
    };
    // Every tenth time for a while, so that thousands of operations do not take for ever.
    let jitter = |channel: u16| {
        static TURN: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let turn = TURN.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        if turn.is_multiple_of(10) && turn < 10_000 {
            std::thread::sleep(std::time::Duration::from_micros(u64::from(channel % 3) * 50));
        }
    };
    let one = work(1).run(None).expect("the job can be prepared");
    let many = work(0).run(Some(jitter)).expect("the job can be prepared");
    assert_eq!(one.events, many.events, "line {}: the log depends on scheduling", example.line);
    let (results, _, files) = work(0).results(None).expect("the job can be prepared");
    assert_eq!((&one.files, &one.files), (&many.files, &files), "line {}: files differ", example.line);
    assert_eq!(one.summary, results.summary, "line {}: results without a log differ", example.line);
    let info = work(1).info();
    (one, info)
}

/// The trace of channel 1.
fn trace(info: &Info, done: &Done) -> String {
    let mut events = (1_u64..).zip(done.events.iter().cloned());
    let mut out = Vec::new();
    listing::render_trace(info, 1, &mut events, &mut out).expect("a trace");
    String::from_utf8(out).expect("text")
}

/// A listing of a kind.
fn listing_of(kind: &str, channel: u16, info: &Info, done: &Done) -> String {
    let mut events = (1_u64..).zip(done.events.iter().cloned());
    let mut out = Vec::new();
    let summary = &done.summary;
    match kind {
        "log" => listing::render_log(info, channel, summary, &mut events, &mut out),
        "console" => listing::render_console(0, &mut events, &mut out),
        "merged" => listing::render_merged(info, summary, &mut events, &mut out),
        _ => listing::render(info, channel, summary, &mut events, &mut out),
    }
    .expect("a listing");
    String::from_utf8(out).expect("text").replace(env!("CARGO_PKG_VERSION"), "VERSION")
}

#[test]
fn the_guide_is_true() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/spec/emulator");
    let mut pages: Vec<_> =
        std::fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("a page").path()).collect();
    pages.sort();
    let mut wrong = String::new();
    let mut count = 0;
    for page in pages {
        let text = std::fs::read_to_string(&page).expect("a page");
        let name = page.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for example in examples(&text) {
            count += 1;
            let mut compare = |what: &str, found: &str, expected: &str| {
                if found != expected {
                    let _ =
                        writeln!(wrong, "{name}:{} {what}\n--- found\n{found}--- expected\n{expected}", example.line);
                }
            };
            let (machine, findings) = machine(&example);
            compare("findings", &findings, &example.findings);
            let Some(machine) = machine.filter(|_| !example.programs.is_empty()) else { continue };
            let (done, info) = run(&example, &machine);
            let (mut events, mut timed) = (String::new(), String::new());
            let (mut diagnostics, mut texts) = (String::new(), String::new());
            for one in &done.events {
                if let Some(text) = event(&info, one) {
                    let _ = writeln!(events, "{text}");
                    let _ = writeln!(timed, "{} {text}", (one.t_ns + one.dur_ns) as f64 / 1e9);
                }
                if let Kind::Diagnostic(diagnostic) = &one.kind {
                    let _ = writeln!(diagnostics, "{:08} {}", diagnostic.number, one.line);
                    let _ = writeln!(texts, "{}", diagnostic.text);
                    if let Some(origin) = &diagnostic.origin {
                        let _ = writeln!(texts, "  MACRO({}) LINE({}): {}", origin.name, origin.line, origin.statement);
                    }
                }
            }
            compare("diagnostics", &diagnostics, &example.diagnostics);
            if let Some(expected) = &example.events {
                compare("events", &events, expected);
            }
            if let Some(expected) = &example.timed {
                compare("timed", &timed, expected);
            }
            if let Some(expected) = &example.texts {
                compare("texts", &texts, expected);
            }
            if let Some(expected) = &example.ran {
                let ran: String =
                    done.summary.channels.iter().map(|c| format!("{} {}\n", c.channel, c.program)).collect();
                compare("ran", &ran, expected);
            }
            for (name, expected) in &example.written {
                let found = done.files.iter().find(|(path, _)| path == name).map_or("no such file\n", |(_, text)| text);
                compare(&format!("written {name}"), found, expected);
            }
            if let Some(expected) = &example.trace {
                compare("trace", &trace(&info, &done), expected);
            }
            for (kind, channel, expected) in &example.listings {
                let found = listing_of(kind, *channel, &info, &done);
                let shown = kind == "shows" && format!("\n{found}").contains(&format!("\n{expected}"));
                compare(kind, if shown { expected } else { &found }, expected);
            }
        }
    }
    assert!(count > 0, "there are no examples");
    assert!(wrong.is_empty(), "{wrong}");
}
