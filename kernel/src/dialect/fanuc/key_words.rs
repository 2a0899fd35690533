//! Where a statement begins, told from literal texts and unknown words that begin with the same letters.
//!
//! Facts: reference control-emulator.md 5.4 (key words may be cut to two letters). Invariant: scanner and compiler ask
//! the same question, so a line that one of them takes for words is none that the other takes for a statement.

use super::statement::Names;
use crate::mcd::special::stands;

/// Key words of statements; two letters are enough.
pub(super) const STATEMENTS: &[&str] =
    &["IF", "WHILE", "GOTO", "DO", "END", "ENDIF", "ELSE", "THEN", "POPEN", "PCLOS", "BPRNT", "DPRNT"];

/// A key word of statements, or the first letters of one, stands at a place: it begins and ends there with its letters,
/// and no literal text that is longer stands there. Only behind `THEN` may letters follow at once.
pub(crate) fn key_word(names: Names<'_>, line: &[u8], at: usize) -> bool {
    let letter = |at: Option<usize>| at.and_then(|at| line.get(at)).is_some_and(u8::is_ascii_alphabetic);
    if !letter(Some(at)) || letter(at.checked_sub(1)) {
        return false;
    }
    let rest = line.get(at..).unwrap_or_default();
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let letters = rest.get(..length).unwrap_or_default();
    let opens = |word: &&str| word.as_bytes().get(..length).is_some_and(|begin| begin.eq_ignore_ascii_case(letters));
    let then = letters.len() > 4 && letters.get(..4).is_some_and(|four| four.eq_ignore_ascii_case(b"THEN"));
    length >= 2
        && (then || STATEMENTS.iter().any(opens))
        && !names.texts.iter().any(|(text, _)| text.len() > length && stands(text, line, at))
}
