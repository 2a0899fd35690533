//! Expressions and blocks without a kernel.

use super::compiled::{Expression, Op};
use super::expression::whole;
use super::frame::{FrameComponents, SiemensFrame};
use super::item::SiemensItem;
use super::line::{head, read};
use super::number_text::shown;
use super::value::{Data, Type};
use super::{cursor::SiemensCursor, needs_interpreter, settings::named};
use counterpoint_control_api::numeric::NumericOperator;

fn item(text: &str) -> SiemensItem {
    let line = read(text).unwrap();
    assert_eq!(line.items.len(), 1, "{text}: {:?}", line.items);
    line.items.into_iter().next().unwrap()
}

#[test]
fn plain_words_are_not_for_the_pre_processor() {
    for text in ["N10 G1 X10.5 Y-3 F100", "G0X1Y2", "/N20 M3 S1000 ; IF (A)", "T1 D1", "", "M170 M7", "P3"] {
        assert!(!needs_interpreter(text.as_bytes()), "{text}");
    }
    for text in ["X=5", "R1=3", "N10 L20", "M17", "M017", "DIAMON", "LABEL:", ":10 G1", "%_N_A_MPF", "G4 F(1)", "_A"] {
        assert!(needs_interpreter(text.as_bytes()), "{text}");
    }
}

#[test]
fn items_have_their_places() {
    let text = "/ N10 G1 x = R1+1  foo(2 , 3) P2";
    let line = read(&text[2..]).unwrap().at(2);
    let part = |(start, end): (u32, u32)| &text[start as usize..end as usize];
    let parts: Vec<&str> = line.places.iter().copied().map(part).collect();
    assert_eq!(parts, ["N10", "G1", "x = R1+1", "foo(2 , 3)", "P2"]);
    assert_eq!(line.place(1), line.places.get(2).copied());
}

#[test]
fn words_and_names_are_told_apart() {
    let line = read("N10 G1X10.5 Y-3 X1=5 R1=2 SUB L10 M17 M30").unwrap();
    assert_eq!(line.number.as_deref(), Some("10"));
    let kinds: Vec<&str> = line
        .items
        .iter()
        .map(|item| match item {
            SiemensItem::Text(_) => "text",
            SiemensItem::Set { .. } => "set",
            SiemensItem::Bare(_) => "bare",
            SiemensItem::Program(_) => "program",
            SiemensItem::Return(..) => "return",
            _ => "other",
        })
        .collect();
    assert_eq!(kinds, ["text", "text", "text", "set", "set", "bare", "program", "return", "text"]);
    assert!(matches!(item("WAITM(1,1,2)"), SiemensItem::Function(name, list) if name == "WAITM" && list.len() == 3));
    assert!(matches!(item("X=AC(10)"), SiemensItem::Set { .. }));
}

#[test]
fn labels_and_numbers_begin_a_block() {
    let head = |text| head(&mut SiemensCursor::new(text));
    assert_eq!(head("N10 ANF: G1"), (Some("10".into()), Some("ANF".into())));
    assert_eq!(head(":20 G1"), (Some("20".into()), None));
    assert_eq!(head("A1: X5"), (None, Some("A1".into())));
    assert_eq!(head("G1 X5"), (None, None));
}

#[test]
fn comparisons_bind_weakest() {
    assert!(whole("A==1 AND B==2").is_err());
    assert!(whole("(A==1) AND (B==2)").is_ok());
    let expression = whole("R1+1<R2*2").unwrap();
    assert!(matches!(expression.ops().last(), Some(Op::Combine(NumericOperator::Lt))));
    for wrong in ["", "1+", "(1", "1 2", "SIN(", "\"a", "'HXY'", "1EX", "A[1"] {
        assert!(whole(wrong).is_err(), "{wrong}");
    }
    assert_eq!(whole("'HFF'"), Ok(Expression::constant(Data::Int(255))));
    assert_eq!(whole("'B101'"), Ok(Expression::constant(Data::Int(5))));
    assert_eq!(whole("2.5EX-1"), Ok(Expression::constant(Data::Real(0.25))));
    assert!(whole(&format!("{}1{}", "(".repeat(500), ")".repeat(500))).is_err());
    assert!(whole(&"1+".repeat(5000)).is_err());
    assert!(whole(&"-".repeat(5000)).is_err());
}

#[test]
fn frames_come_apart_again() {
    let mut parts =
        FrameComponents { shift: [10.0, -5.0, 0.0], angles: [30.0, 20.0, -45.0], ..FrameComponents::default() };
    parts.scale = [2.0, 1.0, 0.5];
    parts.mirror = [false, true, false];
    assert_eq!(parts.frame().unwrap().parts(), Some(parts));
    let quarter = FrameComponents { angles: [0.0, 90.0, 0.0], ..FrameComponents::default() };
    assert_eq!(quarter.frame().unwrap().parts(), Some(quarter));
    let moved = FrameComponents { shift: [10.0, 0.0, 0.0], ..FrameComponents::default() }.frame().unwrap();
    let turned = FrameComponents { angles: [0.0, 0.0, 90.0], ..FrameComponents::default() }.frame().unwrap();
    // The second shift counts in the turned frame.
    let chain = moved.chain(&turned).and_then(|frame| frame.chain(&moved)).unwrap();
    assert_eq!(chain.parts().unwrap().shift, [10.0, 10.0, 0.0]);
    let skewed = FrameComponents { scale: [2.0, 1.0, 1.0], ..FrameComponents::default() }.frame().unwrap();
    let tilted = FrameComponents { angles: [0.0, 0.0, 30.0], ..FrameComponents::default() }.frame().unwrap();
    assert_eq!(skewed.chain(&tilted).unwrap().parts(), None);
    assert!(FrameComponents { scale: [0.0, 1.0, 1.0], ..FrameComponents::default() }.frame().is_none());
    assert!(FrameComponents { shift: [f64::NAN, 0.0, 0.0], ..FrameComponents::default() }.frame().is_none());
    assert_eq!(SiemensFrame::from_numbers(&turned.numbers()), Some(turned));
}

#[test]
fn types_hold_what_fits() {
    assert_eq!(Type::Int.hold(Data::Real(2.5)), Ok(Data::Int(3)));
    assert!(Type::Int.hold(Data::Real(3e9)).is_err());
    assert_eq!(Type::Bool.hold(Data::Real(0.1)), Ok(Data::Bool(true)));
    assert_eq!(Type::Text(3).hold(Data::Text("abcde".into())), Ok(Data::Text("abc".into())));
    assert!(Type::Real.hold(Data::Text("5".into())).is_err());
    assert_eq!(shown(0.1 + 0.2), "0.3");
    assert_eq!(Data::Real(5.0).word(), "5.");
    assert_eq!(Data::Real(-0.0).word(), "0.");
}

#[test]
fn macros_name_variables_in_native_spelling() {
    assert_eq!(named("R5", &[]), named("R[5]", &[]));
    assert_eq!(named("feld[1,2]", &[]).unwrap().name, "FELD");
    assert!(named("1+2", &[]).is_none());
    assert!(named("A", &[f64::NAN]).is_none());
}

#[test]
fn statements_that_cannot_be_read_are_told() {
    for wrong in ["IF", "FOR I=1", "FOR I=1 TO", "CASE R1 1 GOTOF A", "DEF INT", "DEF INT 5", "WHILE", "PROC", "R1="] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
    for right in
        ["GOTOS", "REPEAT", "REPEAT A B P=3", "REPEATB A P=2", "CASE R1 OF 1 GOTOF A 2 GOTOB N20 DEFAULT GOTO C"]
    {
        assert!(read(right).is_ok(), "{right}");
    }
}
