use super::*;
use crate::ast::{Expr, ExprKind, MacroVariableScope};

fn show(expression: &Expr) -> String {
    match &expression.kind {
        ExprKind::Real(number) => format!("{number}"),
        ExprKind::Variable(crate::ast::VariableName::User(name)) => name.clone(),
        ExprKind::Unary(sign, operand) => format!("({}{})", sign.c(), show(operand)),
        ExprKind::Binary(sign, left, right) => format!("({}{}{})", show(left), sign.c(), show(right)),
        other => format!("{other:?}"),
    }
}

fn bound(text: &str) -> String {
    show(&expression(&MacroSource::new("t", text)).unwrap())
}

fn numbers(text: &str) -> Vec<DiagnosticNumber> {
    parse(&MacroSource::new("t", text)).1.into_iter().map(|diagnostic| diagnostic.number).collect()
}

#[test]
fn operators_bind_as_the_reference_says() {
    assert_eq!(bound("I.EQ.1.OR..NOT.J.GT.2.AND.K.LE.3"), "((I==1)||((!(J>2))&&(K<=3)))");
    assert_eq!(bound("-2**2"), "(-(2**2))");
    assert_eq!(bound("2**3**2"), "(2**(3**2))");
    assert_eq!(bound("2**-1"), "(2**(-1))");
    assert_eq!(bound("A-B-C*D/E"), "((A-B)-((C*D)/E))");
    assert_eq!(bound("A+B//C+D"), "((A+B)//(C+D))");
    assert_eq!(bound("A.XOR.B.OR.C.AND.D"), "(A^^(B||(C&&D)))");
}

#[test]
fn every_error_of_a_file_is_found() {
    let text = "A=\nWHLIE/A\n$FSIN(3)\nON=3\nB=1)\nA(1)(2)=3\nEXIT/0\nA(1:2)=3\nLET/X=1\nGOTO/1\nI.EQ.1";
    assert_eq!(
        numbers(text),
        [
            DiagnosticNumber::SYNTAX,
            DiagnosticNumber::UNKNOWN_COMMAND,
            DiagnosticNumber::BARE_CALL,
            DiagnosticNumber::BAD_TARGET,
            DiagnosticNumber::SYNTAX,
            DiagnosticNumber::SYNTAX,
            DiagnosticNumber::BAD_EXIT,
            DiagnosticNumber::BAD_TARGET,
            DiagnosticNumber::RESERVED_WORD,
            DiagnosticNumber::RECORD_IGNORED,
            DiagnosticNumber::SYNTAX,
        ]
    );
    let (_, diagnostics) = parse(&MacroSource::new("t", "WHLIE/A"));
    assert_eq!(diagnostics[0].help.as_deref(), Some("did you mean WHILE?"));
}

#[test]
fn all_statements_are_read() {
    let text = "IF/A\nELSEIF/B\nELSE\nENDOF/IF\nCASE/A\nWHEN/1,THRU,5,7\nWHEN/OTHERS\nENDOF/CASE\nWHILE/A\nENDOF/WHILE\n\
                REPEAT\nUNTIL/A\nDO/I=1,2,3\nENDOF/DO\nEXIT\nEXIT/2\nJUMPTO/10A\n10A: TERMAC\nMATCH/ON\nOUTPUT\n\
                EXEC/NOW,'G1 X!(*)',1\nEXEC/CODE_DELAY,REG_DELAY,2\nTAPERD\nTAPEWT\nSEARCH/3\nSAVMODAL\nRSTMODAL\n\
                LPRINT/OFF\nLPRINT/2\nPPRINT/'x'\nOPEN/20,REAR,'f'\nCLOSE/20\nWRITE/20,'!(*)',A\n\
                READ/20,DECR,'!(*)',A\nREAD/'T12','!(X1)!(*)',%L01\nERROR/8,'x'\nSYSTEM/'ls'\nINCLUD/'f'\n\
                DECLAR/GLOBAL,REAL,CHANNEL,A(2),B=3\nX+=1\nX(1,2)-=1\n$P1*=2\n%G3/=4\nENDMAC";
    let (macros, diagnostics) = parse(&MacroSource::new("t", text));
    assert_eq!(diagnostics, []);
    assert_eq!(macros[0].statements.len(), text.lines().count());
}

#[test]
fn functions_of_a_file_are_divided() {
    let text = "MACRO/REAL,FIT(REAL,V,REAL,LO,HI)\nFIT=$FMAX(LO,$FMIN(V,HI))\nENDMAC\nMACRO/TWO()\nTWO=2\nENDMAC\nA=1";
    let (macros, diagnostics) = parse(&MacroSource::new("t", text));
    assert_eq!(diagnostics, []);
    assert_eq!(macros.len(), 3);
    assert_eq!(macros[0].header.as_ref().unwrap().parameters.len(), 3);
    assert!(macros[2].header.is_none());
}

#[test]
fn declarations() {
    let (macros, _) = parse(&MacroSource::new("t", "DECLAR/OBJECT,STRING,SEEN(20)\nDECLAR/REAL,RAD=$PI/180"));
    let StatementKind::Declare { scope, kind, names, .. } = &macros[0].statements[0].kind else { panic!() };
    assert_eq!((*scope, kind.unwrap().name(), names[0].name.as_str()), (MacroVariableScope::Object, "STRING", "SEEN"));
    assert_eq!(numbers("DECLAR/%L01"), [DiagnosticNumber::REDECLARED]);
    assert_eq!(numbers("DECLAR/ON"), [DiagnosticNumber::REDECLARED]);
    assert_eq!(numbers("DECLAR/%ON=1"), []);
    assert_eq!(numbers("DECLAR/EXTERN,FUNCTION,'a.dll',F()"), [DiagnosticNumber::NOT_HERE]);
}

#[test]
fn deep_nesting_is_refused() {
    let deep = format!("A={}1{}", "(".repeat(240), ")".repeat(240));
    assert_eq!(numbers(&deep), [DiagnosticNumber::TOO_DEEP]);
    let deep = format!("A={}1{}", "(".repeat(400), ")".repeat(400));
    assert_eq!(numbers(&deep), [DiagnosticNumber::LINE_TOO_LONG]);
    let long = format!("A=1{}", "+$\n1".repeat(3000));
    assert_eq!(numbers(&long), [DiagnosticNumber::TOO_DEEP]);
    let signs = format!("A={}1", "-".repeat(400));
    assert_eq!(numbers(&signs), [DiagnosticNumber::TOO_DEEP]);
}

#[test]
fn the_grammar_names_every_command_and_operator() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/macro-language/grammar.md");
    let grammar = std::fs::read_to_string(path).unwrap();
    for command in super::statement::COMMANDS {
        assert!(grammar.contains(&format!("\"{command}\"")), "{command}");
    }
    for kind in crate::value::ValueType::ALL {
        assert!(grammar.contains(&format!("\"{}\"", kind.name())));
    }
    use Sign::*;
    for sign in [Equal, NotEqual, Greater, Less, GreaterEqual, LessEqual, Not, And, Or, Xor, Join, Power, AddAssign] {
        assert!(grammar.contains(&format!("\"{}\"", sign.standard())), "{sign:?}");
        assert!(grammar.contains(&format!("\"{}\"", sign.c())), "{sign:?}");
    }
}
