//! Stage *follow*: executes the requests of a block for its end (a call, a return, the end), and jumps.
//!
//! Facts: reference control-emulator.md 5.7. *Invariant:* nesting is bounded; a backward jump is always counted.

use std::sync::Arc;

use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::calling_words::CallingWord;
use counterpoint_channel::code_time::end_functions;
use counterpoint_channel::figure::CopiedFigure;
use counterpoint_channel::flow::RunningProgram;
use counterpoint_channel::program_places::find_range;
use counterpoint_control_api as dialect;
use counterpoint_event::event::{Kind, Return, SubprogramEntry};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::model::MainReturn;
use counterpoint_program::spot::BlockStart;

use crate::channel::Kernel;
use crate::channel::macro_queries::call_record;
use crate::channel::statement::interpreter_repeat;

impl Kernel<'_> {
    /// Executes the block's deferred call, return or end.
    #[inline(always)]
    pub fn follow(&mut self) -> Acted {
        self.channel.check_stop()?;
        if self.channel.tables.rules.overlaps {
            end_functions(&mut self.channel);
        }
        let flow = &self.flow;
        if flow.pending.is_some() || !flow.modal.is_empty() || flow.modal_text { self.follow_up() } else { Ok(()) }
    }

    #[inline(never)]
    fn follow_up(&mut self) -> Acted {
        if self.flow.pending.is_none() {
            if self.flow.modal_text && std::mem::take(&mut self.channel.block.flags.moved) {
                self.with_interpreter(|interpreter, kernel| interpreter.on_move(kernel));
            }
            self.flow.call_modally(&mut self.channel.block);
        }
        match self.flow.pending.take() {
            None => Ok(()),
            Some(Pending::Call { what, passes, arguments, by }) => self.call(what, passes, arguments, by),
            Some(Pending::Figure { program, passes, figure }) => self.call_figure(program, passes, figure),
            Some(Pending::CallRange { what, passes }) => self.call_range(what, passes),
            Some(Pending::CallText(call)) => self.call_text(*call),
            Some(Pending::Contour(cycle)) => self.contour_cycle(&cycle),
            Some(Pending::ReadContour(call)) => self.read_subprogram(*call),
            Some(Pending::Strip(strip)) => (self.plan.actions.strip)(self, &strip),
            Some(Pending::DataBlocks) => self.pass_data_blocks(),
            Some(Pending::Return(target)) => self.return_from(target),
            Some(Pending::End(stop)) => {
                if self.flow.modal_text {
                    self.with_interpreter(|interpreter, kernel| interpreter.on_end(kernel));
                    self.channel.check_stop()?;
                }
                Err(Halt::ProgramEnd(Some(stop)))
            }
        }?;
        match self.flow.pending {
            // Programmed by a macro around the call.
            Some(Pending::End(stop)) => Err(Halt::ProgramEnd(Some(stop))),
            _ => Ok(()),
        }
    }

    /// Records the request of the block for its end: the last call or return counts, an end code in any case.
    pub fn ask(&mut self, pending: Pending) {
        match &self.flow.pending {
            Some(Pending::End(_)) => return,
            Some(Pending::Call { what, .. } | Pending::CallRange { what, .. }) => {
                let text =
                    format!("{what} is not called: '{}' has another call, return or end", self.channel.block_text());
                self.diagnose(&diag::SECOND_CALL, text);
            }
            _ => {}
        }
        self.flow.pending = Some(pending);
    }

    fn call(
        &mut self,
        what: Callee,
        passes: u32,
        arguments: Option<Vec<(u8, f64)>>,
        by: Option<Box<CallingWord>>,
    ) -> Acted {
        let modal = self.flow.modal.take_caller();
        self.check_nesting(|| match &what {
            Callee::Program(number) => number.to_string(),
            other => other.to_string(),
        })?;
        self.check_levels(arguments.is_some(), &what)?;
        let mut found = self.find_program(&what)?;
        let called = call_record(self.plan, &self.channel, what.clone(), passes);
        if let Some(hooks) = self.plan.hooks {
            match (hooks.program.call)(self, &called, found)? {
                None => return Ok(()),
                Some(place) => found = place,
            }
        }
        let Some((file, range)) = found else {
            let text = format!("{what} not found, called in '{}'; {}", self.channel.block_text(), self.places(&what));
            return self.program_missing(text);
        };
        self.report_heading(file, range);
        self.report_twice(file, range);
        if let Some(by) = &by {
            self.hand_over(by)?;
        }
        let own_variables = arguments.is_some();
        if let Some(arguments) = arguments {
            self.dialect.variables.enter(&arguments);
        }
        let (repeats, by) = (passes.saturating_sub(1), by.map(|by| by.kind));
        let text = RunningProgram::main(file, range, self.flow.name_of(&what));
        self.enter(RunningProgram { repeats, own_variables, modal, called, by, ..text });
        Ok(())
    }

    /// Calls a program whose passes are copies of a figure. Figures of the same kind cannot be nested.
    fn call_figure(&mut self, program: u32, passes: u32, figure: Box<CopiedFigure>) -> Acted {
        let depth = self.flow.frames.len();
        let same =
            |frame: &RunningProgram| frame.figure.as_deref().is_some_and(|outer| outer.copy.is_like(figure.copy));
        if self.flow.frames.iter().any(same) {
            let text = format!(
                "{} a figure copy is nested in a copy of the same kind in '{}'",
                figure.copy.alarm(),
                self.channel.block_text()
            );
            return Err(self.alarm(&diag::FIGURE_NESTED, text));
        }
        self.call(Callee::Program(program), passes, None, None)?;
        if self.flow.frames.len() > depth
            && let Some(frame) = self.flow.frames.last_mut()
        {
            frame.figure = Some(figure);
        }
        Ok(())
    }

    /// Blocks from the first one with a sequence number or label to the next one with another, both included, in the
    /// current file (reference control-emulator.md 5.7).
    fn call_range(&mut self, what: Callee, passes: u32) -> Acted {
        self.check_nesting(|| what.to_string())?;
        self.check_levels(false, &what)?;
        let range = find_range(&self.channel, &mut self.flow, &what);
        let mut found = range.map(|range| (self.channel.at.file, range));
        let called = call_record(self.plan, &self.channel, what.clone(), passes);
        if let Some(hooks) = self.plan.hooks {
            match (hooks.program.call)(self, &called, found)? {
                None => return Ok(()),
                Some(place) => found = place,
            }
        }
        let Some((file, range)) = found else {
            let text = format!("{what} is not in the file, called in '{}'", self.channel.block_text());
            return self.program_missing(text);
        };
        let repeats = passes.saturating_sub(1);
        let text = RunningProgram::main(file, range, self.flow.name_of(&what));
        self.enter(RunningProgram { repeats, closes: true, called, ..text });
        Ok(())
    }

    pub(crate) fn check_nesting(&mut self, called: impl Fn() -> String) -> Acted {
        let limit = usize::from(self.channel.env.options.limits.nesting);
        if self.flow.frames.len() <= limit {
            return Ok(());
        }
        let text = format!(
            "more than {limit} subprogram levels at the call of {} in '{}'",
            called(),
            self.channel.block_text()
        );
        Err(self.alarm(&diag::NESTING, text))
    }

    /// Checks the limits of the control: levels of macros, of subprograms, and of both together.
    pub(crate) fn check_levels(&mut self, is_macro: bool, what: &Callee) -> Acted {
        let levels = self.channel.env.machine.subprograms.levels;
        let all = self.flow.frames.len();
        let macros = self.flow.call_level();
        let deep = |own: usize, limit: Option<u16>| limit.filter(|limit| own > usize::from(*limit));
        let own = if is_macro { deep(macros + 1, levels.macros) } else { None };
        let (facts, limit, kind) = if let Some(limit) = own {
            (&diag::MACRO_LEVELS, limit, "macro calls")
        } else if let Some(limit) = deep(all, levels.all) {
            (&diag::CALL_LEVELS, limit, "calls")
        } else if let Some(limit) = deep(all - macros, levels.subprograms).filter(|_| !is_macro) {
            (&diag::CALL_LEVELS, limit, "subprogram calls")
        } else {
            return Ok(());
        };
        let text =
            format!("more than {limit} levels of {kind} at the call of {what} in '{}'", self.channel.block_text());
        Err(self.alarm(facts, text))
    }

    pub(crate) fn enter(&mut self, mut frame: RunningProgram) {
        let (level, name) = (self.flow.frames.len() as u16, &frame.name);
        self.channel.emitter.emit_as(&self.channel.at, 0, |kind| {
            *kind = Kind::Call(SubprogramEntry { program: Arc::clone(name), level })
        });
        self.channel.emitter.carries(&self.channel.at, name.len());
        self.flow.repeats = true;
        self.flow.pass.changes = true;
        if self.channel.env.info.is_resident(frame.file) {
            frame.caller = self.channel.at.user_place();
        }
        self.flow.frames.push(frame);
        self.interpreter_call();
    }

    /// Return of a subprogram, or of the main program.
    pub fn return_from(&mut self, target: Option<u32>) -> Acted {
        if self.flow.frames.len() <= 1 {
            return self.main_return(target);
        }
        if let Some(frame) = self.flow.frames.last_mut()
            && frame.repeats > 0
        {
            frame.repeats -= 1;
            let (first, last) = (frame.range.first, frame.range.last);
            (frame.next, frame.offset) = (first, 0);
            if let Some(figure) = frame.figure.as_deref_mut() {
                figure.made += 1;
                let figure = figure.clone();
                (self.plan.actions.copy_figure)(self, &figure, true)?;
            }
            let level = self.flow.level();
            self.flow.loops.restart(level);
            interpreter_repeat(&mut self.dialect);
            self.end_pass(first, last)?;
            return self.plan.hooks.map_or(Ok(()), |hooks| (hooks.program.next_pass)(self));
        }
        if let Some(frame) = self.flow.frames.pop() {
            if frame.own_variables {
                if let Some(caller) = frame.modal {
                    self.flow.modal.keep(caller, self.dialect.variables.locals());
                }
                self.dialect.variables.leave();
                let level = self.flow.call_level();
                self.flow.modal.leave(level);
            }
            self.interpreter_return();
            self.flow.pass.leave(self.flow.frames.len());
            let level = self.flow.level();
            self.flow.loops.return_to(level);
            if let Some(back) = &frame.back {
                self.end_contour(back)?;
            }
            if let Some(figure) = &frame.figure {
                (self.plan.actions.copy_figure)(self, figure, false)?;
            }
            let level = self.flow.frames.len() as u16;
            self.channel.emitter.emit_as(&self.channel.at, 0, |kind| *kind = Kind::Return(Return { level }));
            if let Some(hooks) = self.plan.hooks {
                (hooks.program.returned)(self, &frame.called, (frame.file, frame.range))?;
            }
        }
        match target {
            Some(number) => self.jump_to_sequence(number),
            None => Ok(()),
        }
    }

    fn main_return(&mut self, target: Option<u32>) -> Acted {
        if let Some(number) = target {
            return self.jump_to_sequence(number);
        }
        match self.channel.env.machine.subprograms.main_return {
            MainReturn::Restart => {
                let first = self.flow.frame().map_or(1, |f| f.range.first);
                self.flow.loops = dialect::LoopStack::default();
                self.jump_to_line(first)
            }
            MainReturn::End => {
                self.diagnose(
                    &diag::MAIN_RETURN,
                    "return code in the main program: the control would start again, the run ends after this cycle",
                );
                Err(Halt::ProgramEnd(None))
            }
        }
    }

    /// Jumps to the sequence number: searches forward first, then from the top of the program.
    pub(crate) fn jump_to_sequence(&mut self, number: u32) -> Acted {
        if self.flow.frames.is_empty() {
            return Ok(());
        }
        let block = self.find_sequence(number)?;
        self.interpreter_jump(block);
        self.jump_to(block)
    }

    /// The block with a sequence number: searches forward first, then from the top of the program.
    pub fn find_sequence(&mut self, number: u32) -> Result<BlockStart, Halt> {
        let sources = self.channel.env.sources;
        let frame = self.flow.frame().map(|frame| (frame.file, frame.range, frame.next_block()));
        let found = frame.and_then(|(file, range, next)| {
            let blocks = sources.get(file).map_or(&[][..], |source| source.sequences(number));
            let last = BlockStart { line: range.last, offset: u32::MAX };
            dialect::LabelSearchOrder::Around.find(blocks, next, (BlockStart::line(range.first), last))
        });
        found.ok_or_else(|| {
            let text = format!("block N{number} not found in the program for '{}'", self.channel.block_text());
            self.alarm(&diag::JUMP_TARGET, text)
        })
    }

    /// Continues at a line of the current program; a jump back ends a pass of a loop.
    pub fn jump_to_line(&mut self, line: u32) -> Acted {
        self.jump_to(BlockStart::line(line))
    }

    /// The same for a block of a line.
    pub(crate) fn jump_to(&mut self, target: BlockStart) -> Acted {
        let Some(frame) = self.flow.frame() else { return Ok(()) };
        // After a return this is the line of the call.
        let from = if frame.offset > 0 { frame.next } else { frame.next.saturating_sub(1) };
        let back = target < frame.next_block();
        (frame.next, frame.offset) = (target.line, target.offset);
        if back { self.end_pass(target.line, from) } else { Ok(()) }
    }
}
