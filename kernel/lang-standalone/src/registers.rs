//! Registers: letters in a fixed order.

use counterpoint_lang::value::MacroValue;

/// Letters of the registers; the position is the index.
const LETTERS: &str = "ABCDEFHNSTXYZ";

/// Letter of a register by index or letter.
pub(crate) fn letter(value: Option<&MacroValue>) -> Option<char> {
    match value? {
        MacroValue::Text(text) => {
            text.trim().chars().next().map(|c| c.to_ascii_uppercase()).filter(|c| LETTERS.contains(*c))
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        MacroValue::Real(index) => LETTERS.chars().nth((index.max(0.0) as usize).wrapping_sub(1)),
        _ => None,
    }
}

pub(crate) fn format(arguments: &[MacroValue]) -> MacroValue {
    MacroValue::text(letter(arguments.first()).map_or("", |_| "!(s9f9s)"))
}

pub(crate) fn position(arguments: &[MacroValue]) -> MacroValue {
    let at = letter(arguments.first()).and_then(|found| LETTERS.find(found));
    #[allow(clippy::cast_precision_loss)]
    at.map_or(MacroValue::Real(-1.0), |at| MacroValue::Real((at + 1) as f64))
}
