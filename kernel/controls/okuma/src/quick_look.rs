//! Which blocks the pre-processor looks at.
//!
//! Invariant: one pass over the text, nothing allocated; plain words with comments are never among them.

/// Whether a block is anything but plain words: `=` or a bracket, letters side by side (keywords and names), the name
/// of a program, a line of the file's own, a comment that is a message, or G81 to G88, which may name a contour.
pub(super) fn needs_interpreter(text: &[u8]) -> bool {
    let (mut at, mut letter) = (0, false);
    let start = text.trim_ascii_start();
    if matches!(start.first(), Some(b'O' | b'o' | b'$')) {
        return true;
    }
    while let Some(&byte) = text.get(at) {
        match byte {
            b'=' | b'[' => return true,
            b'(' => {
                let rest = text.get(at + 1..).unwrap_or_default();
                if is_message(rest) {
                    return true;
                }
                let Some(end) = memchr::memchr(b')', rest) else { return false };
                at += end + 1;
                letter = false;
            }
            _ => {
                let is_letter = byte.is_ascii_alphabetic();
                if letter && is_letter || byte | 0x20 == b'g' && is_contour(text.get(at + 1..).unwrap_or_default()) {
                    return true;
                }
                letter = is_letter;
            }
        }
        at += 1;
    }
    false
}

/// Whether a number is one of G81 to G88, which lathes use for contours.
fn is_contour(number: &[u8]) -> bool {
    let zeros = number.iter().take_while(|digit| **digit == b'0').count();
    matches!(number.get(zeros..).unwrap_or_default(), [b'8', b'1'..=b'8', ..])
}

/// Whether the inside of a comment is a message: `MSG, …`.
pub(super) fn is_message(inside: &[u8]) -> bool {
    let inside = inside.trim_ascii_start();
    inside.get(..3).is_some_and(|word| word.eq_ignore_ascii_case(b"MSG"))
        && inside.get(3..).unwrap_or_default().trim_ascii_start().first() == Some(&b',')
}

#[cfg(test)]
mod tests {
    use super::needs_interpreter;

    #[test]
    fn plain_words_are_left_alone() {
        for text in ["", "N100 G01 X10.5 Z-3 (LA1=5 [X])", "/1 G0 X1", "G1X5Z3F.2", "%", "(RTS)", "X5 (open", "M02"] {
            assert!(!needs_interpreter(text.as_bytes()), "{text}");
        }
        for text in [
            "G87 N5",
            "N1g081",
            "LA1=5",
            "X[5]",
            "RTS",
            "N10 GOTO N20",
            "NLAP1 G0",
            "O1000",
            " OABC",
            "$A.MIN%",
            "(msg , HI)",
        ] {
            assert!(needs_interpreter(text.as_bytes()), "{text}");
        }
    }
}
