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
use crate::pipeline::contour::{contour_cycle, end_contour, read_subprogram};
use crate::pipeline::data_blocks::pass_data_blocks;
use crate::pipeline::definitions::{report_heading, report_twice};

impl Kernel<'_> {
    /// Executes the block's deferred call, return or end.
    #[inline(always)]
    pub fn follow(&mut self) -> Acted {
        self.channel.check_stop()?;
        if self.channel.tables.rules.overlaps {
            end_functions(&mut self.channel);
        }
        let flow = &self.flow;
        if flow.pending.is_some() || !flow.modal.is_empty() || flow.modal_text { follow_up(self) } else { Ok(()) }
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

    /// Continues at a block of a line; a jump back ends a pass of a loop.
    pub(crate) fn jump_to(&mut self, target: BlockStart) -> Acted {
        let Some(frame) = self.flow.frame() else { return Ok(()) };
        // After a return this is the line of the call.
        let from = if frame.offset > 0 { frame.next } else { frame.next.saturating_sub(1) };
        let back = target < frame.next_block();
        (frame.next, frame.offset) = (target.line, target.offset);
        if back { self.end_pass(target.line, from) } else { Ok(()) }
    }
}

#[inline(never)]
fn follow_up(kernel: &mut Kernel<'_>) -> Acted {
    if kernel.flow.pending.is_none() {
        if kernel.flow.modal_text && std::mem::take(&mut kernel.channel.block.flags.moved) {
            kernel.with_interpreter(|interpreter, kernel| interpreter.on_move(kernel));
        }
        kernel.flow.call_modally(&mut kernel.channel.block);
    }
    match kernel.flow.pending.take() {
        None => Ok(()),
        Some(Pending::Call { what, passes, arguments, by }) => call_program(kernel, what, passes, arguments, by),
        Some(Pending::Figure { program, passes, figure }) => call_figure(kernel, program, passes, figure),
        Some(Pending::CallRange { what, passes }) => call_range(kernel, what, passes),
        Some(Pending::CallText(call)) => kernel.call_text(*call),
        Some(Pending::Contour(cycle)) => contour_cycle(kernel, &cycle),
        Some(Pending::ReadContour(call)) => read_subprogram(kernel, *call),
        Some(Pending::Strip(strip)) => (kernel.plan.actions.strip)(kernel, &strip),
        Some(Pending::DataBlocks) => pass_data_blocks(kernel),
        Some(Pending::Return(target)) => return_from(kernel, target),
        Some(Pending::End(stop)) => {
            if kernel.flow.modal_text {
                kernel.with_interpreter(|interpreter, kernel| interpreter.on_end(kernel));
                kernel.channel.check_stop()?;
            }
            Err(Halt::ProgramEnd(Some(stop)))
        }
    }?;
    match kernel.flow.pending {
        // Programmed by a macro around the call.
        Some(Pending::End(stop)) => Err(Halt::ProgramEnd(Some(stop))),
        _ => Ok(()),
    }
}

fn call_program(
    kernel: &mut Kernel<'_>,
    what: Callee,
    passes: u32,
    arguments: Option<Vec<(u8, f64)>>,
    by: Option<Box<CallingWord>>,
) -> Acted {
    let modal = kernel.flow.modal.take_caller();
    kernel.check_nesting(|| match &what {
        Callee::Program(number) => number.to_string(),
        other => other.to_string(),
    })?;
    kernel.check_levels(arguments.is_some(), &what)?;
    let mut found = kernel.find_program(&what)?;
    let called = call_record(kernel.plan, &kernel.channel, what.clone(), passes);
    if let Some(hooks) = kernel.plan.hooks {
        match (hooks.program.call)(kernel, &called, found)? {
            None => return Ok(()),
            Some(place) => found = place,
        }
    }
    let Some((file, range)) = found else {
        let text = format!("{what} not found, called in '{}'; {}", kernel.channel.block_text(), kernel.places(&what));
        return kernel.program_missing(text);
    };
    report_heading(kernel, file, range);
    report_twice(kernel, file, range);
    if let Some(by) = &by {
        kernel.hand_over(by)?;
    }
    let own_variables = arguments.is_some();
    if let Some(arguments) = arguments {
        kernel.dialect.variables.enter(&arguments);
    }
    let (repeats, by) = (passes.saturating_sub(1), by.map(|by| by.kind));
    let text = RunningProgram::main(file, range, kernel.flow.name_of(&what));
    kernel.enter(RunningProgram { repeats, own_variables, modal, called, by, ..text });
    Ok(())
}

/// Calls a program whose passes are copies of a figure. Figures of the same kind cannot be nested.
fn call_figure(kernel: &mut Kernel<'_>, program: u32, passes: u32, figure: Box<CopiedFigure>) -> Acted {
    let depth = kernel.flow.frames.len();
    let same = |frame: &RunningProgram| frame.figure.as_deref().is_some_and(|outer| outer.copy.is_like(figure.copy));
    if kernel.flow.frames.iter().any(same) {
        let text = format!(
            "{} a figure copy is nested in a copy of the same kind in '{}'",
            figure.copy.alarm(),
            kernel.channel.block_text()
        );
        return Err(kernel.alarm(&diag::FIGURE_NESTED, text));
    }
    call_program(kernel, Callee::Program(program), passes, None, None)?;
    if kernel.flow.frames.len() > depth
        && let Some(frame) = kernel.flow.frames.last_mut()
    {
        frame.figure = Some(figure);
    }
    Ok(())
}

/// Blocks of the current file from the first block with a sequence number or label to the next block with another, both
/// included (reference control-emulator.md 5.7).
fn call_range(kernel: &mut Kernel<'_>, what: Callee, passes: u32) -> Acted {
    kernel.check_nesting(|| what.to_string())?;
    kernel.check_levels(false, &what)?;
    let range = find_range(&kernel.channel, &mut kernel.flow, &what);
    let mut found = range.map(|range| (kernel.channel.at.file, range));
    let called = call_record(kernel.plan, &kernel.channel, what.clone(), passes);
    if let Some(hooks) = kernel.plan.hooks {
        match (hooks.program.call)(kernel, &called, found)? {
            None => return Ok(()),
            Some(place) => found = place,
        }
    }
    let Some((file, range)) = found else {
        let text = format!("{what} is not in the file, called in '{}'", kernel.channel.block_text());
        return kernel.program_missing(text);
    };
    let repeats = passes.saturating_sub(1);
    let text = RunningProgram::main(file, range, kernel.flow.name_of(&what));
    kernel.enter(RunningProgram { repeats, closes: true, called, ..text });
    Ok(())
}

/// Returns from a subprogram, or from the main program.
pub fn return_from(kernel: &mut Kernel<'_>, target: Option<u32>) -> Acted {
    if kernel.flow.frames.len() <= 1 {
        return main_return(kernel, target);
    }
    if let Some(frame) = kernel.flow.frames.last_mut()
        && frame.repeats > 0
    {
        frame.repeats -= 1;
        let (first, last) = (frame.range.first, frame.range.last);
        (frame.next, frame.offset) = (first, 0);
        if let Some(figure) = frame.figure.as_deref_mut() {
            figure.made += 1;
            let figure = figure.clone();
            (kernel.plan.actions.copy_figure)(kernel, &figure, true)?;
        }
        let level = kernel.flow.level();
        kernel.flow.loops.restart(level);
        interpreter_repeat(&mut kernel.dialect);
        kernel.end_pass(first, last)?;
        return kernel.plan.hooks.map_or(Ok(()), |hooks| (hooks.program.next_pass)(kernel));
    }
    if let Some(frame) = kernel.flow.frames.pop() {
        if frame.own_variables {
            if let Some(caller) = frame.modal {
                kernel.flow.modal.keep(caller, kernel.dialect.variables.locals());
            }
            kernel.dialect.variables.leave();
            let level = kernel.flow.call_level();
            kernel.flow.modal.leave(level);
        }
        kernel.interpreter_return();
        kernel.flow.pass.leave(kernel.flow.frames.len());
        let level = kernel.flow.level();
        kernel.flow.loops.return_to(level);
        if let Some(back) = &frame.back {
            end_contour(kernel, back)?;
        }
        if let Some(figure) = &frame.figure {
            (kernel.plan.actions.copy_figure)(kernel, figure, false)?;
        }
        let level = kernel.flow.frames.len() as u16;
        kernel.channel.emitter.emit_as(&kernel.channel.at, 0, |kind| *kind = Kind::Return(Return { level }));
        if let Some(hooks) = kernel.plan.hooks {
            (hooks.program.returned)(kernel, &frame.called, (frame.file, frame.range))?;
        }
    }
    match target {
        Some(number) => jump_to_sequence(kernel, number),
        None => Ok(()),
    }
}

fn main_return(kernel: &mut Kernel<'_>, target: Option<u32>) -> Acted {
    if let Some(number) = target {
        return jump_to_sequence(kernel, number);
    }
    match kernel.channel.env.machine.subprograms.main_return {
        MainReturn::Restart => {
            let first = kernel.flow.frame().map_or(1, |f| f.range.first);
            kernel.flow.loops = dialect::LoopStack::default();
            kernel.jump_to_line(first)
        }
        MainReturn::End => {
            kernel.diagnose(
                &diag::MAIN_RETURN,
                "return code in the main program: the control would start again, the run ends after this cycle",
            );
            Err(Halt::ProgramEnd(None))
        }
    }
}

/// Jumps to the sequence number: searches forward first, then from the top of the program.
pub(crate) fn jump_to_sequence(kernel: &mut Kernel<'_>, number: u32) -> Acted {
    if kernel.flow.frames.is_empty() {
        return Ok(());
    }
    let block = kernel.find_sequence(number)?;
    kernel.interpreter_jump(block);
    kernel.jump_to(block)
}
