//! Subprogram startup and shutdown macros, once for each pass, and calls and returns inside macros.
//!
//! Facts: reference control-emulator.md 4.1, 5.7. A call of a range of blocks has type 1 and the sequence numbers or
//! labels in `$P3` and `$P4`; a call of a program has type 2 and its number in `$P2`. Decisions: `$P2` is the number or
//! name of the program, `$P10` counts lines before the program, so that 0 is the top of the file, and `$P9` is the file
//! of the machine's placement where a missing program was looked for; a startup macro can send a call to any file of
//! the job.

use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::flow::CallRecord;
use counterpoint_channel::macros::calls::{OutputTask, TICKS};
use counterpoint_emulator::pipeline::follow::return_from;
use counterpoint_event::event::FileId;
use counterpoint_event::info::JobFile;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::model::MainReturn;
use counterpoint_machine::stored::StoredFile;
use counterpoint_program::shape::ProgramRange;

use crate::context::MacroHooks;

/// Where a subprogram is, if anywhere.
type Found = Option<(FileId, ProgramRange)>;

impl MacroHooks<'_, '_> {
    /// Runs the startup macro for a pass: none if the call is ignored, otherwise where the subprogram is.
    pub(crate) fn subprogram_startup(
        &mut self,
        called: &CallRecord,
        pass: u32,
        found: Found,
        level: usize,
    ) -> Result<Option<Found>, Halt> {
        let Some(code) = self.kernel.macros.ready(Hook::SubprogramStartup) else { return Ok(Some(found)) };
        let mut arguments = self.call_arguments(called, pass, found, level);
        let (file, offset) = (arguments[8].clone(), arguments[9].clone());
        self.run_macro(code, OutputTask::None, &mut arguments)?;
        match arguments[0].as_real() {
            Some(0.0) => return Ok(None),
            Some(-1.0) => return Ok(Some(None)),
            _ => {}
        }
        let same = arguments[8].equals(&file) == Some(true) && arguments[9].equals(&offset) == Some(true);
        if same {
            return Ok(Some(found));
        }
        let wanted = arguments[8].as_text().unwrap_or("").trim().to_owned();
        let line = arguments[9].as_real().filter(|offset| (0.0..=f64::from(u32::MAX - 1)).contains(offset));
        let Some(line) = line.map(|offset| offset as u32 + 1) else { return Ok(Some(None)) };
        self.place_in_file(&wanted, line).map(Some)
    }

    /// Runs the shutdown macro of a pass.
    pub(crate) fn subprogram_shutdown(
        &mut self,
        called: &CallRecord,
        pass: u32,
        place: (FileId, ProgramRange),
        level: usize,
    ) -> Acted {
        let Some(code) = self.kernel.macros.ready(Hook::SubprogramShutdown) else { return Ok(()) };
        let mut arguments = self.call_arguments(called, pass, Some(place), level);
        self.run_macro(code, OutputTask::None, &mut arguments).map(|_| ())
    }

    /// Between two passes of a subprogram.
    pub(crate) fn next_pass(&mut self) -> Acted {
        let Some(frame) = self.kernel.flow.frames.last() else { return Ok(()) };
        let (called, here) = (frame.called.clone(), (frame.file, frame.range));
        let pass = called.passes.saturating_sub(frame.repeats + 1);
        let level = self.kernel.flow.frames.len() - 1;
        self.subprogram_shutdown(&called, pass.saturating_sub(1), here, level)?;
        match self.subprogram_startup(&called, pass, Some(here), level)? {
            Some(Some((file, range))) => {
                if let Some(frame) = self.kernel.flow.frames.last_mut() {
                    (frame.file, frame.range, frame.next) = (file, range, range.first);
                }
                Ok(())
            }
            Some(None) => {
                let text = format!("{} not found, as the startup macro reports", called.what);
                Err(self.kernel.alarm(&diag::SUBPROGRAM_MISSING, text))
            }
            // Skip this pass and all later ones: a macro called billions of times would never end.
            None => {
                if let Some(frame) = self.kernel.flow.frames.last_mut() {
                    frame.repeats = 0;
                }
                return_from(self.kernel, None)
            }
        }
    }

    fn call_arguments(&self, called: &CallRecord, pass: u32, found: Found, level: usize) -> [MacroValue; 10] {
        let (file, offset) = match found {
            Some((file, range)) => {
                (self.kernel.channel.env.info.file_name(file).to_owned(), f64::from(range.first.saturating_sub(1)))
            }
            None => (self.kernel.looked_for(&called.what), -1.0),
        };
        let (kind, number, (first, last)) = match &called.what {
            Callee::Program(number) => (2.0, number.to_string(), (0, 0)),
            Callee::ProgramFrom(number, first) => (2.0, number.to_string(), (*first, 0)),
            Callee::Named(name) => (2.0, name.to_string(), (0, 0)),
            Callee::From(first) => (1.0, String::new(), (*first, 0)),
            Callee::Blocks(first, last) | Callee::Labels(first, last) => (1.0, String::new(), (*first, *last)),
        };
        [
            MacroValue::Real(kind),
            MacroValue::text(number),
            MacroValue::Real(f64::from(first)),
            MacroValue::Real(f64::from(last)),
            MacroValue::Real(f64::from(called.passes.saturating_sub(1))),
            MacroValue::text(called.block.as_deref().unwrap_or_default()),
            MacroValue::Real(level as f64),
            MacroValue::Real(f64::from(pass)),
            MacroValue::text(file),
            MacroValue::Real(offset),
        ]
    }

    /// The program around a line of a file of the job.
    pub(crate) fn place_in_file(&mut self, name: &str, line: u32) -> Result<Found, Halt> {
        // Files stored with the machine are found in any letter case.
        let stored =
            name.get(..StoredFile::ROOT.len()).is_some_and(|start| start.eq_ignore_ascii_case(StoredFile::ROOT));
        let is = |file: &JobFile| file.name == name || stored && file.name.eq_ignore_ascii_case(name);
        let Some(file) = self.kernel.channel.env.info.files.iter().position(is) else { return Ok(None) };
        let file = file as FileId;
        self.kernel.load(file)?;
        let sources = self.kernel.channel.env.sources;
        let Some(source) = sources.get(file).filter(|source| line <= source.lines()) else {
            return Ok(None);
        };
        let around = source.programs().iter().find(|range| (range.first..=range.last).contains(&line));
        let last = around.map_or(source.lines(), |range| range.last);
        Ok(Some((file, ProgramRange { number: around.and_then(|range| range.number), first: line, last })))
    }

    /// Executes the call or return of a block inside another block before the macro continues: the whole subprogram, or
    /// the return to the caller.
    pub(crate) fn call_at_once(&mut self) -> Acted {
        use Pending::{Call, CallRange, CallText, Contour, Return};
        match self.kernel.flow.pending {
            Some(Call { .. } | CallRange { .. } | CallText(_) | Contour(_)) => {}
            Some(Return(target)) if self.may_return_at_once(target) => {}
            _ => return Ok(()),
        }
        let level = self.kernel.flow.frames.len();
        let place = (self.kernel.channel.at.block_place(), self.kernel.channel.text.edited.clone());
        let runtime = &mut *self.kernel.macros;
        let later = std::mem::take(&mut runtime.issued.later);
        let matching = std::mem::replace(&mut runtime.hooks.matching, true);
        let ticks = runtime.calls.ticks(None);
        let mut done = self.kernel.follow();
        while done.is_ok() && self.kernel.flow.frames.len() > level {
            // Its blocks are blocks of the program: they do not use up the budget of the calling macro.
            self.kernel.macros.calls.ticks(Some(TICKS));
            done = self.kernel.step();
        }
        self.kernel.channel.at.go_to(place.0);
        self.kernel.channel.text.edited = place.1;
        let runtime = &mut *self.kernel.macros;
        runtime.calls.ticks(ticks);
        runtime.hooks.matching = matching;
        // Blocks that its last block queued come after those queued before.
        let own = std::mem::replace(&mut runtime.issued.later, later);
        runtime.issued.later.extend(own);
        done
    }

    /// Whether a return may happen at once. It waits for the end of the interrupted block if it would end the run, or
    /// pull the text away from a pre-processor that is reading it.
    fn may_return_at_once(&self, target: Option<u32>) -> bool {
        let has_interpreter = self.kernel.channel.tables.scanner.syntax().needs_interpreter.is_some();
        let reading = has_interpreter && self.kernel.dialect.interpreter.is_none();
        let ends = self.kernel.flow.frames.len() <= 1
            && self.kernel.channel.env.machine.subprograms.main_return == MainReturn::End;
        !reading && (!ends || target.is_some())
    }
}
