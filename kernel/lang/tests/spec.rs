//! Runs the language guide: every `macro` block of `tests/spec/lang/*.md` with the blocks that follow it.
//!
//! What comes out: `output` holds what the macro prints, `commands` what it asks of the control, `diagnostics` one line
//! `number line` for each diagnostic of the checker or of the run, `messages` their full text, `trace` the trace,
//! `standard` and `c` the macro in a style. A block that is not given must be empty (`messages`, `trace`, `standard` and
//! `c` are only compared where they are given). What goes in: `file NAME` is a file, `program` the NC program, `console`
//! lines of the console, `dialogs` answers (`name: button, %G01=value`), `settings` lines `name=value`, `macros` lines
//! `id name`, `block` identifiers with values. Words behind `macro`: `partial`, `full` (strong declaration),
//! `declaration`, `data`, `startup` (kind of macro), `channel=2` (the second of two channels).

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use counterpoint_lang::compile::{self, Options, Place, Program, Strong};
use counterpoint_lang::func;
use counterpoint_lang::host::{Answer, Domain, SystemVariable, Test};
use counterpoint_lang::parse;
use counterpoint_lang::source::Source;
use counterpoint_lang::tools::{self, Style};
use counterpoint_lang::value::{Kind, Value};
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
            (_, _) => {
                if let Some(example) = examples.last_mut() {
                    example.expected.insert(kind.to_owned(), text);
                }
            }
        }
    }
    examples
}

fn options(example: &Example) -> Options {
    let mut options =
        Options { uninitialised: true, trace: example.expected.contains_key("trace"), ..Options::default() };
    for word in example.options.split_whitespace() {
        match word {
            "partial" => options.strong = Strong::Partial,
            "full" => options.strong = Strong::Full,
            "declaration" => options.place = Place::Declaration,
            "data" => options.place = Place::Data,
            "startup" => options.place = Place::Startup,
            "channel=2" => {}
            _ => panic!("line {}: no option {word}", example.line),
        }
    }
    options
}

/// The double with everything a block gives it.
fn host(example: &Example) -> Test {
    let mut host = Test::new();
    host.variable("$TAPEN", Some(Kind::Text), false);
    let table = SystemVariable { name: "$TLTAB".to_owned(), kind: None, writable: true, indices: 2 };
    let domain = Domain { indices: vec![Some(9), Some(20)], ..Domain::default() };
    host.system_variable(table, Value::Null, domain);
    host.set_system("$TAPEN", Value::text("jobs/flange.nc"));
    host.group("CODE_RAPID", 1);
    host.group("CODE_INTERP_LINEAR", 1);
    for (kind, text) in &example.expected {
        let lines = text.lines();
        match kind.as_str() {
            "program" => host.program = lines.map(str::to_owned).collect(),
            "console" => host.typed = lines.map(str::to_owned).collect(),
            "settings" => {
                let pairs = lines.filter_map(|line| line.split_once('='));
                host.settings = pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
            }
            "variables" => {
                let pairs = lines.filter_map(|line| line.split_once('='));
                host.nc_variables = pairs.map(|(name, value)| (name.to_owned(), number_or_text(value))).collect();
            }
            "macros" => lines
                .filter_map(|line| line.split_once(' '))
                .for_each(|(id, name)| host.add_macro(id.parse().unwrap(), name)),
            "block" => lines
                .filter_map(|line| line.split_once(' '))
                .for_each(|(name, value)| host.put_on_block(name, value.parse().unwrap())),
            "dialogs" => lines.for_each(|line| {
                let (name, rest) = line.split_once(": ").unwrap();
                let mut parts = rest.split(", ");
                let button = parts.next().unwrap_or("OK").to_owned();
                let values = parts.filter_map(|part| part.split_once('='));
                let values = values.map(|(name, value)| (name.to_owned(), number_or_text(value))).collect();
                host.answer(name, Answer { button, values });
            }),
            kind => {
                if let Some(name) = kind.strip_prefix("file ") {
                    host.files.insert(name.to_owned(), text.clone());
                }
            }
        }
    }
    host
}

fn number_or_text(text: &str) -> Value {
    text.parse().map_or_else(|_| Value::text(text), Value::Real)
}

fn run(example: &Example) -> BTreeMap<&'static str, String> {
    let options = options(example);
    let (mut program, mut host) = (Program::new(), host(example));
    let added = compile::add(&mut program, &mut host, Source::new("page", example.text.as_str()), options);
    let mut diagnostics = added.diagnostics.clone();
    if !added.has_errors() {
        let limits = Limits { ticks: 1_000_000, ..Limits::default() };
        let mut state = State::new(limits);
        if example.options.contains("channel=2") {
            (state.channel, state.channels) = (2, 2);
        }
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
    let expected = example.expected.clone();
    Example { line: example.line, options: example.options.clone(), text: String::new(), expected }
}

/// Codes of string formats: every letter of output and input formats, the characters of numbers, the registers.
const FORMATS: &str = "!! ^^ ^ !(* !(A !(a !(M !(m !(R !(r !(L !(l !(T !(t !(X1) !(s5) !(2.9) !(s34) !(34s) !(s9f9s) !(e !(+ \
                       !(F !(V !(s9:2) !(e3:2:2) !(@X) !(#X) !(@1 !(#1 !@X !#X";

/// Operators in both spellings, and what else expressions are made of.
const SIGNS: &str = "** * / + - // .EQ. == .NE. != .GT. > .LT. < .GE. >= .LE. <= .NOT. ! .AND. && .OR. || .XOR. ^^ \
                     += -= *= /= { %L0 %G %ON $P # CODE_ REG_ DATA_ (2:) (:2) THRU OTHERS $NULL $PI $TRUE $FALSE .TRUE. .FALSE.";

/// Words of statements: those a statement begins with, and their variants.
const VARIANTS: &str = "ENDOF/IF ENDOF/CASE ENDOF/WHILE ENDOF/DO ENDIF ENDCASE ENDWHILE ENDDO LEAVE EXIT/2 MATCH/ON MATCH/OFF \
    EXEC/NOW EXEC/NEXT LPRINT/ON LPRINT/OFF LPRINT/2 FRONT REAR STDIN STDOUT INCR DECR DECLAR/GLOBAL DECLAR/OBJECT \
    DECLAR/LOCAL CHANNEL REAL LOGICAL STRING SEQUENCE KEYWORD RECORD CODE REG $ERRNO $MNEST $CI $CHSIZ $CHMAX LET FOR EXTERN";

/// What regular expressions are made of.
const EXPRESSIONS: &str = r"\. [A-Z] [^0-9] '^a $' * \{2\} \{3,\} \{1,3\} \( \) \1 \< \>";

/// Codes of dates.
const DATES: &str = "%a %A %b %B %c %d %H %I %j %m %M %p %S %s %U %w %W %x %X %y %Y %z %Z %% %#d %#c %#x";

#[test]
fn every_function_statement_operator_and_format_has_a_block() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/spec/lang");
    let mut text = String::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        for example in examples(&std::fs::read_to_string(entry.unwrap().path()).unwrap()) {
            // Only what has an outcome counts.
            let outcomes = ["output", "commands", "diagnostics", "messages", "trace"];
            if outcomes.iter().any(|kind| example.expected.get(*kind).is_some_and(|text| !text.is_empty())) {
                text.push_str(&example.text);
            }
        }
    }
    let upper = text.to_uppercase();
    let mut missing: Vec<String> = Vec::new();
    let mut want = |there: bool, name: &str| {
        if !there {
            missing.push(name.to_owned())
        }
    };
    func::all().for_each(|function| want(text.contains(&format!("{}(", function.name)), function.name));
    for command in parse::COMMANDS {
        let begins = |line: &str| line.rsplit(": ").next().is_some_and(|line| line.split('/').next() == Some(command));
        want(upper.lines().any(|line| begins(line.trim())), command);
    }
    [FORMATS, SIGNS, EXPRESSIONS, DATES]
        .iter()
        .flat_map(|list| list.split_whitespace())
        .for_each(|name| want(text.contains(name), name));
    VARIANTS.split_whitespace().for_each(|name| want(upper.contains(name), name));
    assert!(missing.is_empty(), "no block of the guide shows {missing:?}");
}
