use super::*;
use counterpoint_lang::compile::DeclarationStrictness;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang_standalone::{RunOptions, check_all};

fn found(text: &str) -> Vec<(DiagnosticNumber, Option<String>)> {
    let files = [("m".to_owned(), text.to_owned())];
    let found = check_all(&files, &mut standalone(), DeclarationStrictness::Off);
    found.into_iter().flatten().map(|diagnostic| (diagnostic.number, diagnostic.help)).collect()
}

#[test]
fn unknown_names_are_diagnosed_with_a_near_miss() {
    let near = |name: &str| Some(format!("did you mean {name}?"));
    assert_eq!(found("EXEC/CODE_RAPDI"), [(DiagnosticNumber::UNKNOWN_IDENTIFIER, near("CODE_RAPID"))]);
    assert_eq!(found("A=REG_AXIS_XX"), [(DiagnosticNumber::UNKNOWN_IDENTIFIER, near("REG_AXIS_X"))]);
    assert_eq!(found("A=$RAPDI"), [(DiagnosticNumber::UNKNOWN_VARIABLE, near("$RAPID"))]);
    assert_eq!(found("A=$NXM"), [(DiagnosticNumber::UNKNOWN_VARIABLE, None)]);
    assert_eq!(found("A=DATA_AXIS_X\nB=CODE_TPRINT\nC=$TLTAB(1,2)+$LXM"), []);
}

#[test]
fn what_may_only_be_read_is_not_written() {
    for name in ["$MCD", "$XM", "$TLSUM(1,2)", "$CI", "$MNEST", "$ERRNO", "$CECODE"] {
        assert_eq!(found(&format!("{name}=1"))[0].0, DiagnosticNumber::READ_ONLY, "{name}");
    }
    assert_eq!(found("$S=1\n$RAPID=.TRUE.\n$XW=1\n$MCECHN(2)=3\n$OPSKIPL(9)=.TRUE."), []);
    assert_eq!(found("$S='fast'")[0].0, DiagnosticNumber::WRONG_TYPE);
    assert_eq!(found("A=$TLTAB(1)")[0].0, DiagnosticNumber::WRONG_COUNT);
}

fn run(text: &str) -> Standalone {
    let mut host = standalone();
    counterpoint_lang_standalone::run(&[("m".to_owned(), text.to_owned())], &mut host, RunOptions::default());
    host
}

#[test]
fn every_variable_answers_and_every_writable_one_keeps_what_it_gets() {
    for variable in system::table().iter().filter(|variable| variable.category != "constants") {
        let indices = match variable.indices.len() {
            0 => "",
            1 => "(1)",
            _ => "(1,1)",
        };
        let name = format!("{}{indices}", variable.name);
        let host = run(&format!("V={name}\nPPRINT/'!(*)',V"));
        assert!(
            host.output.diagnostics.is_empty() && host.output.printed.len() == 1,
            "{name}: {:?}",
            host.output.diagnostics
        );
        if variable.access != system::ControlVariableAccess::Read {
            let text = format!("{name}={name}\nPPRINT/'!(*)',{name}");
            let again = run(&text);
            assert_eq!(again.output.printed.len(), 1, "{name}: {:?}", again.output.diagnostics);
        }
    }
}

#[test]
fn indices_and_values_have_limits() {
    let numbers = |text: &str| run(text).output.diagnostics.iter().map(|d| d.number).collect::<Vec<_>>();
    assert_eq!(numbers("$SMODE=4")[0], DiagnosticNumber::BAD_VALUE);
    assert_eq!(numbers("A=$OPSKIPL(10)")[0], DiagnosticNumber::OUT_OF_RANGE);
    assert_eq!(numbers("$TLTAB(0,1)=1")[0], DiagnosticNumber::OUT_OF_RANGE);
    assert_eq!(run("$TLTAB(21,3)='x'\nPPRINT/'!(*) !(*)',$TLTAB(21,3),$TLTAB(21,4)").output.printed, ["x $NULL"]);
    assert_eq!(run("A=$FCESAC(CODE_RAPID)\nPPRINT/'!(*)',$FCEGAC(CODE_INTERP_LINEAR)").output.printed, ["CODE_RAPID"]);
}
