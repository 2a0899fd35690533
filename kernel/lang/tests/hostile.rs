//! Macros that do as much as they can: every step pays for the data it touches, and no macro keeps more than its limit.

use counterpoint_lang::compile::{self, CompileOptions, MacroProgram};
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::vm::{self, MacroEnd, MacroLimits, MacroState};
use counterpoint_lang_standalone::Standalone;

struct Seen {
    end: MacroEnd,
    numbers: Vec<DiagnosticNumber>,
    texts: Vec<String>,
    ticks: u64,
    /// Value of the first OBJECT variable.
    turns: f64,
}

fn run(text: &str, limits: MacroLimits) -> Seen {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, MacroSource::new("hostile", text), CompileOptions::default());
    assert!(!added.has_errors(), "{text}\n{:?}", added.diagnostics);
    let mut state = MacroState::new(limits);
    let index = added.macros.last().copied().unwrap_or(0);
    let (end, _) = vm::run(&program, &mut state, &mut host, index, &mut []);
    Seen {
        end,
        numbers: host.output.diagnostics.iter().map(|diagnostic| diagnostic.number).collect(),
        texts: host.output.diagnostics.iter().map(|diagnostic| diagnostic.message.clone()).collect(),
        ticks: limits.ticks - state.ticks,
        turns: state.object(0).and_then(|turns| turns.as_real()).unwrap_or(0.0),
    }
}

/// Most bytes of memory that the process has had, none where the system does not say.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10)
}

/// Macros that never end: their statements before the loop and in each turn, and the bytes that a turn touches.
const ENDLESS: &[(&str, &str, &str, u32)] = &[
    ("push of a shared sequence", SEQUENCE, "B=C\nC=B\nC+=1", 80000),
    ("append of a shared text", TEXT, "B=T\nT=B\nT+='x'\nT=B", 81920),
    ("element of a shared sequence", SEQUENCE, "B=C\nB(1)=2", 80000),
    ("arrays", "", "DECLAR/REAL,A(100000)", 1600000),
    ("arrays of texts", "", "DECLAR/STRING,A(1000,100)", 1600000),
    ("shared arrays", "", "DECLAR/OBJECT,REAL,A(100000)", 1600000),
    ("an array as argument", "DECLAR/REAL,A(100000)", "B=$FFIND(A,1)", 1600000),
    ("range", SEQUENCE, "B=C(2:)", 80000),
    ("sequences joined", SEQUENCE, "B={C,C}", 160000),
    ("texts joined", TEXT, "B=T//'x'", 81920),
    ("replacing", TEXT, "B=$FEDIT(T,'0','bb')", 81920),
    ("splitting", TEXT, "B=$FSPLIT(T,'5')", 81920),
    ("backtracking", "X='aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa'", "B=$FMATCH(X,'\\(a*\\)*\\(a*\\)*b')", 0),
    ("new patterns", "", "B=$FMATCH('x',$FSWRIT('!(*)\\(a\\{200\\}\\)\\{90\\}',N))", 13000),
    ("new formats", TEXT, "B=$FSWRIT($FSWRIT('!(*)!!(*)!(*)',T,N),1)", 81920),
    ("a list as text", SEQUENCE, "B=$FSWRIT('!(*)',C)", 80000),
    ("sorting", SEQUENCE, "B=$FSORT(C)", 800000),
    ("other letters", TEXT, "B=$FTOLOWR(T)\nB=$FTRIM(T,'0')", 163840),
    ("dates", "D='%c%c%c%c%c%c%c%c%c%c'\nDO/I=1,10\nD=D//D\nENDOF/DO", "B=$FDATE(D,1)", 200000),
    ("command lines", TEXT, "B=$FARGC(T)", 81920),
    ("reading texts", TEXT, "READ/T,'!(a)',B", 327680),
    ("vectors", SEQUENCE, "B=$FVADD(C,C)", 160000),
    ("files", TEXT, "OPEN/20,'a'\nWRITE/20,'!(*)',T\nCLOSE/20", 163840),
    ("globals", "DECLAR/GLOBAL,G\nG={}\nDO/I=1,5000\nG+=I\nENDOF/DO", "B=G\nG=B", 160000),
    ("elements of a text", TEXT, "B=T(80000)", 80000),
];

/// A sequence and a text of 80 KB.
const SEQUENCE: &str = "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO";
const TEXT: &str = "T='0123456789'\nDO/I=1,13\nT=T//T\nENDOF/DO";

#[test]
fn every_step_pays_for_what_it_touches() {
    for (name, before, body, touched) in ENDLESS {
        let text = format!("DECLAR/OBJECT,REAL,N\n{before}\nWHILE/1.EQ.1\nN=N+1\n{body}\nENDOF/WHILE\n");
        let limits = MacroLimits { ticks: 200_000, ..MacroLimits::default() };
        let seen = run(&text, limits);
        assert_eq!(
            (&seen.end, seen.ticks),
            (&MacroEnd::Budget, 200_000),
            "{name}: {:?} {:?}",
            seen.numbers,
            seen.texts
        );
        assert!(seen.numbers.contains(&DiagnosticNumber::TICKS), "{name}: {:?} {:?}", seen.numbers, seen.texts);
        let share = seen.turns * f64::from(*touched) / 200_000.0;
        assert!(share <= 400.0, "{name}: {share} bytes for a tick, {} turns", seen.turns);
    }
}

/// Macros that keep as much as they can.
const GREEDY: &[(&str, &str)] = &[
    (
        "many arrays",
        "DO/I=1,9\nDECLAR/REAL,A(1000000),B(1000000),C(1000000),D(1000000),E(1000000),F(1000000)\nENDOF/DO",
    ),
    (
        "texts in a sequence",
        "DECLAR/OBJECT,SEQUENCE,Q\nT='0123456789'\nDO/I=1,12\nT=T//T\nENDOF/DO\nDO/I=1,100000\nQ+=T//'x'\nENDOF/DO",
    ),
    (
        "texts in an array",
        "DECLAR/A(10000)\nT='0123456789'\nDO/I=1,12\nT=T//T\nENDOF/DO\nDO/I=1,10000\nA(I)=T//'x'\nENDOF/DO",
    ),
    (
        "many sequences",
        "A={}\nB={}\nC={}\nD={}\nE={}\nF={}\nDO/I=1,900000\nA+=I\nB+=I\nC+=I\nD+=I\nE+=I\nF+=I\nENDOF/DO",
    ),
    (
        "globals",
        "T='0123456789'\nDO/I=1,16\nT=T//T\nENDOF/DO\nDECLAR/GLOBAL,G(1000)\nDO/I=1,1000\nG(I)=T//'x'\nENDOF/DO",
    ),
    ("a file", "T='0123456789'\nDO/I=1,16\nT=T//T\nENDOF/DO\nOPEN/20,'a'\nDO/I=1,1000\nWRITE/20,'!(*)',T\nENDOF/DO"),
    (
        "pieces of a text",
        "T='aaaaaaaaaa'\nDO/I=1,14\nT=T//T\nENDOF/DO\nDECLAR/OBJECT,C,D,E\nC=$FSPLIT(T,'a')\nD=$FSPLIT(T,'a')\nE=$FSPLIT(T,'a')",
    ),
];

#[test]
fn no_macro_keeps_more_than_it_may() {
    for (name, text) in GREEDY {
        let limits = MacroLimits { memory: 32 << 20, ..MacroLimits::default() };
        let seen = run(text, limits);
        assert_eq!(seen.end, MacroEnd::Budget, "{name}: {:?}", seen.texts);
        assert!(seen.numbers.contains(&DiagnosticNumber::MEMORY), "{name}: {:?} {:?}", seen.numbers, seen.texts);
    }
    // The result of one step comes on top: a million elements, or their texts.
    assert!(peak().is_none_or(|bytes| bytes < 256 << 20), "{:?} bytes", peak());
}

#[test]
fn garbage_is_not_counted_and_the_largest_holder_is_named() {
    let limits = MacroLimits { memory: 4 << 20, ..MacroLimits::default() };
    let text = "T='0123456789'\nDO/I=1,12\nT=T//T\nENDOF/DO\nDO/I=1,2000\nB=T//'x'\nENDOF/DO";
    assert_eq!(run(text, limits).end, MacroEnd::Normal, "80 MB came and went");
    let seen = run(
        "T='0123456789'\nDO/I=1,8\nT=T//T\nENDOF/DO\nDECLAR/OBJECT,SEQUENCE,HOARD\nDO/I=1,100000\nHOARD+=T//'x'\nENDOF/DO",
        limits,
    );
    assert!(seen.texts.iter().any(|text| text.contains("the OBJECT variable HOARD")), "{:?}", seen.texts);
}
