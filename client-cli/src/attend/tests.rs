use super::*;

#[test]
fn a_question_before_the_first_block_has_no_line() {
    assert_eq!(place("a.nc", 12), ", a.nc line 12");
    assert_eq!((place("a.nc", 0), place("", 0)), (", a.nc".to_owned(), String::new()));
}

#[test]
fn input_that_the_server_refuses_is_asked_for_again() {
    let any = v1::NumberField { min: f64::MIN, max: f64::MAX, whole: false };
    let (text, number) = (Kind::LongestText(3), Kind::Number(any));
    assert_eq!(read(&text, "äöü"), Ok(Value::Text("äöü".to_owned())));
    assert_eq!(read(&text, "abcd"), Err("the text has 4 characters; at most 3 are allowed".to_owned()));
    assert_eq!(read(&number, "-1.5"), Ok(Value::Number(-1.5)));
    for line in ["nan", "inf", "1e999", "x"] {
        assert_eq!(read(&number, line), Err(format!("'{line}' is not a valid number")));
    }
}

#[test]
fn a_field_waits_for_the_variable_that_decides() {
    let field = |by: &str, unless| v1::DialogField {
        enabled_by: by.to_owned(),
        enabled_unless: unless,
        ..v1::DialogField::default()
    };
    let values = |list: &[(&str, Value)]| -> Values {
        let value = |value: &Value| v1::DialogValue { value: Some(value.clone()) };
        list.iter().map(|(variable, v)| ((*variable).to_owned(), value(v))).collect()
    };
    let start = values(&[("%G01", Value::Number(0.0)), ("WET", Value::Flag(true))]);
    let entered = values(&[("wet", Value::Flag(false))]);
    for (by, unless, expected) in
        [("", false, true), ("%g01", false, false), ("%G01", true, true), ("Wet", false, false), ("%G09", true, true)]
    {
        assert_eq!(is_enabled(&field(by, unless), &entered, &start), expected, "{by} {unless}");
    }
    assert!(is_enabled(&field("wet", false), &Values::new(), &start), "what it begins with counts until then");
}

#[test]
fn lines_are_read_as_the_field_takes_them() {
    let choice = |label: &str, n| v1::Choice {
        label: label.into(),
        value: Some(v1::DialogValue { value: Some(Value::Number(n)) }),
    };
    let jaws = Kind::Choice(v1::ChoiceField { choices: vec![choice("soft", 10.0), choice("hard", 20.0)] });
    assert_eq!(hint(&jaws), ", 1 soft, 2 hard");
    assert_eq!(read(&jaws, "Hard"), Ok(Value::Number(20.0)));
    assert_eq!(read(&jaws, "1"), Ok(Value::Number(10.0)));
    assert!(read(&jaws, "3").is_err() && read(&jaws, "0").is_err());
    assert_eq!(shown(&jaws, &Value::Number(20.0)), "hard");
    let number = Kind::Number(v1::NumberField { min: 1.0, max: 40.0, whole: true });
    assert_eq!(hint(&number), ", 1 to 40, whole");
    assert_eq!(read(&number, "40"), Ok(Value::Number(40.0)));
    assert_eq!(read(&number, "2.5"), Err("must be a whole number, not 2.5".to_owned()));
    for outside in ["0", "41", "-3"] {
        assert_eq!(read(&number, outside), Err(format!("must be 1 to 40, not {outside}")));
    }
    let least = Kind::Number(v1::NumberField { min: 1.0, max: f64::MAX, whole: false });
    assert_eq!(read(&least, "0.5"), Err("must be at least 1, not 0.5".to_owned()));
    assert!(read(&number, "two").is_err());
    assert_eq!(read(&Kind::Check(v1::CheckField {}), "Yes"), Ok(Value::Flag(true)));
    assert!(read(&Kind::Check(v1::CheckField {}), "maybe").is_err());
}
