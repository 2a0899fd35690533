//! Registers: letters in a fixed order.

use counterpoint_lang::value::Value;

/// Letters of the registers; the position is the index.
const LETTERS: &str = "ABCDEFHNSTXYZ";

/// Letter of a register by index or letter.
pub(crate) fn letter(value: Option<&Value>) -> Option<char> {
    match value? {
        Value::Text(text) => {
            text.trim().chars().next().map(|c| c.to_ascii_uppercase()).filter(|c| LETTERS.contains(*c))
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Value::Real(index) => LETTERS.chars().nth((index.max(0.0) as usize).wrapping_sub(1)),
        _ => None,
    }
}

pub(crate) fn format(arguments: &[Value]) -> Value {
    Value::text(letter(arguments.first()).map_or("", |_| "!(s9f9s)"))
}

pub(crate) fn position(arguments: &[Value]) -> Value {
    let at = letter(arguments.first()).and_then(|found| LETTERS.find(found));
    #[allow(clippy::cast_precision_loss)]
    at.map_or(Value::Real(-1.0), |at| Value::Real((at + 1) as f64))
}
