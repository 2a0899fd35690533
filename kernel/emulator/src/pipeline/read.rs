//! Stage *read*: the block loop takes the next block, from a file or from the queue of EXEC/NEXT.
//!
//! Facts: reference control-emulator.md 2.2 and 5.1.

use std::sync::Arc;

use counterpoint_channel::at::BlockPlace;
use counterpoint_channel::block_places::is_reshaped;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_event::event::{BlockEvent, FileId, Kind};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::model::{ProgramTextFormat, RewindStop};
use counterpoint_program::sections;
use counterpoint_program::shape::ProgramDelimiters;
use counterpoint_program::source::ProgramSource;

use crate::channel::Kernel;
use crate::channel::dialect_state::DialectState;
use crate::channel::known_blocks::{execute_known_block, leads_on};
use crate::pipeline::definitions::runs_into_definition;
use crate::pipeline::edit::reshape;
use crate::pipeline::follow::return_from;
use crate::pipeline::long_comments::pass_long_comment;
use crate::pipeline::process_block;
use crate::pipeline::unit_named::check_unit_named;

impl Kernel<'_> {
    /// Runs blocks until something ends the program.
    pub fn program(&mut self) -> Halt {
        loop {
            if let Err(halt) = next_block(self) {
                return self.end_compensation(halt);
            }
        }
    }

    /// One block, within another one.
    #[inline(never)]
    pub fn step(&mut self) -> Acted {
        next_block(self)
    }

    /// Makes a file's text available.
    pub fn load(&mut self, file: FileId) -> Acted {
        let (info, machine) = (self.channel.env.info, self.channel.env.machine);
        let Some(entry) = info.files.get(usize::from(file)) else { return Ok(()) };
        if self.channel.env.sources.is_known(file) {
            return Ok(());
        }
        let (name, shape, stop) = (
            entry.name.clone(),
            Arc::new(ProgramDelimiters::of(machine, self.channel.tables.scanner.syntax())),
            self.ports.control.stop().clone(),
        );
        let (source, failure) = match self.channel.env.files.read(&name) {
            Ok(bytes) => (Some(Arc::new(sections::source(name, bytes, shape, stop, machine))), None),
            Err(error) => (None, Some(error)),
        };
        if self.ports.control.cancelled() {
            // The lines of the text may not all be known.
            return Err(Halt::Stopped);
        }
        // Another kernel may have loaded the text in the meantime.
        self.channel.env.sources.put(file, source, &entry.text);
        match failure {
            None => Ok(()),
            Some(error) => Err(self.fatal(&diag::FILE_UNREADABLE, error.to_string())),
        }
    }
}

/// One block.
#[inline(always)]
fn next_block(kernel: &mut Kernel<'_>) -> Acted {
    let done = one_block(kernel);
    kernel.went_on(done)
}

#[inline(always)]
fn one_block(kernel: &mut Kernel<'_>) -> Acted {
    let hooks = kernel.plan.hooks;
    if let Some(done) = hooks.and_then(|hooks| (hooks.block.next)(kernel)) {
        return done;
    }
    let sources = kernel.channel.env.sources;
    let Some(frame) = kernel.flow.frame() else { return Err(Halt::ProgramEnd(None)) };
    let (file, line, caller) = (frame.file, frame.next, frame.caller);
    if line > frame.range.last {
        return text_ends(kernel);
    }
    frame.next = line + 1;
    let Some(source) = sources.get(file) else { return Err(Halt::ProgramEnd(None)) };
    if kernel.flow.repeats && hooks.is_none() && is_as_read(&mut kernel.channel, &kernel.flow, source) {
        let known = leads_on(kernel.plan, &kernel.channel, &kernel.flow, (file, line));
        if known.is_some() || executes(&mut kernel.dialect, (file, line)) {
            kernel.channel.at.go_to(BlockPlace { file, line, caller });
            begin_block(kernel)?;
            match &known {
                Some(known) => execute_known_block(&mut kernel.channel, &mut kernel.flow, known),
                None => kernel.known_statement(source)?,
            }
            return kernel.follow();
        }
    }
    let text = source.line(line);
    if text.iter().all(|b| matches!(b, b' ' | b'\t')) {
        return Ok(());
    }
    kernel.channel.at.go_to(BlockPlace { file, line, caller });
    begin_block(kernel)?;
    if text.len() > kernel.channel.env.options.limits.block_length {
        return Err(too_long(kernel, text.len()));
    }
    let held;
    let text = if kernel.channel.tables.edits.reshapes && is_reshaped(&mut kernel.channel, &kernel.flow, source) {
        held = reshape(kernel, text, line)?;
        let text = held.text();
        if text.trim_ascii().is_empty() {
            return Ok(());
        }
        text
    } else {
        text
    };
    if kernel.channel.tables.edits.long_comments {
        pass_long_comment(kernel, source, line, text)?;
    }
    if is_rewind_stop(&kernel.channel, text) {
        return rewind_stop(kernel, source, line);
    }
    if !kernel.flow.opened {
        kernel.flow.opened = true;
        if kernel.channel.env.machine.format.rws_at == RewindStop::Start {
            kernel.diagnose(&diag::NO_REWIND_STOP, "no rewind-stop before the program; it starts with its first block");
        }
        check_encoding(kernel, source);
        check_unit_named(kernel, source.text().bytes());
    }
    if let Some(hooks) = hooks {
        (hooks.block.begin)(kernel);
    }
    if let Some(block) = before_rewind_stop(&kernel.channel, text) {
        return last_of_tape(kernel, block, (file, line));
    }
    process_block(kernel, text)?;
    kernel.follow()
}

/// Reports that results cannot show the original text of a file.
#[cold]
fn check_encoding(kernel: &mut Kernel<'_>, source: &ProgramSource) {
    let Err(error) = std::str::from_utf8(source.text().bytes()) else { return };
    let before = source.text().bytes().get(..error.valid_up_to()).unwrap_or_default();
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    let text = format!(
        "{} has bytes that are not UTF-8, first in line {line}, and results show \u{fffd} there; name its code page, \
         for example with --encoding windows-1252",
        source.name
    );
    kernel.diagnose(&diag::NOT_UTF8, &text);
}

/// A block at the end of whose line the tape ends; more text is reported, as that behind a rewind-stop of its own
/// line.
#[cold]
fn last_of_tape(kernel: &mut Kernel<'_>, block: &[u8], (file, line): (FileId, u32)) -> Acted {
    // A part of its line, so nothing is kept for the line.
    let read = kernel.channel.text.edited.replace(block.into());
    let done = process_block(kernel, block);
    kernel.channel.text.edited = read;
    done?;
    kernel.follow()?;
    let goes_on = kernel.flow.frame().is_some_and(|frame| (frame.file, frame.next) == (file, line + 1));
    match kernel.channel.env.sources.get(file).filter(|_| goes_on) {
        Some(source) => rewind_stop(kernel, source, line),
        None => Ok(()),
    }
}

/// Counts the block, publishes the progress of this kernel, and checks the limits.
#[inline(always)]
pub fn begin_block(kernel: &mut Kernel<'_>) -> Acted {
    use std::sync::atomic::Ordering::Relaxed;
    kernel.channel.keep_pace();
    kernel.channel.state.remembered.remember_sequence(kernel.channel.block.sequence);
    kernel.channel.at.blocks += 1;
    kernel.channel.at.idle_blocks += 1;
    if !kernel.channel.at.caller.is_some() {
        kernel.channel.at.user_blocks += 1;
        kernel.ports.progress.blocks.store(kernel.channel.at.user_blocks, Relaxed);
        kernel.ports.progress.line.store(kernel.channel.at.line, Relaxed);
        kernel.ports.progress.file.store(u32::from(kernel.channel.at.file), Relaxed);
    }
    kernel.ports.progress.t_ns.store(kernel.channel.at.clock, Relaxed);
    let goes_on =
        kernel.ports.coordinator.publish(kernel.channel.at.channel, kernel.channel.emitter.bound(&kernel.channel.at));
    if !goes_on || kernel.ports.control.interferes() {
        kernel.interfered(goes_on)?;
    }
    if kernel.channel.at.blocks.is_multiple_of(256) {
        now_and_then(kernel)?;
    }
    let number = kernel.channel.at.blocks - kernel.channel.at.made_blocks;
    let block = BlockEvent { number, unit_named: std::mem::take(&mut kernel.channel.reports.unit_named) };
    kernel.channel.emitter.emit_as(&kernel.channel.at, 0, |kind| match kind {
        // Overwrites the old value; a kind of another shape is dropped first.
        Kind::Block(place) => *place = block,
        other => *other = Kind::Block(block),
    });
    kernel.check_limits()
}

/// Checks made every 256 blocks: whether another kernel waits for the processor, and moves kept back too long.
#[cold]
#[inline(never)]
fn now_and_then(kernel: &mut Kernel<'_>) -> Acted {
    if kernel.ports.coordinator.should_yield() {
        kernel.channel.flush();
        kernel.ports.coordinator.yield_permit(kernel.channel.at.channel);
    }
    if kernel.channel.state.place.frames.is_some() { kernel.flush_old() } else { Ok(()) }
}

/// Handles a rewind-stop: it opens or closes the text, or is ignored with a warning.
fn rewind_stop(kernel: &mut Kernel<'_>, source: &ProgramSource, line: u32) -> Acted {
    if !kernel.flow.opened {
        kernel.flow.opened = true;
        return Ok(());
    }
    let rest = source.walk(line + 1, source.lines()).all(|n| source.line(n).iter().all(u8::is_ascii_whitespace));
    if rest {
        return text_ends(kernel);
    }
    let text = format!("the rewind-stop in line {line} inside the program is skipped");
    kernel.diagnose(&diag::REWIND_STOP_INSIDE, text);
    Ok(())
}

/// The text of a program ends without an end or return code.
pub fn text_ends(kernel: &mut Kernel<'_>) -> Acted {
    if kernel.flow.frames.last().is_some_and(|frame| frame.closes) {
        return return_from(kernel, None);
    }
    if runs_into_definition(kernel) {
        return Ok(());
    }
    if !ends_with_another_head(&kernel.channel, &kernel.flow) {
        let name = kernel.flow.frames.last().map_or_else(String::new, |f| f.name.to_string());
        kernel.diagnose(&diag::NO_PROGRAM_END, format!("the text of {name} ends without an end code"));
    }
    if kernel.flow.frames.len() > 1 { return_from(kernel, None) } else { Err(Halt::ProgramEnd(None)) }
}

/// Reports a block that is longer than the job allows.
pub fn too_long(kernel: &mut Kernel<'_>, length: usize) -> Halt {
    let limit = kernel.channel.env.options.limits.block_length;
    let text = format!("line {} has {length} bytes, a block may have {limit}", kernel.channel.at.line);
    kernel.alarm(&diag::BLOCK_TOO_LONG, text)
}

/// Whether lines of the file are blocks without changes, and no macro or trace needs their text.
#[inline(always)]
fn is_as_read(channel: &mut ChannelContext<'_>, flow: &ProgramFlow, source: &ProgramSource) -> bool {
    let reshapes =
        channel.tables.edits.reshapes && (channel.tables.edits.long_comments || is_reshaped(channel, flow, source));
    !reshapes && channel.env.trace.is_none()
}

/// Whether the line is a statement that was executed before.
#[inline(always)]
fn executes(dialect: &mut DialectState, line: (FileId, u32)) -> bool {
    dialect.interpreter.as_deref_mut().is_some_and(|interpreter| interpreter.executes(line))
}

/// The block before a rewind-stop at the end of its line, where one may be there.
#[inline(always)]
pub fn before_rewind_stop<'l>(channel: &ChannelContext<'_>, text: &'l [u8]) -> Option<&'l [u8]> {
    let format = &channel.env.machine.format;
    // The last byte decides about most blocks.
    if !format.rws_inline || text.trim_ascii_end().last() != format.rws.as_bytes().last() {
        return None;
    }
    if !text.trim_ascii_end().ends_with(format.rws.as_bytes()) {
        return None;
    }
    let end = channel.tables.scanner.outside_remarks(text, *format.rws.as_bytes().first()?)?;
    text.get(..end)
}

/// Whether a line is the rewind stop.
#[inline(always)]
pub fn is_rewind_stop(channel: &ChannelContext<'_>, text: &[u8]) -> bool {
    let format = &channel.env.machine.format;
    let begins = text.first() == format.rws.as_bytes().first() || text.first().is_some_and(u8::is_ascii_whitespace);
    begins && is_stop(text, format)
}

/// Whether one program of all heads has its end code in the last stretch of another head.
fn ends_with_another_head(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> bool {
    let whole = channel.env.sources.whole(channel.at.file).filter(|_| flow.frames.len() == 1);
    whole.is_some_and(|whole| sections::ends_for_all(channel.env.machine, whole, channel.at.channel))
}

/// Whether a line that may be a rewind-stop is one.
#[inline(never)]
fn is_stop(text: &[u8], format: &ProgramTextFormat) -> bool {
    format.is_rewind_stop(text)
}
