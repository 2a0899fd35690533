//! Showing dialogs with answers ahead.

use super::answers::{check, nth};
use super::*;

fn field(variable: &str, kind: FieldKind, default: Option<DialogValue>) -> DialogField {
    DialogField { label: variable.into(), variable: variable.into(), kind, default, required: false, enabled: None }
}

fn dialogs() -> Vec<Dialog> {
    let jaws = [("soft", 1.0), ("hard", 2.0)].map(|(label, value)| (label.to_owned(), DialogValue::Number(value)));
    vec![Dialog {
        name: "Clamp set".into(),
        title: String::new(),
        fields: vec![
            field("FORCE", FieldKind::Number { min: 1.0, max: 40.0, whole: true }, Some(DialogValue::Number(20.0))),
            field("JAWS", FieldKind::Choice(jaws.into()), None),
            field("NOTE", FieldKind::Text { longest: 5 }, None),
            field("WET", FieldKind::Check, Some(DialogValue::Flag(false))),
        ],
        buttons: vec![
            Button { label: "OK".into(), kind: ButtonKind::Ok },
            Button { label: "Leave".into(), kind: ButtonKind::Cancel },
            Button { label: "Reset".into(), kind: ButtonKind::Reset },
        ],
    }]
}

fn answer(values: &[(&str, DialogValue)]) -> DialogAnswer {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    DialogAnswer { dialog: "CLAMPSET".into(), button: None, values }
}

#[test]
fn ok_writes_back_answers_over_variables_over_defaults() {
    let answer = answer(&[("jaws", DialogValue::Text("hard".into()))]);
    let mut current = |name: &str| (name == "NOTE").then(|| DialogValue::Text("op10".into()));
    let shown = show(&dialogs(), "clamp set", Some(&answer), &mut current).unwrap();
    assert_eq!(shown.button, "OK");
    let expected = [
        ("FORCE".to_owned(), DialogValue::Number(20.0)),
        ("JAWS".to_owned(), DialogValue::Number(2.0)),
        ("NOTE".to_owned(), DialogValue::Text("op10".into())),
        ("WET".to_owned(), DialogValue::Flag(false)),
    ];
    assert_eq!(shown.values, expected);
}

#[test]
fn cancel_leaves_everything_as_it_was() {
    let answer = DialogAnswer { button: Some("leave".into()), ..answer(&[]) };
    let shown = show(&dialogs(), "Clamp set", Some(&answer), &mut |_| None).unwrap();
    assert_eq!(shown, DialogOutcome { button: "Leave".into(), values: vec![] });
}

#[test]
fn without_an_answer_a_dialog_fails() {
    let failure = show(&dialogs(), "Clamp set", None, &mut |_| None);
    assert_eq!(failure, Err(Failure::Unanswered("Clamp set".into())));
    assert_eq!(show(&dialogs(), "x", None, &mut |_| None), Err(Failure::Unknown("x".into())));
}

#[test]
fn answers_are_checked_before_the_job_starts() {
    let cases = [
        (answer(&[("FORCE", DialogValue::Number(50.0))]), "dialog 'Clamp set': FORCE must be 1 to 40, not 50"),
        (answer(&[("FORCE", DialogValue::Number(1.5))]), "dialog 'Clamp set': FORCE must be a whole number, not 1.5"),
        (answer(&[("FORCE", DialogValue::Flag(true))]), "dialog 'Clamp set': FORCE must be a number, not true"),
        (answer(&[("JAWS", DialogValue::Number(3.0))]), "dialog 'Clamp set': JAWS must be one of soft, hard, not 3"),
        (
            answer(&[("NOTE", DialogValue::Text("longer".into()))]),
            "dialog 'Clamp set': NOTE takes 5 characters at most",
        ),
        (answer(&[("X", DialogValue::Number(3.0))]), "dialog 'Clamp set' has no field for 'X'"),
        (DialogAnswer { button: Some("Go".into()), ..answer(&[]) }, "dialog 'Clamp set' has no button 'Go'"),
        (
            DialogAnswer { button: Some("Reset".into()), ..answer(&[]) },
            "dialog 'Clamp set': the button 'Reset' does not end it",
        ),
        (
            DialogAnswer { dialog: "No".into(), ..answer(&[]) },
            "an answer is for the dialog 'No', which the machine does not have",
        ),
    ];
    for (answer, expected) in cases {
        assert_eq!(check(&dialogs(), std::slice::from_ref(&answer)), [expected], "{answer:?}");
    }
    assert_eq!(check(&dialogs(), &[answer(&[("FORCE", DialogValue::Number(5.0))])]), [""; 0]);
}

#[test]
fn answers_are_taken_in_order_and_the_last_one_stays() {
    let answers = [answer(&[("FORCE", DialogValue::Number(1.0))]), answer(&[("FORCE", DialogValue::Number(2.0))])];
    let force = |n| nth(&answers, "clamp SET", n).and_then(|a| a.value("force")).cloned();
    assert_eq!([force(0), force(1), force(7)], [1.0, 2.0, 2.0].map(|v| Some(DialogValue::Number(v))));
    assert_eq!(nth(&answers, "other", 0), None);
}
