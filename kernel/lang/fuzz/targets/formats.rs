//! The first line is a format, the second the text or the values: any format writes and reads without a panic, and a
//! number that a wildcard wrote is read back.
#![no_main]

use counterpoint_lang::format::{Format, read, wildcard_text, write};
use counterpoint_lang_standalone::Standalone;
use counterpoint_lang::value::Value;
use libfuzzer_sys::fuzz_target;

fn value(position: usize, text: &str) -> Value {
    let number = text.parse().unwrap_or(position as f64 - 1.5);
    match (text.len() + position) % 6 {
        0 => Value::text(text),
        1 => Value::Logical(true),
        2 => Value::numbers(&[1.0, number]),
        3 => Value::Null,
        _ => Value::Real(number),
    }
}

fuzz_target!(|input: &str| {
    let (format, text) = input.split_once('\n').unwrap_or((input, "12.5"));
    let mut host = Standalone::new();
    if let Ok(format) = Format::output(format) {
        let values: Vec<Value> = (0..format.arguments).map(|position| value(position, text)).collect();
        let _ = write(&mut String::new(), &format, &values, &mut host);
        let numbers = vec![Value::Real(text.parse().unwrap_or(0.125)); format.arguments];
        let _ = write(&mut String::new(), &format, &numbers, &mut host);
    }
    if let Ok(format) = Format::input(format) {
        let (values, _) = read(&format, text);
        assert_eq!(values.len(), format.arguments);
    }
    if let Ok(number) = text.parse::<f64>()
        && number.abs() < 1e6
    {
        let written = wildcard_text(number);
        let (values, good) = read(&Format::input("!(*)").expect("a format"), &written);
        let back = values.first().and_then(Value::as_real).unwrap_or(f64::NAN);
        assert!(good && (back - number).abs() <= 1e-9, "{number} was written as {written}");
    }
});
