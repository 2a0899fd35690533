//! Pages of tests/spec/tables: prose, a small machine, programs, and what comes out.
//!
//! Fences of a page: `toml` is the machine (over `fanuc-mill` unless it says `extends`, and going on after unknown text
//! unless it has a section `[control]`), `file NAME` a further file of
//! the machine's folder, `nc` or `nc NAME` a program (the first one runs), `options` keys of a job's options, `trace`
//! the whole trace of channel 1, `diagnostics` the numbers, severities and texts in order, `findings` what the check of
//! the machine says, `refused` why the job does not start. A page may hold several cases, each begins with a heading.

use std::path::Path;
use std::sync::Arc;

use counterpoint_kernel::control::Control;
use counterpoint_kernel::files::Memory;
use counterpoint_kernel::job::{Job, Program, Sink, Spec};
use counterpoint_kernel::log::event::{Event, Kind};
use counterpoint_kernel::log::listing;
use counterpoint_kernel::machine::load;
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::options::Options;

/// Text that nothing knows is told, so that pages can show what is left.
const CONTROL: &str = "\n[control]\nunknown_code = \"warn\"\n";

#[derive(Default)]
struct Case {
    name: String,
    machine: Memory,
    has_machine: bool,
    programs: Vec<(String, String)>,
    options: String,
    trace: Option<String>,
    diagnostics: Option<String>,
    findings: Option<String>,
    refused: Option<String>,
}

fn cases(page: &str) -> Vec<Case> {
    let mut cases = vec![Case::default()];
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("## ") {
            cases.push(Case { name: name.to_owned(), ..Case::default() });
        }
        let Some(fence) = line.strip_prefix("```") else { continue };
        let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        let body = format!("{}\n", body.join("\n"));
        let body = if body == "\n" { String::new() } else { body };
        let case = cases.last_mut().unwrap();
        let (kind, name) = fence.split_once(' ').unwrap_or((fence, ""));
        match kind {
            "toml" => {
                let head = if body.contains("extends") { "" } else { "extends = \"fanuc-mill\"\n" };
                let named = if body.contains("[ce]") { "" } else { "\n[ce]\nname = \"spec\"\n" };
                let control = if body.contains("[control") { "" } else { CONTROL };
                case.machine.insert("spec/machine.toml", format!("{head}{body}{named}{control}"));
                case.has_machine = true;
            }
            "file" => case.machine.insert(format!("spec/{name}"), body),
            "nc" => {
                let name = if name.is_empty() { "part.nc" } else { name };
                case.programs.push((name.to_owned(), body));
            }
            "options" => case.options = body,
            "trace" => case.trace = Some(body),
            "diagnostics" => case.diagnostics = Some(body),
            "findings" => case.findings = Some(body),
            "refused" => case.refused = Some(body),
            "text" => {}
            other => panic!("unknown fence {other}"),
        }
    }
    cases.retain(|case| case.has_machine || !case.programs.is_empty());
    for case in cases.iter_mut().filter(|case| !case.has_machine) {
        let text = format!("extends = \"fanuc-mill\"\n\n[ce]\nname = \"spec\"\n{CONTROL}");
        case.machine.insert("spec/machine.toml", text);
    }
    cases
}

struct Collect(Vec<Event>);

impl Sink for Collect {
    fn events(&mut self, _: u64, batch: &[Event]) -> bool {
        self.0.extend_from_slice(batch);
        true
    }
}

fn check(page: &str, case: &Case) {
    let place = format!("{page}: {}", case.name);
    let loaded = load(&Overlay::new(case.machine.clone(), shipped()), "spec");
    let found: String = loaded.findings.iter().map(|finding| format!("{finding}\n")).collect();
    assert_eq!(found, case.findings.clone().unwrap_or_default(), "{place}: findings");
    let Some((first, _)) = case.programs.first() else { return };
    let machine = Arc::new(loaded.machine.unwrap_or_else(|| panic!("{place}: no machine")));
    let mut files = Memory::default();
    case.programs.iter().for_each(|(name, text)| files.insert(name.clone(), text));
    let options: Options = toml::from_str(&case.options).unwrap_or_else(|error| panic!("{place}: {error}"));
    let programs = vec![Program { file: first.clone(), number: None, channel: None }];
    let job = match Job::prepare(Spec { machine: machine.clone(), programs, options }, &files) {
        Ok(job) => job,
        Err(error) => {
            let reasons: String = error.findings.iter().map(|finding| format!("{}\n", finding.text)).collect();
            assert_eq!(reasons, case.refused.clone().unwrap_or_default(), "{place}: refused");
            return;
        }
    };
    assert_eq!(case.refused, None, "{place}: the job starts");
    let mut sink = Collect(Vec::new());
    job.run(&files, &Control::new(machine.channels.len()), &mut sink);
    let diagnostics: String = sink.0.iter().filter_map(diagnostic).collect();
    if let Some(expected) = &case.diagnostics {
        assert_eq!(&diagnostics, expected, "{place}: diagnostics");
    }
    if let Some(expected) = &case.trace {
        let mut out = Vec::new();
        let mut events = sink.0.iter().enumerate().map(|(seq, event)| (seq as u64 + 1, event.clone()));
        listing::render_trace(job.info(), 1, &mut events, &mut out).unwrap();
        let trace = String::from_utf8(out).unwrap();
        assert_eq!(&trace, expected, "{place}: trace\n{trace}");
    }
}

fn diagnostic(event: &Event) -> Option<String> {
    match &event.kind {
        Kind::Diagnostic(d) => Some(format!("line {}: {:08} {} {}\n", event.line, d.number, d.severity, d.text)),
        _ => None,
    }
}

#[test]
fn pages() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("spec/tables");
    let mut paths: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty());
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let cases = cases(&std::fs::read_to_string(&path).unwrap());
        assert!(!cases.is_empty(), "{name} has no case");
        cases.iter().for_each(|case| check(&name, case));
    }
}
