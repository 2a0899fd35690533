//! The text of a block, where it is not simply the line of the file.
//!
//! Facts: reference control-emulator.md 5.1 (a further character that ends blocks), 5.2 (tape editor). Invariant: what
//! the scanner, the pre-processor and messages about words see is one text; places in it are places in that text.

use std::sync::Arc;

use super::tape::Within;
use super::{Halt, Kernel};
use crate::diag;
use crate::mcd::source::Source;
use crate::trace::Stage;

/// The text of a block.
pub(crate) enum Reshaped<'l> {
    /// What the line holds up to the character that ends it.
    Line(&'l [u8]),
    /// One of several blocks of the line, or what the tape editor has made of it.
    Own(Arc<[u8]>),
}

impl Reshaped<'_> {
    /// The text.
    pub(crate) fn text(&self) -> &[u8] {
        match self {
            Self::Line(text) => text,
            Self::Own(text) => text,
        }
    }
}

impl Kernel<'_> {
    /// The block of a line: its part up to the character that ends blocks, after the tape editor. Sets where reading
    /// goes on.
    ///
    /// # Errors
    /// A rule of the tape editor makes the block too long, or the job is to end.
    pub(crate) fn reshape<'l>(&mut self, line: &'l [u8], number: u32) -> Result<Reshaped<'l>, Halt> {
        let (block, only) = self.part(line, number);
        let mut text = (!only).then(|| Arc::from(block));
        if let Some(tape) = &self.plan.tape {
            let (on, memory) = &mut self.tape;
            let limit = self.options.limits.block_length;
            let edited = tape.edit(block, &Within { on, longest: limit, stop: self.control.stop() }, memory);
            if self.control.cancelled() {
                return Err(Halt::Stopped);
            }
            // A step of a search is work on a byte, which is much less than an element.
            self.work(edited.work / 16)?;
            if let Some((rule, length)) = edited.long {
                let text =
                    format!("rule {} of the tape editor makes {length} bytes, a block may have {limit}", rule + 1);
                return Err(self.alarm(&diag::BLOCK_TOO_LONG, text));
            }
            if let Some(changed) = edited.text {
                self.trace('E', |_| crate::trace::edited(Stage::TapeEditor, &String::from_utf8_lossy(&changed)));
                text = Some(Arc::from(changed));
            }
            if let Some(rule) = edited.stuck {
                let text = format!(
                    "rule {} of the tape editor needs too many steps on '{}' and is left out there",
                    rule + 1,
                    self.block_text()
                );
                self.diagnose(&diag::TAPE_RULE, text);
            }
        }
        self.edited.clone_from(&text);
        Ok(match text {
            Some(text) => Reshaped::Own(text),
            None => Reshaped::Line(block),
        })
    }

    /// Blocks of a file may be other than its lines: the tape editor changes them, or a character that ends blocks is
    /// somewhere in the file.
    #[inline(always)]
    pub(super) fn is_reshaped(&mut self, source: &Source) -> bool {
        if self.plan.tape.is_some() || self.plan.scanner.eob().is_some_and(|eob| source.has(eob)) {
            return true;
        }
        if self.edited.is_some() {
            self.edited = None;
        }
        false
    }

    /// The part of a line that is the next block, and whether it is the only one of the line.
    fn part<'l>(&mut self, line: &'l [u8], number: u32) -> (&'l [u8], bool) {
        let Some(frame) = self.flow.frames.last_mut() else { return (line, true) };
        let from = std::mem::take(&mut frame.offset) as usize;
        let rest = line.get(from..).unwrap_or_default();
        let Some(end) = self.plan.scanner.block_end(rest) else { return (rest, from == 0) };
        let after = rest.get(end + 1..).unwrap_or_default();
        let last = after.trim_ascii().is_empty();
        if !last {
            (frame.next, frame.offset) = (number, (from + end + 1) as u32);
        }
        (rest.get(..end).unwrap_or_default(), from == 0 && last)
    }

    /// The trace of block delete.
    pub(crate) fn trace_deleted(&mut self, text: &[u8]) {
        let (plan, own) = (self.plan, self.block_scanner());
        let scanner = own.as_deref().unwrap_or(&plan.scanner);
        if self.traces('E')
            && let Some((active, left)) = scanner.without_deleted(text, text)
        {
            let stage = if active { Stage::DeleteOn } else { Stage::DeleteOff };
            self.trace('E', |_| crate::trace::edited(stage, String::from_utf8_lossy(&left).trim()));
        }
    }

    /// Text of the block being processed.
    pub(crate) fn current_text(&self) -> &[u8] {
        match &self.edited {
            Some(text) => text,
            None => {
                let line = self.info.source(self.file).map_or(&[][..], |source| source.line(self.line));
                let end = self.plan.scanner.block_end(line).unwrap_or(line.len());
                line.get(..end).unwrap_or_default()
            }
        }
    }
}
