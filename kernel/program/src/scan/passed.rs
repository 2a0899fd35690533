//! Parts of a line that are not words: comments, messages, portions of optional skip, the end of the block.
//!
//! Facts: reference control-emulator.md 5.5 (block delete), 5.6 (comments). Invariant: a mark inside a comment or
//! message has no effect.

use super::{LineScanner, find, marks};
use crate::block::{Block, irregular};
use crate::spot::{self, Remark};

impl LineScanner {
    /// A copy of the line with comments, skipped portions and skip marks blanked out, for the pre-processor. Inside
    /// brackets and in statements a skip character after the first word is a division.
    pub fn strip(&self, line: &[u8], out: &mut Vec<u8>, block: &mut Block) {
        block.clear();
        out.clear();
        out.extend_from_slice(line);
        let (mut at, mut formula) = (0, marks::Formula::default());
        while let Some(&byte) = line.get(at) {
            let division = Some(byte) == self.opskip && formula.divides();
            let next =
                if formula.depth > 0 && byte == b'(' || division { None } else { self.skip(line, at, byte, block) };
            if let Some(next) = next {
                out.get_mut(at..next.min(line.len())).unwrap_or_default().fill(b' ');
                at = next;
                continue;
            }
            formula.read(self.names(), line, at);
            at += 1;
        }
    }

    /// Position after a comment, message, skip mark with its portion, or end-of-block character at `at`.
    pub fn skip(&self, line: &[u8], at: usize, byte: u8, block: &mut Block) -> Option<usize> {
        // The same start for both means a comment.
        for (delimiters, message) in [(&self.comment, false), (&self.message, true)] {
            let Some((start, end)) = delimiters else { continue };
            if start.is_empty() || !line.get(at..).is_some_and(|rest| rest.starts_with(start)) {
                continue;
            }
            let inside = at + start.len();
            let close = if end.is_empty() { Some(line.len()) } else { find(line, inside, end) };
            if message {
                block.messages.push((inside as u32, close.unwrap_or(line.len()) as u32));
            }
            block.flags.irregular |= u8::from(close.is_none()) * irregular::OPEN_COMMENT;
            return Some(close.map_or(line.len(), |close| close + end.len()));
        }
        if Some(byte) == self.opskip {
            let (level, next) = self.mark(line, at);
            if self.levels & (1 << level) == 0 {
                return Some(next);
            }
            return Some(self.next_inactive_mark(line, next));
        }
        if Some(byte) == self.eob {
            return Some(at + 1);
        }
        // The end of a comment that has no start is nothing, as behind a comment within a comment.
        let (_, end) = self.comment.as_ref().filter(|(_, end)| end.first() == Some(&byte))?;
        line.get(at..)?.starts_with(end).then_some(at + end.len())
    }

    /// Level of the mark at `at`, and where it ends. On controls with a pre-processor of their own 0 is not a level.
    pub fn mark(&self, line: &[u8], at: usize) -> (u8, usize) {
        match line.get(at + 1) {
            Some(digit @ b'1'..=b'9') => (digit - b'0', at + 2),
            Some(b'0') if self.syntax.needs_interpreter.is_some() => (self.opskip_default, at + 2),
            _ => (self.opskip_default, at + 1),
        }
    }

    /// Start of the next skip mark of a level that is not active, or the end of the line.
    fn next_inactive_mark(&self, line: &[u8], from: usize) -> usize {
        let mut at = from;
        while let Some(&byte) = line.get(at) {
            if let Some(end) = self.comment_end(line, at) {
                at = end;
                continue;
            }
            if Some(byte) == self.opskip {
                let (level, _) = self.mark(line, at);
                if self.levels & (1 << level) == 0 {
                    return at;
                }
            }
            at += 1;
        }
        line.len()
    }

    /// The character that marks a block that may be skipped.
    pub fn skip_mark(&self) -> Option<u8> {
        self.opskip
    }

    /// The character that ends blocks.
    pub fn eob(&self) -> Option<u8> {
        self.eob
    }

    /// Place of the first character that ends a block, outside comments and messages.
    pub fn block_end(&self, line: &[u8]) -> Option<usize> {
        spot::block_end(line, self.eob, self.delimiters())
    }

    /// Place of the first `mark` outside comments and messages.
    pub fn outside_remarks(&self, line: &[u8], mark: u8) -> Option<usize> {
        spot::block_end(line, Some(mark), self.delimiters())
    }

    /// Where the blocks of a line begin.
    pub fn block_starts(&self, line: &[u8]) -> impl Iterator<Item = usize> {
        spot::starts(line, self.eob, self.delimiters())
    }

    fn delimiters(&self) -> impl Iterator<Item = &Remark> + Clone {
        [&self.comment, &self.message].into_iter().flatten()
    }

    /// Position after the comment or message that begins at `at`: a mark inside is none.
    pub fn comment_end(&self, line: &[u8], at: usize) -> Option<usize> {
        spot::remark_end(line, at, self.delimiters())
    }

    /// The end that a comment of this line, or of the rest of it, still waits for.
    pub fn open_comment(&self, line: &[u8]) -> Option<&[u8]> {
        let (mut at, (start, end)) =
            (0, self.comment.as_ref().filter(|(start, end)| !start.is_empty() && !end.is_empty())?);
        while let Some(found) = find(line, at, start) {
            match find(line, found + start.len(), end) {
                Some(close) => at = close + end.len(),
                None => return Some(end),
            }
        }
        None
    }

    /// Whether a comment starts at this byte of the line.
    pub fn starts_comment(&self, line: &[u8], at: usize) -> bool {
        self.delimiters()
            .any(|(start, _)| !start.is_empty() && line.get(at..).is_some_and(|rest| rest.starts_with(start)))
    }
}
