//! SBLOF, SBLON, DISPLOF and DISPLON: whether an operator who steps sees the blocks of a program.
//!
//! *Invariant:* they never change the log.

/// The keywords, and whether they show blocks.
const WORDS: [(&[u8], bool); 4] = [(b"SBLOF", false), (b"DISPLOF", false), (b"SBLON", true), (b"DISPLON", true)];

/// Whether a block shows or hides the blocks from it to the return of its program; none if it has no such keyword.
pub(super) fn shows_blocks(text: &[u8]) -> Option<bool> {
    let mut outside_texts = text.split(|byte| *byte == b'"').step_by(2);
    outside_texts.find_map(|part| {
        let end = part.iter().position(|byte| *byte == b';').unwrap_or(part.len());
        let mut words = part.get(..end)?.split(|byte| !byte.is_ascii_alphanumeric() && *byte != b'_');
        words.find_map(|word| WORDS.iter().find(|(name, _)| word.eq_ignore_ascii_case(name)).map(|(_, shows)| *shows))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_count_outside_texts_comments_and_longer_names() {
        assert_eq!(shows_blocks(b"PROC DRILL(REAL Z) SAVE SBLOF DISPLOF"), Some(false));
        assert_eq!(shows_blocks(b"N10 sblof"), Some(false));
        assert_eq!(shows_blocks(b"SBLON ; not SBLOF"), Some(true));
        assert_eq!(shows_blocks(b"MSG(\"SBLOF\") DISPLON"), Some(true));
        for none in [&b"MSG(\"SBLOF\")"[..], b"NOT_SBLOF=1", b"G1 X1 ; SBLOF", b""] {
            assert_eq!(shows_blocks(none), None);
        }
    }
}
