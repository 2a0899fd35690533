//! Required behaviour of the machine that runs macros, on every path.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
use counterpoint_lang::compile::{self, CompileOptions, MacroProgram};
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::vm::{self, MacroEnd, MacroLimits, MacroState};
use counterpoint_lang_standalone::Standalone;

fn run(text: &str, limits: MacroLimits) -> (Standalone, MacroEnd) {
    run_with(text, limits, CompileOptions::default())
}

fn run_with(text: &str, limits: MacroLimits, options: CompileOptions) -> (Standalone, MacroEnd) {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), options);
    assert_eq!(added.diagnostics, [], "{text}");
    let mut state = MacroState::new(limits);
    let (end, _) = vm::run(&program, &mut state, &mut host, *added.macros.last().unwrap(), &mut []);
    assert_eq!(state.depth, 0, "every macro that is entered is left");
    (host, end)
}

fn first(text: &str) -> DiagnosticNumber {
    run(text, MacroLimits::default()).0.output.diagnostics.first().unwrap().number
}

#[test]
fn an_index_beyond_every_whole_number_is_outside() {
    for index in ["-(10**300)", "10**300", "0", ".9", "2"] {
        assert_eq!(first(&format!("Q={{7}}\nA=Q({index})")), DiagnosticNumber::OUT_OF_RANGE, "{index}");
        assert_eq!(first(&format!("Q={{7}}\nQ({index})=1")), DiagnosticNumber::OUT_OF_RANGE, "{index}");
        assert_eq!(first(&format!("DECLAR/REAL,A(1)\nA({index})+=1")), DiagnosticNumber::OUT_OF_RANGE, "{index}");
        assert_eq!(first(&format!("A='x'\nB=A({index})")), DiagnosticNumber::OUT_OF_RANGE, "{index}");
    }
}

#[test]
fn a_number_that_does_not_exist_is_never_stored() {
    for text in [
        "A=10**300\nA=A*A",
        "A=10**300\nB=A*A+1",
        "A=10**300\nB=1-A/(1/A)",
        "DECLAR/REAL,A(1)\nB=10**300\nA(1)=B\nA(1)=A(1)*B",
        "A=0\nB=1\nB/=A",
        "A=10**308\nDO/I=A,A*1.5,A\nENDOF/DO",
    ] {
        assert_eq!(first(text), DiagnosticNumber::BAD_ARITHMETIC, "{text}");
    }
}

#[test]
fn registers_beyond_the_window_work_alike() {
    let mut text: String = (0..400).map(|name| format!("V{name}={name}.5\n")).collect();
    text += "S=0\nDECLAR/REAL,A(3)\nDO/I=1,3\nA(I)=A(I)+V399*2-V0\nS=S+A(I)*I-V399/2\nENDOF/DO\nPPRINT/'!(*)',S";
    let (host, end) = run(&text, MacroLimits::default());
    let sum: f64 = (1..=3).map(|i| 798.5 * f64::from(i) - 199.75).sum();
    assert_eq!((end, host.output.printed), (MacroEnd::Normal, vec![format!("{sum}")]));
}

#[test]
fn a_fault_ends_the_function_and_its_caller_goes_on() {
    let text = "MACRO/F(X)\nF=1\nF=1/X\nF=2\nENDMAC\nA=F(0)\nPPRINT/'!(*)',A";
    let (host, end) = run(text, MacroLimits::default());
    assert_eq!((end, host.output.printed), (MacroEnd::Normal, vec!["1".to_owned()]));
    let fault = host.output.diagnostics.first().unwrap();
    assert_eq!(
        (fault.number, fault.line, fault.macro_name.as_deref()),
        (DiagnosticNumber::BAD_ARITHMETIC, 3, Some("F"))
    );
}

#[test]
fn depth_and_ticks_are_limited_through_calls() {
    let chain: String = (1..40).map(|n| format!("MACRO/F{n}(X)\nF{n}=F{}(X+1)\nENDMAC\n", n - 1)).collect();
    let text = format!("MACRO/F0(X)\nF0=X\nENDMAC\n{chain}A=F39(0)\nPPRINT/'!(*)',A");
    let (host, end) = run(&text, MacroLimits::default());
    assert_eq!((end, host.output.printed), (MacroEnd::Normal, vec!["39".to_owned()]));
    let (host, _) = run(&text, MacroLimits { depth: 20, ..MacroLimits::default() });
    assert_eq!(host.output.diagnostics.first().unwrap().number, DiagnosticNumber::DEPTH);
    let (host, end) = run(&text, MacroLimits { ticks: 100, ..MacroLimits::default() });
    assert_eq!((end, host.output.diagnostics.first().unwrap().number), (MacroEnd::Budget, DiagnosticNumber::TICKS));
    assert!(host.output.printed.is_empty());
    let endless = "MACRO/F(X)\nF=X\nWHILE/X.EQ.X\nENDOF/WHILE\nENDMAC\nA=F(1)\nPPRINT/'after'";
    let (host, end) = run(endless, MacroLimits { ticks: 10_000, ..MacroLimits::default() });
    assert_eq!((end, host.output.printed.len()), (MacroEnd::Budget, 0));
}

/// The visible results of a run: its end, its printed lines and reports, and the steps that it cost. Any budget ends at
/// the same statement.
#[test]
fn a_trace_costs_no_steps() {
    let text = "MACRO/F(X)\nF=X\nWHILE/F.GT.3\nF=F-1\nENDOF/WHILE\nENDMAC\n\
        S=''\nI=0\nWHILE/.TRUE.\nI=I+1\nIF/$FMOD(I,3).EQ.0\nA=F(I)\nB=$FSWRIT('!(*)',A)\nELSE\nB=$FMAX(I,2)\nENDOF/IF\n\
        REPEAT\nB='x'\nUNTIL/I.GT.0\nDO/J=1,I\nEXIT\nENDOF/DO\nPPRINT/'!(*)',I\nENDOF/WHILE";
    for ticks in (100..1500).step_by(7) {
        let limits = MacroLimits { ticks, ..MacroLimits::default() };
        let (plain, end) = run(text, limits);
        let (traced, traced_end) = run_with(text, limits, CompileOptions { trace: true, ..CompileOptions::default() });
        assert_eq!((end, plain.output.printed), (traced_end, traced.output.printed), "{ticks} ticks");
        assert_eq!(plain.output.diagnostics, traced.output.diagnostics, "{ticks} ticks");
    }
}

fn seen(text: &str, limits: MacroLimits) -> (MacroEnd, Vec<String>, Vec<String>, u64) {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
    assert!(!added.has_errors(), "{text}: {:?}", added.diagnostics);
    let mut state = MacroState::new(limits);
    let (end, _) = vm::run(&program, &mut state, &mut host, *added.macros.last().unwrap(), &mut []);
    assert_eq!(state.depth, 0, "every macro that is entered is left");
    let reported = |one: &counterpoint_lang::diag::MacroDiagnostic| {
        format!("{:?} {:?} {:?} {}", one.number, one.macro_name, one.statement, one.message)
    };
    let reported = host.output.diagnostics.iter().map(reported).collect();
    (end, host.output.printed, reported, limits.ticks - state.ticks)
}

#[test]
fn a_small_function_does_what_a_large_one_does() {
    // The condition never holds; PPRINT makes the function one that needs a call of its own.
    const LARGE: &str = "IF/1.EQ.0\nPPRINT/'never'\nENDOF/IF\nENDMAC";
    let functions = [
        ("F(A,B)", "F=A+B"),
        ("F(A,B)", "F=A*2-B/A"),
        ("F(A,B)", "F=A\nF=F/B\nF=7"),
        ("F(A,B)", "A=A+1\nB=A\nF=A+B"),
        ("F(A,B)", "IF/A.EQ.B\nF=A\nENDOF/IF"),
        ("F(A,B)", "IF/A.EQ.B\nF=A\nELSE\nF=B\nENDOF/IF\nF+=A"),
        ("F(A,B)", "IF/A.LT.B\nL=A\nENDOF/IF\nF=L"),
        ("F(A,B)", "C=A"),
        ("F(A,B)", "F=A(2)"),
        ("F(A,B)", "IF/A(1).NE.B\nF=A(1)*2\nENDOF/IF"),
        ("F(A,B)", "F=A//B\nF=F//F"),
        ("F(A,B)", "F=$FMOD(A,3)+$FSQRT(B)"),
        ("F(A,B)", "F=F.EQ.$NULL\nF=.NOT.F"),
        ("F(A,B)", "CASE/A\nWHEN/1,2\nF='few'\nWHEN/3,THRU,9\nF='many'\nWHEN/OTHERS\nF=B\nENDOF/CASE"),
        ("REAL,F(REAL,A,B)", "F=A+1\nC=B"),
        ("STRING,F(A,STRING,B)", "F=A"),
    ];
    let calls = [
        "R=F(1,2)",
        "R=F(4,4)",
        "R=F(0,0)",
        "R=F('a','b')",
        "R=F('a',1)",
        "R=F(3,'b')",
        "R=F($TRUE,$FALSE)",
        "R=F({1,2,3},4)",
        "R=F(U,V)",
        "U=1\nU=2\nR=F(U,U)\nR=F(R,U)",
        "R=1\nDO/I=1,3\nR=F(R,I)\nENDOF/DO",
        "R=F(F(1,2),F(3,4))",
        "DECLAR/OBJECT,O\nO=5\nR=F(O,1)\nO=F(R,O)\nR=F(O,O)",
        "R={9}\nR=F(10**300,10**300)",
        "R=F(1,2)\nR=F(2,1)\nR=F('x','x')\nR=F(1,2)",
    ];
    let mut compared = 0;
    for (header, body) in functions {
        for call in calls {
            let rest = format!("{call}\nPPRINT/'!(*) !(*)',R,U");
            let small = format!("MACRO/{header}\n{body}\nENDMAC\n{rest}");
            let large = format!("MACRO/{header}\n{body}\n{LARGE}\n{rest}");
            if !compiles(&small) {
                continue;
            }
            let depth = MacroLimits { depth: 1, ..MacroLimits::default() };
            let tight = (0..30).map(|ticks| MacroLimits { ticks, ..MacroLimits::default() });
            for limits in [MacroLimits::default(), depth].into_iter().chain(tight) {
                assert_eq!(seen(&small, limits), seen(&large, limits), "{small}\n{limits:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 5_000, "{compared}");
}

fn compiles(text: &str) -> bool {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
    !added.has_errors()
}
