use super::super::text::prepare;
use super::*;

fn line(text: &str) -> Result<OkumaLine, OkumaSyntaxError> {
    read(prepare(text.as_bytes()), LineReadOptions { subprograms: true, drawing: false, offsets: false })
}

fn plain(text: &str) -> Vec<String> {
    let OkumaStatement::Items(items) = line(text).unwrap().statement else { panic!("{text} has no items") };
    let part = |(start, end): Span| text.get(start as usize..end as usize).unwrap();
    let text = |item| match item {
        OkumaItem::Plain(span) => format!("'{}'", part(span)),
        OkumaItem::OfTool(name, _) => name,
        OkumaItem::Set { span, .. } | OkumaItem::Text { span, .. } => part(span).to_owned(),
    };
    items.into_iter().map(text).collect()
}

#[test]
fn items_of_a_block() {
    assert_eq!(plain("G1X=5Y-2.5 z[la1]M8"), ["'G1'", "X=5", "'Y-2.5'", "z[la1]", "'M8'"]);
    assert_eq!(plain("VC[1] = 2 ,LA=3"), ["VC[1] = 2", "LA=3"]);
    assert_eq!(plain("GOTP N1"), ["'GOTP N1'"]);
    assert_eq!(plain("VUACM[1]='No part (1)' X=#1FH"), ["VUACM[1]='No part (1)'", "X=#1FH"]);
    assert_eq!(plain("IFA=1"), ["IFA=1"]);
    assert_eq!(plain("X=VC1EQ 1"), ["X=VC1EQ 1"]);
}

#[test]
fn heads_of_a_block() {
    let head = |text: &str| line(text).unwrap().head;
    assert_eq!(head("/ N10/2 X5"), [BlockPrefix::Mark(None), BlockPrefix::Number((2, 5)), BlockPrefix::Mark(Some(2))]);
    assert_eq!(head("N10G0X5"), [BlockPrefix::Number((0, 3))]);
    assert_eq!(head(" nLAP1 G0"), [BlockPrefix::Name((1, 6))]);
    assert_eq!(head("oab"), [BlockPrefix::Program((0, 3))]);
    assert!(head("NOEX LA=1").is_empty() && head("NMSG").is_empty() && head("X5").is_empty());
    assert!(head("NCYL G81").is_empty() && head("OMIT R3").is_empty() && !head("OMIT").is_empty());
}

#[test]
fn operands_of_statements_stand_in_brackets() {
    let operands = |text: &str, count| operands(&mut OkumaCursor::new(text.as_bytes()), count).map(|list| list.len());
    assert_eq!((operands("", 0), operands("[LA1+2]", 1), operands("[1, 2]", 2)), (Ok(0), Ok(1), Ok(2)));
    assert!(operands("[1,2]", 1).is_err() && operands("[1]", 2).is_err() && operands("X5", 0).is_err());
}

#[test]
fn statements() {
    let statement = |text: &str| line(text).unwrap().statement;
    let named = |name: &str| OkumaJumpTarget::Named(name.to_owned());
    assert_eq!(statement("GOTO N0100"), OkumaStatement::Goto(None, named("100")));
    assert!(matches!(statement("IF[VC1 EQ 1]NA"), OkumaStatement::Goto(Some(_), target) if target == named("A")));
    assert!(matches!(statement("IF VPBR2 GOTO N7"), OkumaStatement::Goto(Some(_), target) if target == named("7")));
    let OkumaStatement::Call(call) = statement("CALL O1 Q2 LA=1 LB=[2+3]") else { panic!("no call") };
    assert_eq!((call.name.as_str(), call.repeats, call.arguments.len()), ("O1", Some(Expr::constant(2.0)), 2));
    assert_eq!(statement("$A.MIN%"), OkumaStatement::Nothing);
    assert_eq!(statement("$ X5"), OkumaStatement::Continued);
}

#[test]
fn mistakes() {
    for text in
        ["X=", "X=[1", "X=1+", "IF [1] 5", "GOTO 5", "CALL 5", "CALL O", "RTS X5", "LA1[5", "X=SIN 5", "X=SIN[1,2]"]
    {
        assert!(line(text).is_err(), "{text}");
    }
    assert!(matches!(line(&format!("X={}1", "-".repeat(1000))), Err(OkumaSyntaxError::TooLong(_))));
    assert!(matches!(line(&format!("X=1{}", "+1".repeat(1000))), Err(OkumaSyntaxError::TooLong(_))));
    assert!(matches!(line(&format!("X={}", "[".repeat(100_000))), Err(OkumaSyntaxError::TooLong(_))));
}
