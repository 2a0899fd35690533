//! Stage *edit*: the text of a block where it is not simply the line of the file.
//!
//! Facts: reference control-emulator.md 5.1 (a further character that ends blocks), 5.2 (tape editor). *Invariant:* the
//! scanner, the pre-processor and messages about words see one text; places in it are places in that text.

use std::sync::Arc;

use crate::channel::Kernel;
use crate::trace;
use crate::trace::TextStage;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_program::source::ProgramSource;
use counterpoint_program::spot::BlockStart;
use counterpoint_program::tape::Within;

/// The text of a block.
pub enum Reshaped<'l> {
    /// The text of the line up to the character that ends it.
    Line(&'l [u8]),
    /// One of several blocks of the line, or the result of the tape editor.
    Own(Arc<[u8]>),
}

impl Reshaped<'_> {
    /// The text.
    pub fn text(&self) -> &[u8] {
        match self {
            Self::Line(text) => text,
            Self::Own(text) => text,
        }
    }
}

impl Kernel<'_> {
    /// The block of a line: its part up to the character that ends blocks, after the tape editor. Sets where reading
    /// continues.
    ///
    /// # Errors
    /// A rule of the tape editor makes the block too long, or the job is to end.
    pub fn reshape<'l>(&mut self, line: &'l [u8], number: u32) -> Result<Reshaped<'l>, Halt> {
        let (block, only) = self.part(line, number);
        let mut text = (!only).then(|| Arc::from(block));
        if let Some(tape) = &self.channel.tables.edits.tape {
            let (on, memory) = &mut self.channel.text.tape;
            let limit = self.channel.env.options.limits.block_length;
            let edited = tape.edit(block, &Within { on, longest: limit, stop: self.ports.control.stop() }, memory);
            if self.ports.control.cancelled() {
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
                self.trace('E', |_| crate::trace::edited(TextStage::TapeEditor, &String::from_utf8_lossy(&changed)));
                text = Some(Arc::from(changed));
            }
            if let Some(rule) = edited.stuck {
                let text = format!(
                    "rule {} of the tape editor needs too many steps on '{}' and is skipped for this block",
                    rule + 1,
                    self.channel.block_text()
                );
                self.diagnose(&diag::TAPE_RULE, text);
            }
        }
        self.channel.text.edited.clone_from(&text);
        Ok(match text {
            Some(text) => Reshaped::Own(text),
            None => Reshaped::Line(block),
        })
    }

    /// Whether blocks of a file may differ from its lines: the tape editor changes them, or a character that ends
    /// blocks is somewhere in the file.
    #[inline(always)]
    pub fn is_reshaped(&mut self, source: &ProgramSource) -> bool {
        let tape = self.channel.tables.edits.tape.as_ref();
        if tape.is_some_and(|tape| !tape.leaves_alone(source, &self.channel.text.tape.0))
            || self.channel.tables.scanner.eob().is_some_and(|eob| source.has(eob))
            || self.channel.tables.edits.long_comments && self.flow.frames.last().is_some_and(|frame| frame.offset > 0)
        {
            return true;
        }
        if self.channel.text.edited.is_some() {
            self.channel.text.edited = None;
        }
        false
    }

    /// The part of a line that is the next block, and whether it is the only one of the line.
    fn part<'l>(&mut self, line: &'l [u8], number: u32) -> (&'l [u8], bool) {
        let Some(frame) = self.flow.frames.last_mut() else { return (line, true) };
        let from = std::mem::take(&mut frame.offset) as usize;
        self.flow.offset = from as u32;
        let rest = line.get(from..).unwrap_or_default();
        let Some(end) = self.channel.tables.scanner.block_end(rest) else { return (rest, from == 0) };
        let after = rest.get(end + 1..).unwrap_or_default();
        let last = after.trim_ascii().is_empty();
        if !last {
            (frame.next, frame.offset) = (number, (from + end + 1) as u32);
        }
        (rest.get(..end).unwrap_or_default(), from == 0 && last)
    }

    /// The blocks of a line that are not blank, each with the byte after its end.
    pub fn blocks_of<'l>(&self, line: &'l [u8]) -> Vec<(&'l [u8], usize)> {
        let (mut from, mut found) = (0, Vec::new());
        while let Some(rest) = line.get(from..).filter(|rest| !rest.is_empty()) {
            let length = self.channel.tables.scanner.block_end(rest).unwrap_or(rest.len());
            let block = rest.get(..length).unwrap_or_default();
            from += length + 1;
            if !block.trim_ascii().is_empty() {
                found.push((block, from));
            }
        }
        found
    }

    /// Text of the block before or after the current one, none at the ends of the program. A line may have several.
    pub fn neighbour(&self, behind: bool) -> Option<String> {
        let frame = self.flow.frames.last()?;
        let source = self.channel.env.sources.get(frame.file)?;
        let text = |block: &[u8]| String::from_utf8_lossy(block).into_owned();
        if behind {
            let rest =
                self.blocks_of(source.line(frame.next)).into_iter().find(|(_, end)| *end > frame.offset as usize);
            let first = |line: u32| self.blocks_of(source.line(line)).first().map(|(block, _)| text(block));
            return match rest.filter(|_| frame.next <= frame.range.last) {
                Some((block, _)) => Some(text(block)),
                None => (frame.next.saturating_add(1)..=frame.range.last).find_map(first),
            };
        }
        let spot = self.spot();
        let own = self.blocks_of(source.line(spot.line)).into_iter().rfind(|(_, end)| *end <= spot.offset as usize);
        let last = |line: u32| self.blocks_of(source.line(line)).last().map(|(block, _)| text(block));
        own.map(|(block, _)| text(block)).or_else(|| (frame.range.first..self.channel.at.line).rev().find_map(last))
    }

    /// Where the block being processed starts. Only a block with a text of its own can start within its line.
    pub(crate) fn spot(&self) -> BlockStart {
        BlockStart {
            line: self.channel.at.line,
            offset: if self.channel.text.edited.is_some() { self.flow.offset } else { 0 },
        }
    }

    /// Where the block after another one of the current program starts.
    pub(crate) fn after(&self, spot: BlockStart) -> BlockStart {
        let file = self.flow.frames.last().map_or(self.channel.at.file, |frame| frame.file);
        let line = self.channel.env.sources.get(file).map_or(&[][..], |source| source.line(spot.line));
        let next = self.channel.tables.scanner.block_starts(line).find(|&start| start > spot.offset as usize);
        next.map_or(BlockStart::line(spot.line + 1), |start| BlockStart { line: spot.line, offset: start as u32 })
    }

    /// The trace of block delete.
    pub(crate) fn trace_deleted(&mut self, text: &[u8]) {
        let (tables, own) = (self.channel.tables, self.block_scanner());
        let scanner = own.as_deref().unwrap_or(&tables.scanner);
        if trace::traces(&self.channel, 'E')
            && let Some((active, left)) = scanner.without_deleted(text, text)
        {
            let stage = if active { TextStage::DeleteOn } else { TextStage::DeleteOff };
            self.trace('E', |_| crate::trace::edited(stage, String::from_utf8_lossy(&left).trim()));
        }
    }
}
