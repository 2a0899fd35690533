//! The public surface as the kernel and the command line use it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
use counterpoint_lang::compile::{self, CompileOptions, DeclarationStrictness, MacroProgram, MacroRole};
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::layout;
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{self, MacroEnd, MacroLimits, MacroState};
use counterpoint_lang_standalone::Standalone;
use counterpoint_lang_standalone::{self as standalone, RunOptions, check_all};

fn embedded(program: &mut MacroProgram, host: &mut Standalone, text: &str) -> (MacroEnd, MacroValue) {
    let added = compile::embedded(program, host, MacroSource::new("embedded", text), CompileOptions::default());
    assert_eq!(added.diagnostics, [], "{text}");
    let index = *added.macros.last().unwrap();
    vm::run(program, &mut MacroState::new(MacroLimits::default()), host, index, &mut [])
}

#[test]
fn embedded_code_is_an_expression_or_statements() {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let (end, value) = embedded(&mut program, &mut host, "2*3+1");
    assert_eq!((end, value.as_real()), (MacroEnd::Normal, Some(7.0)));
    let (end, value) = embedded(&mut program, &mut host, "%G01=5");
    assert!(end == MacroEnd::Normal && matches!(value, MacroValue::Null));
    let (_, value) = embedded(&mut program, &mut host, "'X'//$FSWRIT('!(*)',%G1)");
    assert_eq!(value.as_text(), Some("X5"));
}

#[test]
fn arguments_come_back_as_the_macro_left_them() {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let text = "$P1=$P1+1\n$P2=$P2(2:)\nOUTPUT\n";
    let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
    let mut arguments = [MacroValue::Real(1.0), MacroValue::text("G64"), MacroValue::Real(9.0)];
    let mut state = MacroState::new(MacroLimits::default());
    vm::run(&program, &mut state, &mut host, added.macros[0], &mut arguments);
    assert_eq!(arguments[0].as_real(), Some(2.0));
    assert_eq!(arguments[1].as_text(), Some("64"));
    assert_eq!(arguments[2].as_real(), Some(9.0));
    assert_eq!(host.output.commands, ["OUTPUT,2,64"]);
}

#[test]
fn locals_start_afresh_and_objects_stay() {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    let text = "DECLAR/OBJECT,REAL,RUNS\nRUNS+=1\nA+=1\nPPRINT/'!(*) !(*)',RUNS,A";
    let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
    let mut state = MacroState::new(MacroLimits::default());
    for _ in 0..2 {
        vm::run(&program, &mut state, &mut host, added.macros[0], &mut []);
    }
    assert_eq!(host.output.printed, ["1 1", "2 1"]);
}

#[test]
fn the_place_of_a_macro_restricts_it() {
    for (place, text) in
        [(MacroRole::Data, "OUTPUT"), (MacroRole::Startup, "OUTPUT"), (MacroRole::Declaration, "TAPERD")]
    {
        let options = CompileOptions { place, ..CompileOptions::default() };
        let added =
            compile::add(&mut MacroProgram::new(), &mut Standalone::new(), MacroSource::new("m", text), options);
        assert_eq!(added.diagnostics[0].number, DiagnosticNumber::NOT_HERE);
    }
}

#[test]
fn included_files_define_functions_once() {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    host.disk.files.insert("f.mac".into(), "MACRO/TWO()\nTWO=2\nENDMAC\nINCLUD/'f.mac'\n".into());
    let text = "INCLUD/'f.mac'\nINCLUD/'f.mac'\nPPRINT/'!(*)',TWO()";
    let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
    assert_eq!(added.diagnostics, []);
    vm::run(&program, &mut MacroState::new(MacroLimits::default()), &mut host, added.macros[0], &mut []);
    assert_eq!(host.output.printed, ["2"]);
}

fn run(files: &[(&str, &str)], options: RunOptions) -> (bool, Standalone) {
    let files: Vec<(String, String)> = files.iter().map(|(n, t)| ((*n).to_owned(), (*t).to_owned())).collect();
    let mut host = Standalone::new();
    (standalone::run(&files, &mut host, options), host)
}

#[test]
fn run_runs_the_last_file() {
    let functions = ("f", "MACRO/TWICE(V)\nTWICE=2*V\nENDMAC");
    let (failed, host) = run(&[functions, ("m", "PPRINT/'!(*)',TWICE(4)")], RunOptions::default());
    assert!(!failed && host.output.printed == ["8"] && host.output.diagnostics.is_empty());
    let (failed, host) = run(&[("m", "PPRINT/'a'\nERROR/8,'bad'\nPPRINT/'b'")], RunOptions::default());
    assert!(failed && host.output.printed == ["a"]);
    let text = host.output.diagnostics[0].to_string();
    let wanted = "Error 02910090: bad\n  --> m:2:1 in m\n    2 | ERROR/8,'bad'\n      | ^^^^^^^^^^^^^\n";
    assert!(text.starts_with(wanted), "{text}");
    let (failed, host) = run(&[("m", "A=")], RunOptions::default());
    assert!(failed && host.output.diagnostics[0].number == DiagnosticNumber::SYNTAX);
    let (_, host) = run(&[("m", "a=1")], RunOptions { trace: true, ..RunOptions::default() });
    let wanted = [
        " Macro:* Entering m",
        " Macro:  A=1",
        " Macro:  ENDMAC",
        " Macro:* Leaving m, Returning to regular processing",
    ];
    assert_eq!(host.output.traced, wanted);
}

#[test]
fn files_are_checked_together() {
    let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    let files = [
        file("use", "DECLAR/GLOBAL,REAL,TOP=TWICE(2)\nINCLUD/'no'"),
        file("define", "MACRO/TWICE(V)\nTWICE=2*V\nENDMAC\nA=TWYCE(1)"),
    ];
    let numbers = |strong| -> Vec<Vec<DiagnosticNumber>> {
        let found = check_all(&files, &mut Standalone::new(), strong);
        found.iter().map(|all| all.iter().map(|d| d.number).collect()).collect()
    };
    let off = [vec![DiagnosticNumber::NO_FILE], vec![DiagnosticNumber::UNKNOWN_FUNCTION]];
    assert_eq!(numbers(DeclarationStrictness::Off), off);
    assert_eq!(numbers(DeclarationStrictness::Partial), off);
    assert_eq!(
        numbers(DeclarationStrictness::Full),
        [vec![DiagnosticNumber::NO_FILE], vec![DiagnosticNumber::UNDECLARED, DiagnosticNumber::UNKNOWN_FUNCTION]]
    );
    let files = [file("m", "DECLAR/GLOBAL,A\nDECLAR/OBJECT,B\nINCLUD/'no'\nC=1")];
    let found = check_all(&files, &mut Standalone::new(), DeclarationStrictness::Partial);
    let lines: Vec<u32> =
        found[0].iter().filter(|d| d.number == DiagnosticNumber::UNDECLARED).map(|d| d.line).collect();
    assert_eq!(lines, [1, 2, 3]);
}

#[test]
fn a_file_has_its_limits() {
    let numbers = |text: &str| -> Vec<DiagnosticNumber> {
        let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
        let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
        added.diagnostics.iter().map(|diagnostic| diagnostic.number).collect()
    };
    let many = numbers(&"A=\n".repeat(300));
    assert_eq!((many.len(), many.last()), (201, Some(&DiagnosticNumber::TOO_MANY)));
    assert_eq!(numbers(&"A=B+C*D-E\n".repeat(40_000)), [DiagnosticNumber::TOO_LARGE]);
    assert_eq!(numbers(&format!("A={}1{}", "(".repeat(200), ")".repeat(200))), [DiagnosticNumber::TOO_DEEP]);
    let half = "MACRO/HALF(V)\nHALF=V/2\nENDMAC\n";
    assert_eq!(numbers(&half.repeat(2)), [DiagnosticNumber::DUPLICATE_FUNCTION]);
}

#[test]
fn budgets_end_a_run() {
    let limits = MacroLimits { ticks: 10_000, text: 100, elements: 100, depth: 3, units: 1, ..MacroLimits::default() };
    for (text, number) in [
        ("A:JUMPTO/A", DiagnosticNumber::TICKS),
        ("T='x'\nREPEAT\nT+=T\nUNTIL/.FALSE.", DiagnosticNumber::SIZE),
        ("Q={1}\nREPEAT\nQ+=Q\nUNTIL/.FALSE.", DiagnosticNumber::SIZE),
        ("DECLAR/REAL,A(200)", DiagnosticNumber::SIZE),
        ("OPEN/20,'a'\nOPEN/21,'b'", DiagnosticNumber::UNITS),
    ] {
        let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
        let added = compile::add(&mut program, &mut host, MacroSource::new("m", text), CompileOptions::default());
        assert_eq!(added.diagnostics, []);
        vm::run(&program, &mut MacroState::new(limits), &mut host, added.macros[0], &mut []);
        assert_eq!(host.output.diagnostics[0].number, number, "{text}");
        assert_eq!(host.output.diagnostics[0].macro_name.as_deref(), Some("m"));
    }
}

#[test]
fn work_on_long_values_costs_more_steps() {
    let long = "T='x'\nQ={1}\nDO/I=1,18\nT+=T\nQ+=Q\nENDOF/DO\nV=T//' '\nR=Q\n";
    let limits = MacroLimits { ticks: 2_000_000, ..MacroLimits::default() };
    for text in
        ["U=T//T", "U=T", "U={Q,1}", "U=Q(2:)", "B=T.EQ.V", "B=Q.EQ.R", "U=T(9)", "U=$FTOLOWR(T)", "U=$FFIND(Q,2)"]
    {
        let more = if text == "U=T" { "\nU+='x'" } else { "" };
        let file = ("m".to_owned(), format!("{long}A: PPRINT/'x'\n{text}{more}\nJUMPTO/A"));
        let mut host = Standalone::new();
        assert!(standalone::run(&[file], &mut host, RunOptions { limits, ..RunOptions::default() }));
        assert_eq!(host.output.diagnostics[0].number, DiagnosticNumber::TICKS, "{text}");
        assert!(host.output.printed.len() < 500, "{text} ran {} times", host.output.printed.len());
    }
}

#[test]
fn what_macros_pile_up_in_the_host_is_bounded() {
    let limits = MacroLimits { ticks: 200_000, ..MacroLimits::default() };
    for text in
        ["X=$FMRU_SETPARAM(H,'k',$FSWRIT('!(*)',N),1)", "X=$FCEADD(CODE_STOP)", "X=$FTMPFILE()", "X=$FMRU_OPEN()"]
    {
        let text = format!("H=$FMRU_OPEN()\nN=0\nA: N+=1\n{text}\nJUMPTO/A");
        let mut host = Standalone::new();
        assert!(standalone::run(&[("m".to_owned(), text)], &mut host, RunOptions { limits, ..RunOptions::default() }));
        assert_eq!(host.output.diagnostics[0].number, DiagnosticNumber::TICKS);
        assert!(host.disk.files.is_empty());
    }
}

#[test]
fn a_comment_behind_a_continuation_stands_still_when_formatted_again() {
    let text = "CASE/A\nWHEN/B$ why\n,C $ and\n,D\nENDOF/CASE\n";
    let once = layout::format(text, layout::SourceStyle::Standard).unwrap();
    assert!(once.contains("\n    $$ why\n"), "{once}");
    assert_eq!(layout::format(&once, layout::SourceStyle::Standard).unwrap(), once);
}
