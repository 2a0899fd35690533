//! Macros that do as much as they can: every step pays for what it touches, and none keeps more than it may.
//!
//! What is allocated stands for what is touched: a macro that gets much of it for a tick evades its budget.

use counterpoint_lang::compile::{self, Options, Program};
use counterpoint_lang::diag::Number;
use counterpoint_lang::host::Test;
use counterpoint_lang::source::Source;
use counterpoint_lang::vm::{self, End, Limits, State};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Bytes handed out, bytes in use, most in use.
    static COUNTS: Cell<(u64, i64, i64)> = const { Cell::new((0, 0, 0)) };
}

struct Counting;

fn note(made: usize, gone: usize) {
    let _ = COUNTS.try_with(|counts| {
        let (all, now, most) = counts.get();
        let now = now + made as i64 - gone as i64;
        counts.set((all + made as u64, now, most.max(now)));
    });
}

// SAFETY: everything is handed on to the allocator of the system.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size(), 0);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        note(0, layout.size());
        unsafe { System.dealloc(place, layout) }
    }
    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size, layout.size());
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Seen {
    end: End,
    numbers: Vec<Number>,
    ticks: u64,
    /// Bytes handed out while it ran.
    made: u64,
    /// Most bytes in use while it ran.
    most: i64,
    texts: Vec<String>,
}

fn run(text: &str, limits: Limits) -> Seen {
    let (mut program, mut host) = (Program::new(), Test::new());
    let added = compile::add(&mut program, &mut host, Source::new("hostile", text), Options::default());
    assert!(!added.has_errors(), "{text}\n{:?}", added.diagnostics);
    let mut state = State::new(limits);
    let index = *added.macros.last().unwrap();
    let before = COUNTS.get();
    COUNTS.set((before.0, 0, 0));
    let (end, _) = vm::run(&program, &mut state, &mut host, index, &mut []);
    let (all, _, most) = COUNTS.get();
    Seen {
        end,
        numbers: host.diagnostics.iter().map(|diagnostic| diagnostic.number).collect(),
        ticks: limits.ticks - state.ticks,
        made: all - before.0,
        most,
        texts: host.diagnostics.iter().map(|diagnostic| diagnostic.message.clone()).collect(),
    }
}

/// Macros that go on for ever, by what they do in their loop.
const ENDLESS: &[(&str, &str, &str)] = &[
    ("push of a shared sequence", "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO", "B=C\nC=B\nC+=1"),
    ("append of a shared text", "T='0123456789'\nDO/I=1,13\nT=T//T\nENDOF/DO", "B=T\nT=B\nT+='x'\nT=B"),
    ("element of a shared sequence", "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO", "B=C\nB(1)=2"),
    ("arrays", "", "DECLAR/REAL,A(100000)"),
    ("arrays of texts", "", "DECLAR/STRING,A(1000,100)"),
    ("shared arrays", "", "DECLAR/OBJECT,REAL,A(100000)"),
    ("an array as argument", "DECLAR/REAL,A(100000)", "B=$FFIND(A,1)"),
    ("range", "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO", "B=C(2:)"),
    ("sequences joined", "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO", "B={C,C}"),
    ("texts joined", "T='0123456789'\nDO/I=1,13\nT=T//T\nENDOF/DO", "B=T//'x'"),
    ("replacing", "T='aaaaaaaaaa'\nDO/I=1,10\nT=T//T\nENDOF/DO", "B=$FEDIT(T,'a','bb')"),
    ("splitting", "T='a,a,a,a,a,'\nDO/I=1,10\nT=T//T\nENDOF/DO", "B=$FSPLIT(T,',')"),
    ("backtracking", "T='aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa'", "B=$FMATCH(T,'\\(a*\\)*\\(a*\\)*b')"),
    ("new patterns", "N=0", "N=N+1\nB=$FMATCH('x',$FSWRIT('!(*)\\(a\\{200\\}\\)\\{90\\}',N))"),
    ("new formats", "N=0\nT='0123456789'\nDO/I=1,8\nT=T//T\nENDOF/DO", "N=N+1\nB=$FSWRIT($FSWRIT('!(*)!(*)',T,N))"),
    ("a list as text", "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO", "B=$FSWRIT('!(*)',C)"),
    ("sorting", "C={}\nDO/I=1,5000\nC+=10-I\nENDOF/DO", "B=$FSORT(C)"),
    ("other letters", "T='0123456789'\nDO/I=1,13\nT=T//T\nENDOF/DO", "B=$FTOLOWR(T)\nB=$FTRIM(T,'0')"),
    ("dates", "T='%c%c%c%c%c%c%c%c%c%c'\nDO/I=1,10\nT=T//T\nENDOF/DO", "B=$FDATE(T,1)"),
    ("command lines", "T='a b c d e '\nDO/I=1,10\nT=T//T\nENDOF/DO", "B=$FARGC(T)"),
    ("reading texts", "T='0123456789'\nDO/I=1,13\nT=T//T\nENDOF/DO", "READ/T,'!(a)',B"),
    ("vectors", "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO", "B=$FVADD(C,C)"),
    ("files", "T='0123456789'\nDO/I=1,10\nT=T//T\nENDOF/DO", "OPEN/20,'a'\nWRITE/20,'!(*)',T\nCLOSE/20"),
    ("globals", "DECLAR/GLOBAL,G\nG={}\nDO/I=1,5000\nG+=I\nENDOF/DO", "B=G\nG=B"),
    ("elements of a text", "T='0123456789'\nDO/I=1,13\nT=T//T\nENDOF/DO", "B=T(80000)"),
];

#[test]
fn every_step_pays_for_what_it_touches() {
    for (name, before, body) in ENDLESS {
        let text = format!("{before}\nWHILE/1.EQ.1\n{body}\nENDOF/WHILE\n");
        let limits = Limits { ticks: 200_000, ..Limits::default() };
        let seen = run(&text, limits);
        assert_eq!(
            (seen.end.clone(), seen.ticks),
            (End::Budget, 200_000),
            "{name}: {:?} {:?}",
            seen.numbers,
            seen.texts
        );
        assert!(seen.numbers.contains(&Number::TICKS), "{name}: {:?} {:?}", seen.numbers, seen.texts);
        let share = seen.made / seen.ticks;
        assert!(share <= 600, "{name}: {share} bytes for a tick");
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
        let limits = Limits { memory: 32 << 20, ..Limits::default() };
        let seen = run(text, limits);
        assert_eq!(seen.end, End::Budget, "{name}: {:?}", seen.texts);
        assert!(seen.numbers.contains(&Number::MEMORY), "{name}: {:?} {:?}", seen.numbers, seen.texts);
        // What one step makes comes on top: a million elements, or their texts.
        assert!(seen.most < 120 << 20, "{name}: {} MiB", seen.most >> 20);
    }
}

#[test]
fn garbage_is_not_counted_and_the_largest_holder_is_named() {
    let limits = Limits { memory: 4 << 20, ..Limits::default() };
    let text = "T='0123456789'\nDO/I=1,12\nT=T//T\nENDOF/DO\nDO/I=1,2000\nB=T//'x'\nENDOF/DO";
    assert_eq!(run(text, limits).end, End::Normal, "80 MB came and went");
    let seen = run(
        "T='0123456789'\nDO/I=1,8\nT=T//T\nENDOF/DO\nDECLAR/OBJECT,SEQUENCE,HOARD\nDO/I=1,100000\nHOARD+=T//'x'\nENDOF/DO",
        limits,
    );
    assert!(seen.texts.iter().any(|text| text.contains("the OBJECT variable HOARD")), "{:?}", seen.texts);
}
