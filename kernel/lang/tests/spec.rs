//! The pages of `tests/spec/lang`: behaviour of macros. One test per example; `tests/spec/README.md` describes the
//! fences.
//!
//! Beside them: formatting keeps the meaning of every example, and everything that the language has is in one.

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, reason = "helpers of tests")]

use counterpoint_lang::compile::{self, CompileOptions, DeclarationStrictness, MacroProgram, MacroRole};
use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang::func;
use counterpoint_lang::host::SystemVariable;
use counterpoint_lang::layout::{self, SourceStyle};
use counterpoint_lang::parse;
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::value::{MacroValue, ValueType};
use counterpoint_lang::vm::{self, MacroLimits, MacroState};
use counterpoint_lang_standalone::{Domain, PreparedAnswer, Standalone};
use counterpoint_mdspec::{Check, Example, Fences, Role, Suite, counted, severity_name};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

const FENCES: Fences = &[
    ("macro", Role::Program),
    ("file", Role::Input),
    ("program", Role::Input),
    ("console", Role::Input),
    ("dialogs", Role::Input),
    ("settings", Role::Input),
    ("variables", Role::Input),
    ("macros", Role::Input),
    ("block", Role::Input),
    ("output", Role::Outcome),
    ("commands", Role::Outcome),
    ("diagnostics", Role::Outcome),
    ("messages", Role::Outcome),
    ("trace", Role::Outcome),
    ("standard", Role::Outcome),
    ("c", Role::Outcome),
];

fn words(example: &Example) -> &str {
    example.fence("macro").map_or("", |fence| &fence.words)
}

fn options(example: &Example) -> CompileOptions {
    let mut options =
        CompileOptions { uninitialised: true, trace: example.fence("trace").is_some(), ..CompileOptions::default() };
    for word in words(example).split_whitespace() {
        match word {
            "partial" => options.strong = DeclarationStrictness::Partial,
            "full" => options.strong = DeclarationStrictness::Full,
            "declaration" => options.place = MacroRole::Declaration,
            "data" => options.place = MacroRole::Data,
            "startup" => options.place = MacroRole::Startup,
            "channel=2" => {}
            _ => panic!("line {}: '{word}' after 'macro' means nothing", example.line),
        }
    }
    options
}

/// The double with everything a block gives it.
fn host(example: &Example) -> Standalone {
    let mut host = Standalone::new();
    host.variable("$TAPEN", Some(ValueType::Text), false);
    let table = SystemVariable { name: "$TLTAB".to_owned(), kind: None, writable: true, indices: 2 };
    let domain = Domain { indices: vec![Some(9), Some(20)], ..Domain::default() };
    host.system_variable(table, MacroValue::Null, domain);
    host.set_system("$TAPEN", MacroValue::text("jobs/flange.nc"));
    host.group("CODE_RAPID", 1);
    host.group("CODE_INTERP_LINEAR", 1);
    for fence in &example.fences {
        let text = &fence.body.text;
        let lines = text.lines();
        match fence.kind.as_str() {
            "program" => host.program.blocks = lines.map(str::to_owned).collect(),
            "console" => host.typed = lines.map(str::to_owned).collect(),
            "settings" => {
                let pairs = lines.filter_map(|line| line.split_once('='));
                host.settings = pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
            }
            "variables" => {
                let pairs = lines.filter_map(|line| line.split_once('='));
                host.program.variables = pairs.map(|(name, value)| (name.to_owned(), number_or_text(value))).collect();
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
                host.answer(name, PreparedAnswer { button, values });
            }),
            "file" => drop(host.disk.files.insert(fence.words.clone(), text.clone())),
            _ => {}
        }
    }
    host
}

fn number_or_text(text: &str) -> MacroValue {
    text.parse().map_or_else(|_| MacroValue::text(text), MacroValue::Real)
}

/// The output of a macro.
struct Found {
    /// By kind of fence.
    texts: BTreeMap<&'static str, String>,
    diagnostics: Vec<MacroDiagnostic>,
}

/// Runs the text with everything that the example gives it.
fn run(example: &Example, text: &str) -> Found {
    let options = options(example);
    let (mut program, mut host) = (MacroProgram::new(), host(example));
    let added = compile::add(&mut program, &mut host, MacroSource::new("page", text), options);
    let mut diagnostics = added.diagnostics.clone();
    if !added.has_errors() {
        let limits = MacroLimits { ticks: 1_000_000, ..MacroLimits::default() };
        let mut state = MacroState::new(limits);
        if words(example).contains("channel=2") {
            (state.channel, state.channels) = (2, 2);
        }
        for index in &added.macros {
            vm::run(&program, &mut state, &mut host, *index, &mut []);
        }
        vm::close_all(&mut state, &mut host);
    }
    diagnostics.append(&mut host.output.diagnostics);
    let messages = diagnostics.iter().fold(String::new(), |mut text, diagnostic| {
        let _ = writeln!(text, "{diagnostic}");
        text
    });
    let joined = |lines: &[String]| lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    let styled = |style| layout::format(text, style).unwrap_or_default();
    let texts = BTreeMap::from([
        ("output", joined(&host.output.printed)),
        ("commands", joined(&host.output.commands)),
        ("messages", messages),
        ("trace", joined(&host.output.traced)),
        ("standard", styled(SourceStyle::Standard)),
        ("c", styled(SourceStyle::C)),
    ]);
    Found { texts, diagnostics }
}

fn check(example: &Example, check: &mut Check<'_>) {
    let Some(fence) = example.fence("macro") else { return };
    let found = run(example, &fence.body.text);
    let (mut beside, mut elsewhere) = (BTreeMap::<u32, Vec<String>>::new(), Vec::new());
    for diagnostic in &found.diagnostics {
        let severity = severity_name(diagnostic.severity);
        let name = diagnostic.number.name().map_or_else(|| diagnostic.number.to_string(), str::to_owned);
        let here =
            diagnostic.file == "page" && (1..=fence.body.text.lines().count()).contains(&(diagnostic.line as usize));
        match here {
            true => beside.entry(diagnostic.line).or_default().push(format!("{severity} {name}")),
            false => elsewhere.push(format!("{severity} {name} at {}:{}", diagnostic.file, diagnostic.line)),
        }
    }
    beside.values_mut().for_each(|marks| *marks = counted(marks));
    check.marks(fence, beside);
    check.required("diagnostics", &counted(&elsewhere).iter().map(|one| format!("{one}\n")).collect::<String>());
    for (kind, text) in &found.texts {
        match *kind {
            "output" | "commands" => check.required(kind, text),
            _ => check.given(kind, || text.clone()),
        }
    }
}

/// Both styles are stable, and the effect of the macro stays the same.
fn formatted(example: &Example) -> Result<(), String> {
    let text = example.text("macro");
    for style in [SourceStyle::Standard, SourceStyle::C] {
        let Ok(once) = layout::format(text, style) else { continue };
        let twice = layout::format(&once, style).unwrap_or_default();
        let (before, after) = (run(example, text), run(example, &once));
        let places = |found: &Found| found.diagnostics.iter().map(|d| (d.number, d.line)).collect::<Vec<_>>();
        let same_lines = once.lines().count() == text.lines().count();
        let same = |kind| before.texts.get(kind) == after.texts.get(kind);
        if twice != once || !same("output") || !same("commands") || (same_lines && places(&before) != places(&after)) {
            return Err(format!("{}, line {}: {style:?} changes the macro:\n{once}", example.name, example.line));
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/spec/lang");
    let mut suite = Suite::of(&folder, FENCES, check);
    let examples: Vec<Example> = suite.pages().iter().flat_map(|page| page.examples.clone()).collect();
    for example in examples.clone() {
        suite.test(&format!("formatting::{}", example.name), move || formatted(&example));
    }
    suite.test("everything_has_an_example", move || everything_has_an_example(&examples));
    suite.run()
}

/// Codes of string formats: every letter of output and input formats, the characters of numbers, the registers.
const FORMATS: &str = "!! ^^ ^ !(* !(A !(a !(M !(m !(R !(r !(L !(l !(T !(t !(X1) !(s5) !(2.9) !(s34) !(34s) !(s9f9s) !(e !(+ \
                       !(F !(V !(s9:2) !(e3:2:2) !(@X) !(#X) !(@1 !(#1 !@X !#X";

/// Operators in both spellings, and the other parts of expressions.
const SIGNS: &str = "** * / + - // .EQ. == .NE. != .GT. > .LT. < .GE. >= .LE. <= .NOT. ! .AND. && .OR. || .XOR. ^^ \
                     += -= *= /= { %L0 %G %ON $P # CODE_ REG_ DATA_ (2:) (:2) THRU OTHERS $NULL $PI $TRUE $FALSE .TRUE. .FALSE.";

/// Words of statements: those a statement begins with, and their variants.
const VARIANTS: &str = "ENDOF/IF ENDOF/CASE ENDOF/WHILE ENDOF/DO ENDIF ENDCASE ENDWHILE ENDDO LEAVE EXIT/2 MATCH/ON MATCH/OFF \
    EXEC/NOW EXEC/NEXT LPRINT/ON LPRINT/OFF LPRINT/2 FRONT REAR STDIN STDOUT INCR DECR DECLAR/GLOBAL DECLAR/OBJECT \
    DECLAR/LOCAL CHANNEL REAL LOGICAL STRING SEQUENCE KEYWORD RECORD CODE REG $ERRNO $MNEST $CI $CHSIZ $CHMAX LET FOR EXTERN";

/// The elements of regular expressions.
const EXPRESSIONS: &str = r"\. [A-Z] [^0-9] '^a $' * \{2\} \{3,\} \{1,3\} \( \) \1 \< \>";

/// Codes of dates.
const DATES: &str = "%a %A %b %B %c %d %H %I %j %m %M %p %S %s %U %w %W %x %X %y %Y %z %Z %% %#d %#c %#x";

/// Functions, statements, operators and formats, in an example that has an outcome.
fn everything_has_an_example(examples: &[Example]) -> Result<(), String> {
    let outcomes = ["output", "commands", "diagnostics", "messages", "trace"];
    let shows = |example: &&Example| {
        let marked = example.fence("macro").is_some_and(|fence| !fence.body.marks.is_empty());
        marked || outcomes.iter().any(|kind| !example.text(kind).is_empty())
    };
    let text: String = examples.iter().filter(shows).map(|example| example.text("macro")).collect();
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
    if missing.is_empty() { Ok(()) } else { Err(format!("no example shows {missing:?}")) }
}
