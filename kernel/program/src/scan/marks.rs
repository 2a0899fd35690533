//! Marks of optional skip, comments and messages of a line, for readers of its text.
//!
//! Facts: reference control-emulator.md 5.5, 5.6. Invariant: a mark inside a comment or message has no effect.

use super::{LineScanner, find};
use crate::block::Block;
use crate::key_words::{StatementVocabulary, key_word};
use crate::syntax::Syntax;
use counterpoint_machine::Machine;

/// Whether a place of a line lies inside an expression or a statement of the pre-processor.
#[derive(Debug, Default)]
pub(super) struct Formula {
    /// Open brackets.
    pub depth: usize,
    statement: bool,
}

impl Formula {
    /// Takes the next character.
    pub(super) fn read(&mut self, names: StatementVocabulary<'_>, line: &[u8], at: usize) {
        match line.get(at) {
            Some(b'[') => self.depth += 1,
            Some(b']') => self.depth = self.depth.saturating_sub(1),
            Some(b'#') => self.statement = true,
            _ => self.statement = self.statement || key_word(names, line, at),
        }
    }

    /// Whether a skip character here is a division.
    pub(super) fn divides(&self) -> bool {
        self.depth > 0 || self.statement
    }
}

/// The end of a name of two letters or more that starts at `at`, with the contents of parentheses, brackets and
/// quotation marks after it; `at` if there is none.
pub(super) fn name_end(line: &[u8], at: usize) -> usize {
    let rest = line.get(at..).unwrap_or_default();
    let letters = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'_';
    if !(rest.len() > 1 && rest.iter().take(2).all(letters)) {
        return at;
    }
    let (mut depth, mut quoted) = (0_usize, false);
    for (length, byte) in rest.iter().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            _ if quoted => {}
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth = depth.saturating_sub(1),
            b' ' | b'\t' if depth == 0 => return at + length,
            _ => {}
        }
    }
    line.len()
}

impl LineScanner {
    /// For text that no optional skip applies to: its mark is a character like any other.
    pub fn without_marks(machine: &Machine, syntax: &'static Syntax) -> Self {
        Self { opskip: None, ..Self::new(machine, syntax, &[]) }
    }

    /// The line without skipped portions and marks, and whether a level was active; `None` without a mark. As for the
    /// pre-processor a skip character inside brackets and in statements is a division. Marks are looked for in `seen`,
    /// which has the length of the line.
    pub fn without_deleted(&self, line: &[u8], seen: &[u8]) -> Option<(bool, Vec<u8>)> {
        let mark = self.opskip.filter(|mark| memchr::memchr(*mark, seen).is_some())?;
        let (mut out, mut found, mut at) = (Vec::with_capacity(line.len()), None, 0);
        let mut formula = Formula::default();
        let kept = line;
        let line = seen;
        while let Some(&byte) = line.get(at) {
            formula.read(self.names(), line, at);
            let end = match self.comment_end(line, at) {
                Some(end) => end,
                None if byte == mark && !(self.has_custom_macro() && formula.divides()) && !self.divides(line, at) => {
                    let mut scratch = Block::default();
                    let next = self.skip(line, at, byte, &mut scratch).unwrap_or(at + 1);
                    let active = next > at + 2 || line.get(next).is_none() && next > at + 1;
                    found = Some(found.unwrap_or(false) || active);
                    at = next;
                    continue;
                }
                None => at + 1,
            };
            out.extend_from_slice(kept.get(at..end).unwrap_or_default());
            at = end;
        }
        found.map(|active| (active, out))
    }

    /// Whether a skip character divides in a line for the pre-processor of another control. It does unless only the
    /// number of the block and other marks are before it.
    fn divides(&self, line: &[u8], at: usize) -> bool {
        let leads = |byte: &u8| byte.is_ascii_digit() || b" \t/Nn:".contains(byte);
        !line.get(..at).unwrap_or_default().iter().all(leads)
            && self.syntax.needs_interpreter.is_some_and(|needs| needs(line))
    }

    /// Level of the first mark of a line, none without one.
    pub fn first_mark(&self, line: &[u8]) -> Option<u8> {
        let mark = self.opskip.filter(|mark| memchr::memchr(*mark, line).is_some())?;
        let (mut at, mut formula) = (0, Formula::default());
        while let Some(&byte) = line.get(at) {
            formula.read(self.names(), line, at);
            if byte == mark && !(self.has_custom_macro() && formula.divides()) && !self.divides(line, at) {
                return Some(self.mark(line, at).0);
            }
            at = self.comment_end(line, at).unwrap_or(at + 1);
        }
        None
    }

    /// Comments and messages of a line: whether it is a message, and its place without delimiters. The same start for
    /// both means a comment.
    pub fn remarks(&self, line: &[u8]) -> Vec<(bool, usize, usize)> {
        let mut found = Vec::new();
        let first = [&self.comment, &self.message].map(|pair| pair.as_ref().and_then(|(start, _)| start.first()));
        if !line.iter().any(|byte| first.contains(&Some(byte))) {
            return found;
        }
        let (mut at, mut formula) = (0, Formula::default());
        while at < line.len() {
            let rest = line.get(at..).unwrap_or_default();
            let kinds = [(false, &self.comment), (true, &self.message)];
            let kinds = kinds.into_iter().filter_map(|(message, pair)| Some((message, pair.as_ref()?)));
            let starts = |(_, (start, _)): &(bool, &(Vec<u8>, Vec<u8>))| !start.is_empty() && rest.starts_with(start);
            // Nothing starts inside brackets of an expression.
            let found_here =
                if self.has_custom_macro() && formula.depth > 0 { None } else { kinds.into_iter().find(starts) };
            let Some((message, (start, end))) = found_here else {
                formula.read(self.names(), line, at);
                at += 1;
                continue;
            };
            let inside = at + start.len();
            let close = if end.is_empty() { None } else { find(line, inside, end) };
            found.push((message, inside, close.unwrap_or(line.len())));
            at = close.map_or(line.len(), |close| close + end.len());
        }
        found
    }
}
