//! Where a statement starts among words: keywords, as opposed to literal texts and unknown words that start with the
//! same letters.
//!
//! Facts: reference control-emulator.md 5.4 (keywords may be cut to two letters). *Invariant:* scanner and compiler ask
//! the same question, so a line that one of them takes for words is never a statement for the other.

use super::by_first::Literals;
use super::prefix_registers::{LiteralFirst, stands};
use counterpoint_machine::index::CodeRowId;

/// Key words of the statements of a control.
#[derive(Debug, Clone, Copy, Default)]
pub struct KeyWords {
    /// All of them; two letters are enough.
    pub all: &'static [&'static str],
    /// The one that letters may follow without a blank.
    pub joined: &'static str,
}

/// How expressions of a machine are written.
#[derive(Debug, Clone, Copy, Default)]
pub struct Formulas {
    /// Most levels of brackets.
    pub brackets: Option<u8>,
    /// Sums at addresses need none.
    pub bare_sums: bool,
    /// A statement may follow a condition without THEN.
    pub bare_conditions: bool,
    /// Angles of arc functions are from 0 to 360 degrees.
    pub full_angles: bool,
    /// Largest number of a loop; none: 3.
    pub loops: Option<u8>,
    /// THEN takes one statement.
    pub one_then: bool,
    /// THEN takes only a macro statement.
    pub macro_then: bool,
    /// Sequence and program numbers are digits.
    pub digits_of_numbers: bool,
}

/// Properties of a machine besides words of one letter.
#[derive(Debug, Clone, Copy, Default)]
pub struct StatementVocabulary<'a> {
    /// Literal texts that look like words, and special registers.
    pub literal_first: Option<&'a LiteralFirst>,
    /// All literal texts with their rows, longest first.
    pub texts: Option<&'a Literals>,
    /// How expressions are written.
    pub formulas: Formulas,
    /// Key words of statements.
    pub key_words: KeyWords,
}

impl<'a> StatementVocabulary<'a> {
    /// Literal texts that begin with a byte, with their rows, longest first.
    pub fn texts(&self, byte: u8) -> &'a [(Vec<u8>, CodeRowId)] {
        self.texts.map_or(&[], |texts| texts.of(byte))
    }
}

/// A number as written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrittenNumber {
    /// Value read as a plain number.
    pub value: f64,
    /// A decimal point was written.
    pub point: bool,
    /// Digits written before the point.
    pub digits: u8,
    /// Digits written after it.
    pub fraction: u8,
}

/// Whether a keyword of statements, or its first letters, is at a place: it starts and ends there with its letters, and
/// no longer literal text is there.
#[inline]
pub fn key_word(names: StatementVocabulary<'_>, line: &[u8], at: usize) -> bool {
    // Most words end after their letter.
    let rest = line.get(at..).unwrap_or_default();
    let &[first, second, ..] = rest else { return false };
    if !first.is_ascii_alphabetic() || !second.is_ascii_alphabetic() {
        return false;
    }
    let before = at.checked_sub(1).and_then(|at| line.get(at));
    !before.is_some_and(u8::is_ascii_alphabetic) && opens_key_word(names, line, at)
}

/// Whether the letters at a place, two or more, are a keyword or open one.
fn opens_key_word(names: StatementVocabulary<'_>, line: &[u8], at: usize) -> bool {
    let rest = line.get(at..).unwrap_or_default();
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let letters = rest.get(..length).unwrap_or_default();
    let KeyWords { all, joined } = names.key_words;
    let &[first, second, ..] = letters else { return false };
    let pair = [first.to_ascii_uppercase(), second.to_ascii_uppercase()];
    // Most words are ruled out by their first two letters.
    let opens = |word: &&str| {
        word.as_bytes().first_chunk() == Some(&pair)
            && word.as_bytes().get(..length).is_some_and(|begin| begin.eq_ignore_ascii_case(letters))
    };
    let begins = letters.get(..joined.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(joined.as_bytes()));
    let joins = !joined.is_empty() && letters.len() > joined.len() && begins;
    (joins || all.iter().any(opens))
        && !names.texts(first).iter().any(|(text, _)| text.len() > length && stands(text, line, at))
}
