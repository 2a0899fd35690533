//! Escapes for characters that can deceive the reader of a terminal.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character changes the direction of a text, ends its line without being a control character, or has no
/// width.
fn deceives(c: char) -> bool {
    let with_range = matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}');
    with_range || matches!(c, '\u{61c}' | '\u{feff}')
}

/// Replaces each deceptive character with its JSON escape.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(deceives) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        let _ = if deceives(c) { write!(out, "\\u{:04x}", u32::from(c)) } else { write!(out, "{c}") };
    }
    Cow::Owned(out)
}
