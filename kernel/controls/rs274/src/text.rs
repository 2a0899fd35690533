//! The text of a block as the control reads it: in lower case, without blanks and comments.
//!
//! Facts: LinuxCNC documentation, "Format of a line" and "Comments": outside comments, blanks and letter case are
//! ignored; a comment is in parentheses or goes from a semicolon to the end. *Invariant:* every byte has its place in
//! the block of the program.

use counterpoint_fault as diag;
use counterpoint_fault::DiagnosticFacts;

use counterpoint_control_api::words::Span;

/// Why a control refuses a block.
#[derive(Debug, Clone)]
pub(super) struct Rs274Mistake {
    pub(super) facts: &'static DiagnosticFacts,
    /// Error number of GRBL.
    pub(super) error: u8,
    pub(super) text: String,
}

impl Rs274Mistake {
    pub(super) fn new(facts: &'static DiagnosticFacts, error: u8, text: impl Into<String>) -> Self {
        Self { facts, error, text: text.into() }
    }

    /// The mistake of a text that is not part of the language.
    pub(super) fn syntax(text: impl Into<String>) -> Self {
        Self::new(&diag::MACRO_SYNTAX, 1, text)
    }
}

/// The text of a block.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct BlockText {
    pub(super) bytes: Box<[u8]>,
    /// Place of each byte in the block.
    places: Box<[u32]>,
    /// Place of the text within the last comment.
    pub(super) comment: Option<Span>,
}

impl BlockText {
    /// Reads a block.
    pub(super) fn read(text: &[u8]) -> Result<Self, Rs274Mistake> {
        let (mut bytes, mut places, mut comment) = (Vec::new(), Vec::new(), None);
        let mut at = 0;
        while let Some(byte) = text.get(at) {
            match byte {
                b'(' => {
                    let rest = text.get(at + 1..).unwrap_or_default();
                    let Some(length) = rest.iter().position(|byte| matches!(byte, b'(' | b')')) else {
                        return Err(Rs274Mistake::syntax("the comment is not closed: write ')'"));
                    };
                    if rest.get(length) == Some(&b'(') {
                        return Err(Rs274Mistake::syntax("a comment is inside another comment: remove '('"));
                    }
                    comment = Some(place(at + 1, at + 1 + length));
                    at += length + 1;
                }
                b';' => {
                    comment = Some(place(at + 1, text.len()));
                    break;
                }
                b' ' | b'\t' | b'\r' | b'\n' | 0 => {}
                _ => {
                    bytes.push(byte.to_ascii_lowercase());
                    places.push(at as u32);
                }
            }
            at += 1;
        }
        Ok(Self { bytes: bytes.into(), places: places.into(), comment })
    }

    /// Place in the block of the bytes from `start` up to but not including `end`.
    pub(super) fn span(&self, start: usize, end: usize) -> Span {
        let first = self.places.get(start).copied().unwrap_or_default();
        let last = end.checked_sub(1).and_then(|last| self.places.get(last)).map_or(first, |last| last + 1);
        (first, last.max(first))
    }
}

fn place(start: usize, end: usize) -> Span {
    (start as u32, end as u32)
}

/// A place in a text that is being read.
#[derive(Debug, Clone)]
pub(super) struct Rs274Cursor<'t> {
    pub(super) text: &'t BlockText,
    pub(super) at: usize,
}

impl<'t> Rs274Cursor<'t> {
    pub(super) fn new(text: &'t BlockText) -> Self {
        Self { text, at: 0 }
    }

    /// The next byte.
    pub(super) fn here(&self) -> Option<u8> {
        self.text.bytes.get(self.at).copied()
    }

    /// The byte after the next byte.
    pub(super) fn next(&self) -> Option<u8> {
        self.text.bytes.get(self.at + 1).copied()
    }

    /// Takes a text if it is next. Returns whether it was.
    pub(super) fn takes(&mut self, word: &str) -> bool {
        let is = self.text.bytes.get(self.at..).is_some_and(|rest| rest.starts_with(word.as_bytes()));
        if is {
            self.at += word.len();
        }
        is
    }

    /// Takes a text that must be next.
    pub(super) fn expect(&mut self, word: &str) -> Result<(), Rs274Mistake> {
        if self.takes(word) { Ok(()) } else { Err(self.expected(&format!("'{word}'"))) }
    }

    /// Takes bytes as long as they satisfy a condition.
    pub(super) fn run(&mut self, wanted: impl Fn(u8) -> bool) -> &'t str {
        let start = self.at;
        while self.here().is_some_and(&wanted) {
            self.at += 1;
        }
        std::str::from_utf8(self.text.bytes.get(start..self.at).unwrap_or_default()).unwrap_or_default()
    }

    /// The mistake that the next text is not the expected text.
    pub(super) fn expected(&self, wanted: &str) -> Rs274Mistake {
        let column = self.text.span(self.at, self.at + 1).0 + 1;
        match self.here() {
            Some(found) => {
                Rs274Mistake::syntax(format!("column {column}: expected {wanted}, found '{}'", char::from(found)))
            }
            None => Rs274Mistake::syntax(format!("expected {wanted} at the end of the block")),
        }
    }

    /// Reads a number without a sign and with at most one point; `None` if no digit is next.
    pub(super) fn number(&mut self) -> Option<f64> {
        let start = self.at;
        let mut digits = self.run(|byte| byte.is_ascii_digit()).len();
        if self.takes(".") {
            digits += self.run(|byte| byte.is_ascii_digit()).len();
        }
        let text = std::str::from_utf8(self.text.bytes.get(start..self.at).unwrap_or_default()).unwrap_or_default();
        if digits == 0 {
            self.at = start;
            return None;
        }
        text.parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blanks_and_comments_are_left_out() {
        let text = BlockText::read(b"N10 G0X +0. 12 34Y 7 (one) ; (two").unwrap();
        assert_eq!(std::str::from_utf8(&text.bytes), Ok("n10g0x+0.1234y7"));
        assert_eq!(text.span(5, 13), (6, 17));
        assert_eq!(text.comment, Some((28, 33)));
        assert!(BlockText::read(b"G0 (open").is_err() && BlockText::read(b"G0 (a (b) c)").is_err());
    }

    #[test]
    fn numbers_may_have_a_point_and_need_a_digit() {
        let number = |text: &[u8]| Rs274Cursor::new(&BlockText::read(text).unwrap()).number();
        assert_eq!([b"1 2".as_slice(), b".5", b"7.", b"1.5.2"].map(number), [12.0, 0.5, 7.0, 1.5].map(Some));
        assert_eq!([b".".as_slice(), b"x", b"-1"].map(number), [None; 3]);
    }
}
