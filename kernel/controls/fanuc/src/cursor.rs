//! A place in the text of a line, and the text there.
//!
//! Invariant: blanks never count; text that was taken is never looked at again.

use counterpoint_program::key_words::{StatementVocabulary, WrittenNumber};

/// Why a line cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("column {}: {text}", .at + 1)]
pub(super) struct FanucSyntaxError {
    /// Byte in the line.
    pub(super) at: usize,
    /// The expected input.
    pub(super) text: String,
    /// There are more brackets inside each other than the control has room for.
    pub(super) brackets: bool,
}

/// Deepest nesting of brackets.
pub(super) const NESTING: usize = 32;

/// Reads a line from left to right.
pub(super) struct FanucParser<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    pub(super) depth: usize,
    pub(super) names: StatementVocabulary<'a>,
    /// The value read last, if it is a number as written.
    pub(super) written: Option<WrittenNumber>,
    /// A program name in angle brackets.
    pub(super) name: Option<(u32, u32)>,
}

impl FanucParser<'_> {
    pub(super) fn error(&self, expected: &str) -> FanucSyntaxError {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let found = String::from_utf8_lossy(rest.get(..rest.len().min(12)).unwrap_or_default()).trim().to_owned();
        let found = if found.is_empty() { "the end of the block".to_owned() } else { format!("'{found}'") };
        FanucSyntaxError { at: self.at, text: format!("expected {expected}, found {found}"), brackets: false }
    }

    pub(super) fn blanks(&mut self) {
        while matches!(self.text.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    pub(super) fn peek(&mut self) -> Option<u8> {
        self.blanks();
        self.text.get(self.at).map(u8::to_ascii_uppercase)
    }

    pub(super) fn accept(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        if found {
            self.at += 1;
        }
        found
    }

    /// Letters from here on, upper case, without moving.
    pub(super) fn letters(&mut self) -> String {
        self.blanks();
        self.text
            .get(self.at..)
            .unwrap_or_default()
            .iter()
            .take_while(|b| b.is_ascii_alphabetic())
            .take(8)
            .map(|b| char::from(b.to_ascii_uppercase()))
            .collect()
    }

    /// A keyword of statements, taken; letters of a shortened one are taken as far as they agree.
    pub(super) fn keyword(&mut self, allowed: &[&'static str]) -> Option<&'static str> {
        let letters = self.letters();
        if letters.len() < 2 {
            return None;
        }
        let mut best: Option<(&'static str, usize)> = None;
        for &word in allowed {
            let common = word.bytes().zip(letters.bytes()).take_while(|(a, b)| a == b).count();
            if common >= 2 && (common == letters.len() || common == word.len()) && best.is_none_or(|(_, n)| common > n)
            {
                best = Some((word, common));
            }
        }
        let (word, common) = best?;
        self.at += common;
        Some(word)
    }

    pub(super) fn unsigned(&mut self) -> Option<u32> {
        self.blanks();
        let start = self.at;
        let mut value = 0_u32;
        while let Some(digit @ b'0'..=b'9') = self.text.get(self.at) {
            value = value.saturating_mul(10).saturating_add(u32::from(digit - b'0'));
            self.at += 1;
        }
        (self.at > start).then_some(value)
    }

    pub(super) fn nest(&mut self) -> Result<(), FanucSyntaxError> {
        self.depth += 1;
        let most = self.names.formulas.brackets.map_or(NESTING, usize::from).min(NESTING);
        if self.depth <= most {
            return Ok(());
        }
        Err(FanucSyntaxError { brackets: true, ..self.error(&format!("at most {most} levels of brackets")) })
    }
}
