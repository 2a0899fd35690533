//! Characters that deceive the reader of a terminal, as escapes.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character changes the direction of a text, ends its line without being a control character, or has no
/// width.
fn deceives(c: char) -> bool {
    let with_range = matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}');
    with_range || matches!(c, '\u{61c}' | '\u{feff}')
}

/// A text with an escape in place of each character that deceives its reader. The escape is one of JSON.
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
