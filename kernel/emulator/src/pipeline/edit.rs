//! Stage *edit*: the text of a block where it is not simply the line of the file.
//!
//! Facts: reference control-emulator.md 5.1 (a further character that ends blocks), 5.2 (tape editor). *Invariant:* the
//! scanner, the pre-processor and messages about words see one text; places in it are places in that text.

use std::sync::Arc;

use counterpoint_channel::block_places::part_of_line;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_program::tape::Within;

use crate::channel::Kernel;
use crate::channel::macro_queries::block_scanner;
use counterpoint_channel::trace;
use counterpoint_channel::trace::{TextStage, trace_line};

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
    /// The trace of block delete.
    pub(crate) fn trace_deleted(&mut self, text: &[u8]) {
        let (tables, own) = (self.channel.tables, block_scanner(self.plan, &self.channel, &self.macros));
        let scanner = own.as_deref().unwrap_or(&tables.scanner);
        if trace::traces(&self.channel, 'E')
            && let Some((active, left)) = scanner.without_deleted(text, text)
        {
            let stage = if active { TextStage::DeleteOn } else { TextStage::DeleteOff };
            trace_line(&mut self.channel, 'E', |_| {
                counterpoint_channel::trace::edited(stage, String::from_utf8_lossy(&left).trim())
            });
        }
    }
}

/// The block of a line: its part up to the character that ends blocks, after the tape editor. Sets where reading
/// continues.
///
/// # Errors
/// A rule of the tape editor makes the block too long, or the job is to end.
pub fn reshape<'l>(kernel: &mut Kernel<'_>, line: &'l [u8], number: u32) -> Result<Reshaped<'l>, Halt> {
    let (block, only) = part_of_line(&kernel.channel, &mut kernel.flow, line, number);
    let mut text = (!only).then(|| Arc::from(block));
    if let Some(tape) = &kernel.channel.tables.edits.tape {
        let (on, memory) = &mut kernel.channel.text.tape;
        let limit = kernel.channel.env.options.limits.block_length;
        let edited = tape.edit(block, &Within { on, longest: limit, stop: kernel.ports.control.stop() }, memory);
        if kernel.ports.control.cancelled() {
            return Err(Halt::Stopped);
        }
        // A step of a search is work on a byte, which is much less than an element.
        kernel.work(edited.work / 16)?;
        if let Some((rule, length)) = edited.long {
            let text = format!("rule {} of the tape editor makes {length} bytes, a block may have {limit}", rule + 1);
            return Err(kernel.alarm(&diag::BLOCK_TOO_LONG, text));
        }
        if let Some(changed) = edited.text {
            trace_line(&mut kernel.channel, 'E', |_| {
                counterpoint_channel::trace::edited(TextStage::TapeEditor, &String::from_utf8_lossy(&changed))
            });
            text = Some(Arc::from(changed));
        }
        if let Some(rule) = edited.stuck {
            let text = format!(
                "rule {} of the tape editor needs too many steps on '{}' and is skipped for this block",
                rule + 1,
                kernel.channel.block_text()
            );
            kernel.diagnose(&diag::TAPE_RULE, text);
        }
    }
    kernel.channel.text.edited.clone_from(&text);
    Ok(match text {
        Some(text) => Reshaped::Own(text),
        None => Reshaped::Line(block),
    })
}
