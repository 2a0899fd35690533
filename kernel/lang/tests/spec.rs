//! Runs the language guide: every `macro` block of `tests/spec/lang/*.md` with the blocks that follow it.
//!
//! `output` holds what the macro prints, `commands` what it asks of the control, `diagnostics` one line `number line` for
//! each diagnostic of the checker or of the run, `messages` their full text, `trace` the trace, `standard` and `c` the macro in a style. A block that
//! is not given must be empty (`messages`, `trace`, `standard` and `c` are only compared where they are given).

use counterpoint_lang::compile::{self, Options, Program, Strong};
use counterpoint_lang::host::Test;
use counterpoint_lang::source::Source;
use counterpoint_lang::tools::{self, Style};
use counterpoint_lang::vm::{self, Limits, State};
use std::collections::BTreeMap;
use std::fmt::Write as _;

struct Example {
    line: usize,
    options: String,
    text: String,
    expected: BTreeMap<String, String>,
}

fn examples(page: &str) -> Vec<Example> {
    let mut examples: Vec<Example> = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(kind) = line.strip_prefix("```").map(str::trim) else { continue };
        let mut text = String::new();
        for (_, line) in lines.by_ref() {
            if line.trim_end() == "```" {
                break;
            }
            text.push_str(line);
            text.push('\n');
        }
        match kind.split_once(' ').unwrap_or((kind, "")) {
            ("macro", options) => examples.push(Example {
                line: number + 1,
                options: options.to_owned(),
                text,
                expected: BTreeMap::new(),
            }),
            ("", _) => {}
            (kind, _) => {
                if let Some(example) = examples.last_mut() {
                    example.expected.insert(kind.to_owned(), text);
                }
            }
        }
    }
    examples
}

fn run(example: &Example) -> BTreeMap<&'static str, String> {
    let strong = if example.options.contains("full") { Strong::Full } else { Strong::Off };
    let trace = example.expected.contains_key("trace");
    let options = Options { uninitialised: true, trace, strong, ..Options::default() };
    let (mut program, mut host) = (Program::new(), Test::new());
    let added = compile::add(&mut program, &mut host, Source::new("page", example.text.as_str()), options);
    let mut diagnostics = added.diagnostics.clone();
    if !added.has_errors() {
        let limits = Limits { ticks: 1_000_000, ..Limits::default() };
        let mut state = State::new(limits);
        for index in &added.macros {
            vm::run(&program, &mut state, &mut host, *index, &mut []);
        }
        vm::close_all(&mut state, &mut host);
    }
    diagnostics.append(&mut host.diagnostics);
    let (mut shown, mut messages) = (String::new(), String::new());
    for diagnostic in diagnostics {
        let _ = writeln!(messages, "{diagnostic}");
        let _ = writeln!(shown, "{} {}", diagnostic.number, diagnostic.line);
    }
    let joined = |lines: &[String]| lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    let styled = |style| tools::format(&example.text, style).unwrap_or_default();
    BTreeMap::from([
        ("output", joined(&host.printed)),
        ("commands", joined(&host.commands)),
        ("diagnostics", shown),
        ("messages", messages),
        ("trace", joined(&host.traced)),
        ("standard", styled(Style::Standard)),
        ("c", styled(Style::C)),
    ])
}

#[test]
fn the_guide_is_true() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/spec/lang");
    let mut pages: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    pages.sort();
    let (mut count, mut failures) = (0, String::new());
    for path in pages.iter().filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
        for example in examples(&std::fs::read_to_string(path).unwrap()) {
            count += 1;
            for (kind, found) in run(&example) {
                let optional = matches!(kind, "trace" | "standard" | "c" | "messages")
                    || (kind == "diagnostics" && example.expected.contains_key("messages"));
                let wanted = match example.expected.get(kind) {
                    Some(wanted) => wanted.as_str(),
                    None if optional => continue,
                    None => "",
                };
                if wanted != found {
                    let place = format!("{}:{}", path.file_name().unwrap().to_string_lossy(), example.line);
                    let _ = writeln!(failures, "--- {place} {kind}\nwanted:\n{wanted}found:\n{found}");
                }
            }
        }
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(count > 50, "only {count} examples");
}

#[test]
fn formatting_is_stable_and_keeps_the_meaning() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/spec/lang");
    for entry in std::fs::read_dir(folder).unwrap() {
        for example in examples(&std::fs::read_to_string(entry.unwrap().path()).unwrap()) {
            for style in [Style::Standard, Style::C] {
                let Ok(once) = tools::format(&example.text, style) else { continue };
                assert_eq!(tools::format(&once, style).unwrap(), once);
                let lines = once.lines().count() == example.text.lines().count();
                let again = Example { text: once, ..example_of(&example) };
                let (before, after) = (run(&example), run(&again));
                assert_eq!(before.get("output"), after.get("output"), "{}", example.text);
                assert_eq!(before.get("commands"), after.get("commands"));
                if lines {
                    assert_eq!(before.get("diagnostics"), after.get("diagnostics"), "{}", example.text);
                }
            }
        }
    }
}

fn example_of(example: &Example) -> Example {
    Example { line: example.line, options: example.options.clone(), text: String::new(), expected: BTreeMap::new() }
}
