//! A place in the text of a block.
//!
//! Invariant: the text is in capitals, with blanks in place of comments, and as long as the block, so that places in it
//! are places in the block.

use counterpoint_fault as diag;
use counterpoint_fault::DiagnosticFacts;

/// Why a block cannot be read, and which alarm that is.
#[derive(Debug, Clone)]
pub(super) struct IsgSyntaxError {
    pub(super) facts: &'static DiagnosticFacts,
    pub(super) text: String,
}

impl IsgSyntaxError {
    /// A mistake in the text.
    pub(super) fn syntax(text: impl Into<String>) -> Self {
        Self { facts: &diag::MACRO_SYNTAX, text: text.into() }
    }

    /// Something else than expected at a place.
    pub(super) fn expected(what: &str, at: usize) -> Self {
        Self::syntax(format!("expected {what} at column {}", at + 1))
    }

    /// A statement of signals that is not possible.
    pub(super) fn signal(text: impl Into<String>) -> Self {
        Self { facts: &diag::SIGNAL_STATEMENT, text: text.into() }
    }
}

/// A text that is being read.
#[derive(Debug, Clone)]
pub(super) struct IsgCursor<'a> {
    text: &'a [u8],
    pub(super) at: usize,
}

impl<'a> IsgCursor<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }

    /// The byte here, blank or not.
    pub(super) fn here(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// A byte further on.
    pub(super) fn ahead(&self, by: usize) -> Option<u8> {
        self.text.get(self.at + by).copied()
    }

    /// The next byte that is not a blank.
    pub(super) fn peek(&mut self) -> Option<u8> {
        while matches!(self.here(), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
        self.here()
    }

    /// Takes a byte, blanks before it too.
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let is = self.peek() == Some(byte);
        if is {
            self.at += 1;
        }
        is
    }

    /// Takes a byte that has to be there.
    pub(super) fn expect(&mut self, byte: u8, what: &str) -> Result<(), IsgSyntaxError> {
        if self.take(byte) { Ok(()) } else { Err(IsgSyntaxError::expected(what, self.at)) }
    }

    /// Takes the bytes that fulfil something.
    pub(super) fn run(&mut self, wanted: impl Fn(u8) -> bool) -> &'a str {
        let start = self.at;
        while self.here().is_some_and(&wanted) {
            self.at += 1;
        }
        self.between(start)
    }

    /// The text from a place up to here.
    pub(super) fn between(&self, start: usize) -> &'a str {
        std::str::from_utf8(self.text.get(start..self.at).unwrap_or_default()).unwrap_or("")
    }

    /// The current place without the blanks before it, but not before `start`.
    pub(super) fn trimmed(&self, start: usize) -> usize {
        start + self.between(start).trim_end().len()
    }

    /// Takes a text, if it is next; it may be written without a blank after it.
    pub(super) fn key(&mut self, word: &str) -> bool {
        self.peek();
        let is = self.text.get(self.at..).is_some_and(|rest| rest.starts_with(word.as_bytes()));
        if is {
            self.at += word.len();
        }
        is
    }

    /// Takes a word of letters, if it is next and no further letter follows.
    pub(super) fn word(&mut self, word: &str) -> bool {
        self.peek();
        let mut ahead = self.clone();
        let is = ahead.run(|byte| byte.is_ascii_alphabetic()) == word;
        if is {
            self.at = ahead.at;
        }
        is
    }

    /// Nothing but blanks may follow.
    pub(super) fn end(&mut self) -> Result<(), IsgSyntaxError> {
        match self.peek() {
            None => Ok(()),
            Some(_) => {
                Err(IsgSyntaxError::syntax(format!("unexpected text after the statement at column {}", self.at + 1)))
            }
        }
    }
}

/// A block in capitals, without comments: `( )`, which may be inside each other, and `;` to the end.
pub(super) fn plain(text: &[u8]) -> Vec<u8> {
    let mut plain = text.to_ascii_uppercase();
    let (mut depth, mut quoted) = (0_usize, false);
    for at in 0..plain.len() {
        let Some(byte) = plain.get_mut(at) else { break };
        match *byte {
            b'"' if depth == 0 => quoted = !quoted,
            _ if quoted => {}
            b';' if depth == 0 => {
                plain.truncate(at);
                break;
            }
            b'(' => {
                depth += 1;
                *byte = b' ';
            }
            b')' if depth > 0 => {
                depth -= 1;
                *byte = b' ';
            }
            _ if depth > 0 => *byte = b' ',
            _ => {}
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn comments_are_blanked() {
        for (text, expected) in [
            ("n10 g0 (a (b) c) x5", "N10 G0           X5"),
            ("g1 ; (x", "G1 "),
            ("#msg [\"a;(b\"] ; c", "#MSG [\"A;(B\"] "),
            ("g0 (open", "G0      "),
        ] {
            assert_eq!(String::from_utf8_lossy(&plain(text.as_bytes())), expected, "{text}");
        }
    }
}
