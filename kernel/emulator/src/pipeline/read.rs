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

impl Kernel<'_> {
    /// Runs blocks until something ends the program.
    pub fn program(&mut self) -> Halt {
        loop {
            if let Err(halt) = self.next_block() {
                return self.end_compensation(halt);
            }
        }
    }

    /// One block, within another one.
    #[inline(never)]
    pub fn step(&mut self) -> Acted {
        self.next_block()
    }

    /// One block.
    #[inline(always)]
    fn next_block(&mut self) -> Acted {
        let done = self.one_block();
        self.went_on(done)
    }

    #[inline(always)]
    fn one_block(&mut self) -> Acted {
        let hooks = self.plan.hooks;
        if let Some(done) = hooks.and_then(|hooks| (hooks.block.next)(self)) {
            return done;
        }
        let sources = self.channel.env.sources;
        let Some(frame) = self.flow.frame() else { return Err(Halt::ProgramEnd(None)) };
        let (file, line, caller) = (frame.file, frame.next, frame.caller);
        if line > frame.range.last {
            return self.text_ends();
        }
        frame.next = line + 1;
        let Some(source) = sources.get(file) else { return Err(Halt::ProgramEnd(None)) };
        if self.flow.repeats && hooks.is_none() && is_as_read(&mut self.channel, &self.flow, source) {
            let known = leads_on(self.plan, &self.channel, &self.flow, (file, line));
            if known.is_some() || executes(&mut self.dialect, (file, line)) {
                self.channel.at.go_to(BlockPlace { file, line, caller });
                self.begin_block()?;
                match &known {
                    Some(known) => execute_known_block(&mut self.channel, &mut self.flow, known),
                    None => self.known_statement(source)?,
                }
                return self.follow();
            }
        }
        let text = source.line(line);
        if text.iter().all(|b| matches!(b, b' ' | b'\t')) {
            return Ok(());
        }
        self.channel.at.go_to(BlockPlace { file, line, caller });
        self.begin_block()?;
        if text.len() > self.channel.env.options.limits.block_length {
            return Err(self.too_long(text.len()));
        }
        let held;
        let text = if self.channel.tables.edits.reshapes && is_reshaped(&mut self.channel, &self.flow, source) {
            held = self.reshape(text, line)?;
            let text = held.text();
            if text.trim_ascii().is_empty() {
                return Ok(());
            }
            text
        } else {
            text
        };
        if self.channel.tables.edits.long_comments {
            self.pass_long_comment(source, line, text)?;
        }
        if is_rewind_stop(&self.channel, text) {
            return self.rewind_stop(source, line);
        }
        if !self.flow.opened {
            self.flow.opened = true;
            if self.channel.env.machine.format.rws_at == RewindStop::Start {
                self.diagnose(
                    &diag::NO_REWIND_STOP,
                    "no rewind-stop before the program; it starts with its first block",
                );
            }
            self.check_encoding(source);
            self.check_unit_named(source.text().bytes());
        }
        if let Some(hooks) = hooks {
            (hooks.block.begin)(self);
        }
        if let Some(block) = before_rewind_stop(&self.channel, text) {
            return self.last_of_tape(block, (file, line));
        }
        self.block(text)?;
        self.follow()
    }

    /// Says that results cannot show the text of a file as it was written.
    #[cold]
    fn check_encoding(&mut self, source: &ProgramSource) {
        let Err(error) = std::str::from_utf8(source.text().bytes()) else { return };
        let before = source.text().bytes().get(..error.valid_up_to()).unwrap_or_default();
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        let text = format!(
            "{} has bytes that are not UTF-8, first in line {line}, and results show \u{fffd} there; name its code page, \
             for example with --encoding windows-1252",
            source.name
        );
        self.diagnose(&diag::NOT_UTF8, &text);
    }

    /// A block at the end of whose line the tape ends; more text is reported, as that behind a rewind-stop of its own
    /// line.
    #[cold]
    fn last_of_tape(&mut self, block: &[u8], (file, line): (FileId, u32)) -> Acted {
        // A part of its line, so nothing is kept for the line.
        let read = self.channel.text.edited.replace(block.into());
        let done = self.block(block);
        self.channel.text.edited = read;
        done?;
        self.follow()?;
        let goes_on = self.flow.frame().is_some_and(|frame| (frame.file, frame.next) == (file, line + 1));
        match self.channel.env.sources.get(file).filter(|_| goes_on) {
            Some(source) => self.rewind_stop(source, line),
            None => Ok(()),
        }
    }

    /// Counts the block, publishes how far this kernel is, and checks the limits.
    #[inline(always)]
    pub fn begin_block(&mut self) -> Acted {
        use std::sync::atomic::Ordering::Relaxed;
        self.channel.keep_pace();
        self.channel.state.remembered.remember_sequence(self.channel.block.sequence);
        self.channel.at.blocks += 1;
        self.channel.at.idle_blocks += 1;
        if !self.channel.at.caller.is_some() {
            self.channel.at.user_blocks += 1;
            self.ports.progress.blocks.store(self.channel.at.user_blocks, Relaxed);
            self.ports.progress.line.store(self.channel.at.line, Relaxed);
            self.ports.progress.file.store(u32::from(self.channel.at.file), Relaxed);
        }
        self.ports.progress.t_ns.store(self.channel.at.clock, Relaxed);
        let goes_on =
            self.ports.coordinator.publish(self.channel.at.channel, self.channel.emitter.bound(&self.channel.at));
        if !goes_on || self.ports.control.interferes() {
            self.interfered(goes_on)?;
        }
        if self.channel.at.blocks.is_multiple_of(256) {
            self.now_and_then()?;
        }
        let number = self.channel.at.blocks - self.channel.at.made_blocks;
        let block = BlockEvent { number, unit_named: std::mem::take(&mut self.channel.reports.unit_named) };
        self.channel.emitter.emit_as(&self.channel.at, 0, |kind| match kind {
            // Overwrites the old value; a kind of another shape is dropped first.
            Kind::Block(place) => *place = block,
            other => *other = Kind::Block(block),
        });
        self.check_limits()
    }

    /// Checks made every 256 blocks: whether another kernel waits for the processor, and moves kept back too long.
    #[cold]
    #[inline(never)]
    fn now_and_then(&mut self) -> Acted {
        if self.ports.coordinator.should_yield() {
            self.channel.flush();
            self.ports.coordinator.yield_permit(self.channel.at.channel);
        }
        if self.channel.state.place.frames.is_some() { self.flush_old() } else { Ok(()) }
    }

    /// A rewind-stop: opens the text, closes it, or is ignored with a warning.
    fn rewind_stop(&mut self, source: &ProgramSource, line: u32) -> Acted {
        if !self.flow.opened {
            self.flow.opened = true;
            return Ok(());
        }
        let rest = source.walk(line + 1, source.lines()).all(|n| source.line(n).iter().all(u8::is_ascii_whitespace));
        if rest {
            return self.text_ends();
        }
        let text = format!("the rewind-stop in line {line} inside the program is skipped");
        self.diagnose(&diag::REWIND_STOP_INSIDE, text);
        Ok(())
    }

    /// The text of a program ends without an end or return code.
    pub fn text_ends(&mut self) -> Acted {
        if self.flow.frames.last().is_some_and(|frame| frame.closes) {
            return self.return_from(None);
        }
        if self.runs_into_definition() {
            return Ok(());
        }
        if !ends_with_another_head(&self.channel, &self.flow) {
            let name = self.flow.frames.last().map_or_else(String::new, |f| f.name.to_string());
            self.diagnose(&diag::NO_PROGRAM_END, format!("the text of {name} ends without an end code"));
        }
        if self.flow.frames.len() > 1 { self.return_from(None) } else { Err(Halt::ProgramEnd(None)) }
    }

    /// Reports a block that is longer than the job allows.
    pub fn too_long(&mut self, length: usize) -> Halt {
        let limit = self.channel.env.options.limits.block_length;
        let text = format!("line {} has {length} bytes, a block may have {limit}", self.channel.at.line);
        self.alarm(&diag::BLOCK_TOO_LONG, text)
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
        // Another kernel may have been faster.
        self.channel.env.sources.put(file, source, &entry.text);
        match failure {
            None => Ok(()),
            Some(error) => Err(self.fatal(&diag::FILE_UNREADABLE, error.to_string())),
        }
    }
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
