use super::*;
use crate::value::{MacroValue, RecordName};

struct NoRegisters;

impl RegisterHost for NoRegisters {
    fn code_name(&self, code: u32) -> String {
        format!("CODE_{code}")
    }
    fn register_name(&self, register: u32) -> String {
        format!("REG_{register}")
    }
    fn register_text(&mut self, register: FormatRegister, value: Option<f64>, word: bool) -> Option<String> {
        let FormatRegister::Letter(letter) = register else { return None };
        let value = wildcard_text(value.unwrap_or(7.0));
        Some(if word { format!("{letter}{value}") } else { value })
    }
}

fn out(format: &str, arguments: &[MacroValue]) -> String {
    let mut text = String::new();
    write(&mut text, &StringFormat::output(format).unwrap(), arguments, &mut NoRegisters).unwrap();
    text
}

fn number(format: &str, value: f64) -> String {
    out(format, &[MacroValue::Real(value)])
}

#[test]
fn numbers_of_the_reference() {
    for (value, text) in [
        (12.0, "12"),
        (8.5, "8.5"),
        (-20.0, "-20"),
        (0.5, ".5"),
        (-0.5, "-.5"),
        (0.0, "0"),
        (-0.0, "0"),
        (90.0, "90"),
        (1e-12, "0"),
        (-1e-12, "0"),
        (100.0, "100"),
        (1e20, "100000000000000000000"),
    ] {
        assert_eq!(wildcard_text(value), text);
    }
}

#[test]
fn numeric_forms_of_the_reference() {
    for (format, value, text) in [
        ("!(s5)", 445.634, "446"),
        ("!(2.9)", std::f64::consts::PI, "03.141592654"),
        ("!(s34)", 7.35, "73500"),
        ("!(34s)", 2.5, "0025"),
        ("!(s9f9s)", 0.5, ".5"),
        ("!(s9f9s)", 90.0, "90"),
        ("!(s9:2)", 8855.0, "147:35"),
        ("!(e3:2:2)", 8987.0, "2:29:47"),
        ("!(s3.4s)", 0.0, "0."),
        ("!(+s3.4s)", 12.5, "+12.5"),
        ("!(e3.3e)", 0.5, "0.5"),
        ("!(e3.3e)", 2.0, "2.0"),
        ("!(s3f3e)", 2.0, "2"),
        ("!(3.2)", -1.005, "-001.00"),
        ("!(s5)", 2.5, "3"),
        ("!(s5)", 0.5, "1"),
        ("!(s1)", 12345.0, "12345"),
        ("!(Fs5.2)", -1.5, "   -1.50"),
        ("!(Fs5.2s)", 1.5, "    1.5 "),
        ("!(F5.1)", -1.5, "-0001.5"),
        ("!(Xs3.1)", 1.5, "   1.5"),
        ("!(Xs3.1)", -1.5, "-  1.5"),
        ("!(X+s3.1)", 1.5, "+  1.5"),
        ("!(X3.1)", -1.5, "-001.5"),
        ("!(Fs3.1)", -1.5, " -1.5"),
        ("!(fs3)", 0.0, "  0"),
        ("!(s9:s2)", 35.0, "35"),
        ("!(s9:e2)", 0.0, "0"),
        ("!(s9:2)", 35.0, ":35"),
        ("!(s3:2:2.1)", 59.96, ":01:00.0"),
    ] {
        assert_eq!(number(format, value), text, "{format} {value}");
    }
}

#[test]
fn texts_words_columns_and_characters() {
    assert_eq!(out("a!!b^^c", &[]), "a!b^c");
    assert_eq!(
        out("^^!(A3)|!(A)|!(a5)|", &[MacroValue::text("ABCDE"), MacroValue::text("X"), MacroValue::text("Y")]),
        "^ABC|X|y    |"
    );
    assert_eq!(out("^x", &[MacroValue::Real(65.0)]), "Ax");
    assert_eq!(out("!(M)!(m4)|", &[MacroValue::Keyword(71), MacroValue::Keyword(72)]), "ONoff |");
    assert_eq!(out("!(M)", &[MacroValue::Keyword(999)]), "#999");
    assert_eq!(out("!(R)", &[MacroValue::Record(RecordName { class: 2000, subclass: 1030 })]), "COOLNT");
    assert_eq!(out("!(L)!(l)", &[MacroValue::Logical(true), MacroValue::Logical(false)]), "TRUEfalse");
    assert_eq!(out("Tool 12:!(T14)x", &[]), "Tool 12:     x");
    assert_eq!(out("abcdef!(T3)x!(t3)y", &[]), "aby");
    assert_eq!(out("!@X !#X !(@Y) !(#Y)", &[MacroValue::Real(1.5), MacroValue::Real(2.0)]), "X7 7 Y1.5 2");
}

#[test]
fn the_wildcard_takes_everything() {
    let all = MacroValue::sequence(vec![
        MacroValue::Real(1.5),
        MacroValue::Keyword(24),
        MacroValue::text("a b"),
        MacroValue::Logical(true),
        MacroValue::Null,
        MacroValue::Code(3),
    ]);
    assert_eq!(out("!(*)", &[all]), "<1.5,RIGHT,a b,TRUE,$NULL,CODE_3>");
    assert_eq!(out("!(*)", &[MacroValue::sequence(vec![])]), "<>");
}

#[test]
fn what_does_not_fit_is_told() {
    for text in ["!(", "!(Q)", "!(9.9.9)", "!@q", "!(s)", "!(@100)", "!(5:3)", "!()"] {
        assert!(StringFormat::output(text).is_err(), "{text}");
    }
    let format = StringFormat::output("!(*)").unwrap();
    assert!(write(&mut String::new(), &format, &[], &mut NoRegisters).is_err());
    let format = StringFormat::output("!(s5)").unwrap();
    assert!(write(&mut String::new(), &format, &[MacroValue::text("x")], &mut NoRegisters).is_err());
}

fn input(format: &str, line: &str) -> String {
    let (values, good) = read(&StringFormat::input(format).unwrap(), line);
    let mut text = String::from(if good { "" } else { "bad " });
    any(&mut text, &MacroValue::sequence(values), &NoRegisters);
    text
}

#[test]
fn input_formats() {
    assert_eq!(input("!(X1)!(*) !(X1)!(*)", "T12 D3"), "<12,3>");
    assert_eq!(input("!(s34)", "73500"), "<7.35>");
    assert_eq!(input("!(34s)", "0025"), "<2.5>");
    assert_eq!(input("!(s34)", "25"), "<.0025>");
    assert_eq!(input("!(s34)", "7.5"), "<7.5>");
    assert_eq!(input("!(2)!(2)", "1234"), "<12,34>");
    assert_eq!(input("!(e3:2:2)", "2:29:47"), "<8987>");
    assert_eq!(input("!(A2)!(A)", "abcd"), "<ab,cd>");
    assert_eq!(input("!(M) !(R) !(L)", "on  coolnt TRUE"), "<ON,COOLNT,TRUE>");
    assert_eq!(input("X!(s3.3s)", "X-1.5"), "<-1.5>");
    assert_eq!(input("!(T4)!(A1)!(t1)!(A1)", "abcd"), "<d,a>");
    assert_eq!(input("!(*) !(*) !(*) !(*) !(*)", "$NULL 'it''s' #71 -.5 1:30"), "<$NULL,it's,ON,-.5,90>");
    assert_eq!(input("!(*) !(*)", "FLOOD #2000:1030"), "<FLOOD,COOLNT>");
    assert_eq!(input("!(s3)", "abc"), "bad <$NULL>");
    assert_eq!(input("Q!(s3)", "X12"), "bad <12>");
}
