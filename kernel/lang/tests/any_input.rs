//! Any input gives errors or a program, never a panic; formats and expressions come back as they went in.

use counterpoint_lang::bytecode::fast::Fast;
use counterpoint_lang::compile::{self, CompileOptions, MacroProgram};
use counterpoint_lang::diag::{DiagnosticNumber, MacroDiagnostic};
use counterpoint_lang::format::{StringFormat, read, wildcard_text, write};
use counterpoint_lang::layout::{self, SourceStyle};
use counterpoint_lang::pattern::TextPattern;
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{self, MacroEnd, MacroLimits, MacroState};
use counterpoint_lang_standalone::{Standalone, check};
use proptest::prelude::*;
use std::sync::Arc;

const PIECES: &[&str] = &[
    "IF/",
    "ELSEIF/",
    "ELSE",
    "ENDOF/IF",
    "ENDOF/DO",
    "ENDOF/CASE",
    "CASE/",
    "WHEN/",
    "OTHERS",
    "THRU",
    "WHILE/",
    "DO/",
    "REPEAT",
    "UNTIL/",
    "EXIT",
    "EXIT/2",
    "JUMPTO/A",
    "A:",
    "TERMAC",
    "ENDMAC",
    "MACRO/",
    "DECLAR/",
    "REAL",
    "STRING",
    "GLOBAL,",
    "CHANNEL,",
    "PPRINT/",
    "READ/",
    "WRITE/20,",
    "OPEN/20",
    "CLOSE/20",
    "ERROR/8,",
    "EXEC/",
    "OUTPUT",
    "A",
    "B",
    "C(",
    "F(",
    "%L01",
    "%G2",
    "$P1",
    "$PI",
    "$NULL",
    "$FSIN(",
    "$FMATCH(",
    "$FEDIT(",
    "$FVANG(",
    "$FMX(",
    "$FSWRIT(",
    "$FDATE(",
    "$FIF(",
    "{",
    "}",
    "(",
    ")",
    ",",
    ":",
    "=",
    "+=",
    "/=",
    "+",
    "-",
    "*",
    "/",
    "//",
    "**",
    "==",
    ".LT.",
    "!",
    "&&",
    ".OR.",
    "^^",
    "1",
    "0",
    "2.5",
    "99999999",
    "'!(*)'",
    "'x'",
    "''",
    "'\\(a*\\)*b'",
    "ON",
    "FLOOD",
    "#71",
    "#*:*",
    "CODE_RAPID",
    "REG_AXIS_X",
    "$\n",
    "$$ why",
    "\n",
    "\n",
    "\n",
    " ",
    "'",
    ".",
    "#",
    "$",
    "%",
    "?",
];

fn soup() -> impl Strategy<Value = String> {
    prop::collection::vec(prop::sample::select(PIECES), 0..60).prop_map(|pieces| pieces.concat())
}

/// Mostly valid programs over a few variables.
fn program() -> impl Strategy<Value = String> {
    let value = prop::sample::select(
        &[
            "A",
            "B",
            "C",
            "1",
            "-2.5",
            "'x'",
            "{1,2}",
            "$NULL",
            "ON",
            "A+B",
            "A//B",
            "C(1)",
            "A(1:2)",
            "$FLEN(A)",
            "{A,B}",
            "$FIF(A.EQ.B,1,2)",
            "$FSWRIT('!(*)',A)",
            "A.EQ.B",
            "A**B",
            "A/B",
            "G(B)",
            "$FVADD(C,C)",
            "O",
            "M(1,2)",
            "M(B,1)",
            "%G01",
            "D(1)",
            "A//'x'//O",
            ".NOT.(A.EQ.M(1,1))",
        ][..],
    );
    let name = prop::sample::select(&["A", "B", "C", "D(1)", "D(B)", "%G01", "O", "M(1,2)", "M(2,B)", "C(1)"][..]);
    let statement = prop_oneof![
        6 => (name, value.clone()).prop_map(|(name, value)| format!("{name}={value}")),
        2 => value.clone().prop_map(|value| format!("C+={value}")),
        1 => value.clone().prop_map(|value| format!("IF/{value}\nA=1\nELSE\nB=2\nENDOF/IF")),
        1 => value.clone().prop_map(|value| format!("DO/I=1,{value}\nC+=I\nENDOF/DO")),
        1 => value.clone().prop_map(|value| format!("CASE/{value}\nWHEN/1,THRU,5\nA=3\nWHEN/OTHERS\nB='y'\nENDOF/CASE")),
        2 => value.clone().prop_map(|value| format!("IF/M(1,2).EQ.{value}\nA=A//'x'\nELSEIF/O.NE.{value}\nM(2,1)={value}\nENDOF/IF")),
        1 => value.prop_map(|value| format!("WHILE/{value}\nA=A+'x'\nENDOF/WHILE")),
    ];
    prop::collection::vec(statement, 0..12).prop_map(|lines| {
        let mut text = String::from("MACRO/G(X)\nG=X\nX=1/X\nENDMAC\nDECLAR/D(3)\nDECLAR/M(2,2)\nDECLAR/OBJECT,O\n");
        text.push_str(&lines.join("\n"));
        text
    })
}

/// Loops over numbers, arrays and sequences, with values of other types in between.
fn numbers() -> impl Strategy<Value = String> {
    let name = prop::sample::select(
        &[
            "A", "B", "C", "D(1)", "D(I)", "D(A)", "Q(I)", "R", "Q", "$P1", "E(I,2)", "E(A,I)", "%G01", "OS", "OA(I)",
            "OM(2,I)", "GV",
        ][..],
    );
    let operand = prop::sample::select(
        &[
            "A", "B", "C", "I", "2", "0", "-.5", "H", "D(I)", "D(2)", "Q(1)", "R", "T", "G(I,A)", "E(I,2)", "E(2,I)",
            "%G01", "OS", "OA(I)", "OM(1,I)", "GV", "A**2", "$FABS(B)",
        ][..],
    );
    let sign = prop::sample::select(&["+", "-", "*", "/", "+", "-", "*"][..]);
    let value = (operand.clone(), sign.clone(), operand.clone(), sign, operand, any::<bool>());
    let value = value.prop_map(
        |(a, f, b, g, c, left)| {
            if left { format!("({a}{f}{b}){g}{c}") } else { format!("{a}{f}({b}{g}{c})") }
        },
    );
    let assign = prop::sample::select(&["=", "+=", "-=", "*=", "/=", "=", "="][..]);
    let statement = prop_oneof![
        12 => (name, assign, value.clone()).prop_map(|(name, assign, value)| format!("{name}{assign}{value}")),
        1 => prop::sample::select(&["B='x'", "C=$NULL", "A=ON", "Q={}", "B=5", "%G01='y'", "OA(2)=B", "Q={A,'z',I}"][..]).prop_map(str::to_owned),
        1 => value.clone().prop_map(|value| format!("Q+={value}")),
        1 => value.clone().prop_map(|value| format!("A=$FMOD({value},B)")),
        1 => value.prop_map(|value| format!("IF/{value}.LT.A.OR.A.NE.3\nEXIT\nENDOF/IF")),
    ];
    prop::collection::vec(statement, 1..6).prop_map(|lines| {
        let body = lines.join("\n");
        format!(
            "MACRO/G(X,Y)\nG=X-Y*2\nENDMAC\nDECLAR/REAL,D(3)\nDECLAR/REAL,E(3,4)\nDECLAR/OBJECT,REAL,OS\nDECLAR/OBJECT,OA(3)\n\
             DECLAR/OBJECT,REAL,OM(2,4)\nDECLAR/GLOBAL,REAL,GV\nDECLAR/REAL,R\nQ={{1,2,3}}\nA=1\nB=2\nH=10**300\nDO/I=1,4\n{body}\nENDOF/DO\n\
             PPRINT/'!(*) !(*) !(*) !(*) !(*) !(*) !(*)',A,B,C,R,Q,{{D(1),D(2),D(3)}},\
             {{E(1,2),E(3,2),%G01,OS,OA(1),OA(3),OM(1,2),OM(2,4),GV}}"
        )
    })
}

/// Everything that can be seen of a run.
#[derive(Debug, PartialEq)]
struct Seen {
    ends: Vec<MacroEnd>,
    arguments: String,
    ticks: u64,
    printed: Vec<String>,
    traced: Vec<String>,
    diagnostics: Vec<MacroDiagnostic>,
}

fn run(text: &str, options: CompileOptions, short_forms: bool) -> Option<Seen> {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, MacroSource::new("any", text), options);
    if added.has_errors() {
        return None;
    }
    if !short_forms {
        program.macros.iter_mut().for_each(|code| Arc::make_mut(code).short.forms.fill(Fast::None));
    }
    let limits =
        MacroLimits { ticks: 20_000, text: 2_000, elements: 1_000, depth: 10, units: 3, ..MacroLimits::default() };
    let mut state = MacroState::new(limits);
    let mut arguments = [MacroValue::Real(1.0)];
    let ends = added.macros.iter().map(|index| vm::run(&program, &mut state, &mut host, *index, &mut arguments).0);
    let ends = ends.collect();
    vm::close_all(&mut state, &mut host);
    Some(Seen {
        ends,
        arguments: format!("{arguments:?}"),
        ticks: state.ticks,
        printed: host.output.printed,
        traced: host.output.traced,
        diagnostics: host.output.diagnostics,
    })
}

/// Runs a text with and without short forms of instructions, which must make no difference.
fn execute(text: &str) {
    for trace in [false, true] {
        let options = CompileOptions { uninitialised: true, trace, ..CompileOptions::default() };
        assert_eq!(run(text, options, true), run(text, options, false), "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let source = MacroSource::from_bytes("any", &bytes);
        execute(&source.text);
    }

    #[test]
    fn any_pieces(text in soup()) {
        execute(&text);
        for diagnostic in check(&text, "any") {
            let _ = diagnostic.to_string();
        }
    }

    #[test]
    fn any_program(text in program()) {
        execute(&text);
    }

    #[test]
    fn any_numbers(text in numbers()) {
        prop_assert!(run(&text, CompileOptions::default(), true).is_some(), "{text}");
        execute(&text);
    }

    #[test]
    fn formatting_twice_is_formatting_once(text in soup()) {
        for style in [SourceStyle::Standard, SourceStyle::C] {
            if let Ok(once) = layout::format(&text, style) {
                let twice = layout::format(&once, style);
                prop_assert_eq!(twice.ok(), Some(once));
            }
        }
    }

    #[test]
    fn any_format(format in "[-!(^)VFXsef.:0-9ATLMR*@#+ a]{0,20}", number in any::<f64>(), line in ".{0,20}") {
        let mut host = Standalone::new();
        if let Ok(format) = StringFormat::output(&format) {
            let values = vec![MacroValue::Real(number); format.arguments];
            let _ = write(&mut String::new(), &format, &values, &mut host);
        }
        if let Ok(format) = StringFormat::input(&format) {
            let (values, _) = read(&format, &line);
            prop_assert_eq!(values.len(), format.arguments);
        }
    }

    #[test]
    fn numbers_come_back(thousandths in -1_000_000_000i64..1_000_000_000) {
        let number = thousandths as f64 / 1000.0;
        let text = wildcard_text(number);
        prop_assert_eq!(text.parse::<f64>().unwrap_or(0.0), number);
        let format = StringFormat::input("!(*)").unwrap();
        let (values, good) = read(&format, &text);
        prop_assert!(good);
        prop_assert_eq!(values[0].as_real(), Some(number));
    }

    #[test]
    fn any_pattern(pattern in "[ab.*^$\\\\(){}<>1-3,\\[\\]-]{0,20}", text in "[ab]{0,40}") {
        if let Ok(pattern) = TextPattern::new(&pattern) {
            for result in [pattern.replace(&text, "<\\1>", 0).map(|_| ()), pattern.split(&text, 0).map(|_| ())] {
                if let Err(fault) = result {
                    prop_assert_eq!(fault.number, DiagnosticNumber::BACKTRACKING);
                }
            }
        }
    }

    #[test]
    fn plain_text_matches_itself(text in "[a-zA-Z0-9 ()+?|<>{}]{1,20}") {
        let pattern = TextPattern::new(&text).unwrap();
        prop_assert_eq!(pattern.nth(&text, None, 1).unwrap(), Some(text));
    }
}

#[test]
fn reading_takes_linear_time() {
    let time = |count: usize| {
        let text = "A=1+(2*3)//'x'.EQ.{1,2} $$ c\n".repeat(count) + &"(".repeat(count) + &"'".repeat(count);
        let start = std::time::Instant::now();
        let diagnostics = check(&text, "long");
        assert!(!diagnostics.is_empty());
        start.elapsed().as_secs_f64()
    };
    time(1000);
    let (short, long) = (time(2000), time(16_000));
    assert!(long < short * 8.0 * 6.0 + 0.2, "{short} s, then {long} s for eight times the text");
}

#[test]
fn deep_nesting_is_refused_with_a_number() {
    let deep = "IF/.TRUE.\n".repeat(5000);
    let diagnostics = check(&deep, "deep");
    assert!(diagnostics.iter().any(|diagnostic| diagnostic.number == DiagnosticNumber::TOO_DEEP));
    assert!(diagnostics.len() <= 201);
}
