//! A place in the text of a block.
//!
//! Invariant: the text is in capitals, with blanks in place of comments, and as long as the block, so that places in it
//! are places in the block.

/// The unreadable parts.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum OkumaSyntaxError {
    #[error("expected {0} at column {1}")]
    Expected(&'static str, usize),
    #[error("the expression is too long at column {0}")]
    TooLong(usize),
    #[error("unexpected text after the statement at column {0}")]
    Behind(usize),
    #[error("{0} takes {1} at column {2}")]
    Arguments(&'static str, &'static str, usize),
    #[error("expected {0} operands at column {1}")]
    Operands(usize, usize),
}

/// A text that is being read.
#[derive(Debug, Clone)]
pub(super) struct OkumaCursor<'a> {
    text: &'a [u8],
    pub(super) at: usize,
}

impl<'a> OkumaCursor<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }

    /// The next byte that is not a blank.
    pub(super) fn peek(&mut self) -> Option<u8> {
        while matches!(self.text.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    /// The byte here, blank or not.
    pub(super) fn here(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// Takes a byte, blanks before it too.
    pub(super) fn take(&mut self, byte: u8) -> bool {
        let is = self.peek() == Some(byte);
        if is {
            self.at += 1;
        }
        is
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

    /// Takes a keyword, if it is next; it may be written without a blank after it.
    pub(super) fn key_word(&mut self, word: &str) -> bool {
        self.peek();
        let is = self.text.get(self.at..).is_some_and(|rest| rest.starts_with(word.as_bytes()));
        if is {
            self.at += word.len();
        }
        is
    }

    /// Takes a byte that has to be there.
    pub(super) fn expect(&mut self, byte: u8, what: &'static str) -> Result<(), OkumaSyntaxError> {
        if self.take(byte) { Ok(()) } else { Err(OkumaSyntaxError::Expected(what, self.at + 1)) }
    }

    /// Takes the rest, without blanks at its ends.
    pub(super) fn rest(&mut self) -> (usize, usize) {
        self.peek();
        let start = self.at;
        self.at = self.text.len();
        let blanks = self.text.get(start..).unwrap_or_default();
        (start, start + blanks.trim_ascii_end().len())
    }

    /// Nothing but blanks may follow.
    pub(super) fn end(&mut self) -> Result<(), OkumaSyntaxError> {
        if self.peek().is_none() { Ok(()) } else { Err(OkumaSyntaxError::Behind(self.at + 1)) }
    }
}
