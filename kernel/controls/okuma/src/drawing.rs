//! Statements for the screen (blank, lines, pictures) and the tool management, which change neither path nor time.
//!
//! *Invariant:* neither a variable with such a name nor the end of a loop (`END n`) is one of them.

use super::cursor::OkumaCursor;

/// Their words.
const WORDS: [&str; 7] = ["DEF", "PS", "PT", "END", "CLEAR", "DRAW", "TLID"];

/// Whether the rest of the block is one.
pub(super) fn is_drawing(cursor: &OkumaCursor<'_>) -> bool {
    let begins_with = |word: &&str| {
        let mut ahead = cursor.clone();
        ahead.word(word)
            && !matches!(ahead.here(), Some(b'0'..=b'9'))
            && !matches!(ahead.peek(), Some(b'=' | b'['))
            && (*word != "END" || !matches!(ahead.peek(), Some(b'0'..=b'9')))
    };
    WORDS.iter().any(begins_with)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_and_variables() {
        let is = |text: &str| is_drawing(&OkumaCursor::new(text.as_bytes()));
        assert!(is("DEF WORK") && is("PT LF,LC,[0,0]") && is("PS LC,[-400,0],[400,19]") && is(" END") && is("DRAW"));
        assert!(!is("PT=5") && !is("END1") && !is("END 1") && !is("DRAWER") && !is("G0 X5"));
    }
}
