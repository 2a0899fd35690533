//! The text of a block, where it is not simply the line of the file.
//!
//! Facts: reference control-emulator.md 5.1 (a further character that ends blocks), 5.2 (tape editor). Invariant: what
//! the scanner, the pre-processor and messages about words see is one text; places in it are places in that text.

use std::sync::Arc;

use super::{Halt, Kernel};
use crate::diag;
use crate::trace::Stage;

impl Kernel<'_> {
    /// The block of a line: its part up to the character that ends blocks, after the tape editor. `None` = the line as
    /// it is. Sets where reading goes on.
    ///
    /// # Errors
    /// A rule of the tape editor makes the block too long, or the job is to end.
    pub(crate) fn reshape(&mut self, line: &[u8], number: u32) -> Result<Option<Arc<[u8]>>, Halt> {
        let block = self.part(line, number);
        let mut text = (block.len() < line.len()).then(|| Arc::from(block));
        if let Some(tape) = &self.plan.tape {
            let (on, memory) = &mut self.tape;
            let limit = self.options.limits.block_length;
            let edited = tape.edit(block, on, limit, memory);
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
        Ok(text)
    }

    /// The part of a line that is the next block.
    fn part<'l>(&mut self, line: &'l [u8], number: u32) -> &'l [u8] {
        if self.machine.format.eob.is_none() {
            return line;
        }
        let scanner = &self.plan.scanner;
        let Some(frame) = self.flow.frames.last_mut() else { return line };
        let from = std::mem::take(&mut frame.offset) as usize;
        let rest = line.get(from..).unwrap_or_default();
        let Some(end) = scanner.block_end(rest) else { return rest };
        let after = rest.get(end + 1..).unwrap_or_default();
        if !after.trim_ascii().is_empty() {
            (frame.next, frame.offset) = (number, (from + end + 1) as u32);
        }
        rest.get(..end).unwrap_or_default()
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
            None => self.info.source(self.file).map_or(&[][..], |source| source.line(self.line)),
        }
    }
}
