//! Commands of macros: OUTPUT, EXEC, reading ahead, modal states.
//!
//! Facts: reference control-emulator.md 4.4, macro-language.md 3.2, 3.3. Decisions: docs/emulation.md.

use std::sync::Arc;

use counterpoint_channel::burden::shortened;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::issued::{Later, MOST_QUEUED};
use counterpoint_channel::macros::store::names;
use counterpoint_emulator::channel::tool_events::load_head;
use counterpoint_event::event::{Kind, Listing, OperatorMessage};
use counterpoint_fault as diag;
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::host::HostCommand;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::MacroState;
use counterpoint_machine::macros::model::Hook;

use crate::context::KernelHost;

/// Steps that processing a block costs the macro that asks for it.
const BLOCK_TICKS: usize = 500;

/// Empty lines of one LPRINT.
const MOST_SKIPPED: i64 = 1000;

/// Modal states that may be pushed.
const MOST_SAVED: usize = 100;

/// A fault with one of the kernel's own numbers.
pub(crate) fn fault(facts: &diag::DiagnosticFacts, text: impl Into<String>) -> MacroFault {
    MacroFault::new(DiagnosticNumber(facts.number), text)
}

impl KernelHost<'_, '_> {
    pub(crate) fn macro_command(&mut self, state: &mut MacroState, command: HostCommand<'_>) -> Outcome<i32> {
        match command {
            HostCommand::Match(on) => self.kernel.macros.match_macros(on),
            HostCommand::MatchAgain => self.kernel.macros.match_macros(true),
            HostCommand::Output(arguments) => self.output(state, arguments)?,
            HostCommand::ExecBlock(now, text) => self.exec_text(state, now, text)?,
            HostCommand::ExecItems(now, items) => self.exec_items(state, now, items)?,
            HostCommand::TapeRead => self.tape_read(state)?,
            HostCommand::TapeWrite => {
                let text = self.kernel.macros.variables.store.text(names().mcdrd);
                self.exec_text(state, true, &text)?;
            }
            HostCommand::Search(number) => self.search_record(state, number)?,
            HostCommand::SaveModal => {
                let groups = self.kernel.channel.state.modal.saved();
                let runtime = &mut *self.kernel.macros;
                if runtime.modes.saved.len() >= MOST_SAVED {
                    let text = format!("more than {MOST_SAVED} modal states are saved");
                    return Err(fault(&diag::MODAL_STACK, text));
                }
                runtime.modes.saved.push(groups);
            }
            HostCommand::RestoreModal => {
                let saved = self.kernel.macros.modes.saved.pop();
                let Some(groups) = saved else {
                    return Err(fault(&diag::MODAL_STACK, "no saved modal state to restore"));
                };
                counterpoint_channel::units::put_modes_back(&mut self.kernel.channel, &groups);
            }
            // LPRINT goes into the log also without a trace.
            HostCommand::Listing(on) => {
                self.kernel.channel.emit(0, Kind::listing(if on { Listing::On } else { Listing::Off }))
            }
            HostCommand::Skip(lines) if lines > 0 => {
                let lines = u32::try_from(lines.min(MOST_SKIPPED)).unwrap_or(0);
                state.spend(lines as usize)?;
                self.kernel.channel.emit(0, Kind::listing(Listing::Lines(lines)));
            }
            HostCommand::Skip(_) => {}
            HostCommand::Print(text) => self
                .kernel
                .channel
                .emit(0, Kind::Message(OperatorMessage { text: shortened(text).into(), printed: true })),
            HostCommand::System(text) => return self.system_command(state, text),
        }
        Ok(0)
    }

    fn output(&mut self, state: &mut MacroState, arguments: &[(u8, MacroValue)]) -> Outcome<()> {
        state.spend(BLOCK_TICKS)?;
        let task = match self.kernel.macros.calls.innermost() {
            Some(call) => {
                call.outputs += 1;
                call.task.clone()
            }
            None => OutputTask::None,
        };
        let argument = |number: u8| arguments.iter().find(|(at, _)| *at == number).map(|(_, value)| value);
        match task {
            OutputTask::None => Self::not_here("OUTPUT"),
            OutputTask::Code(pending, id) => {
                let wanted = argument(1).cloned();
                self.hooks().meanwhile(state, |kernel| kernel.output_code(pending, id, wanted.as_ref()))
            }
            OutputTask::Remark(id, text) => {
                let wanted = argument(1).cloned();
                self.hooks().meanwhile(state, |kernel| kernel.output_remark(id, text, wanted.as_ref()))
            }
            OutputTask::Motion(seconds, motion) => {
                let (kind, end) = (argument(1).cloned(), argument(2).cloned());
                self.hooks()
                    .meanwhile(state, |kernel| kernel.output_motion(seconds, &motion, kind.as_ref(), end.as_ref()))
            }
            OutputTask::Tool(action, tool, offset, ns) => {
                self.hooks().meanwhile(state, |hooks| hooks.kernel.change_tool(action, tool, offset, ns))
            }
            OutputTask::Head(kind, id) => {
                self.hooks().meanwhile(state, |hooks| load_head(&mut hooks.kernel.channel, kind, id))
            }
            OutputTask::Cycle(hole) => {
                let heights = [3, 4, 5, 6].map(|at| argument(at).and_then(MacroValue::as_real));
                self.hooks().meanwhile(state, |hooks| hooks.output_cycle(*hole, heights))
            }
            OutputTask::Diagnostic(came) => {
                let [number, severity, text] = &*came;
                let values =
                    [(2, number), (3, severity), (5, text)].map(|(at, came)| argument(at).unwrap_or(came).clone());
                self.output_diagnostic(&values)
            }
        }
    }

    /// Diagnostics cannot issue blocks, since they may be raised at any point.
    fn may_exec(&self, state: &mut MacroState) -> Outcome<()> {
        state.spend(BLOCK_TICKS)?;
        if self.inside(Hook::Diagnostic) { Self::not_here("EXEC") } else { Ok(()) }
    }

    fn exec_text(&mut self, state: &mut MacroState, now: bool, text: &str) -> Outcome<()> {
        self.may_exec(state)?;
        let limit = self.kernel.channel.env.options.limits.block_length;
        if text.len() > limit {
            return Err(fault(
                &diag::BLOCK_TOO_LONG,
                format!("EXEC of {} bytes, a block may have {limit}", text.len()),
            ));
        }
        self.trace_exec_text(now, &text.replace(['\n', '\r'], " "));
        let blocks = self.hooks().blocks_of_text(text);
        state.spend(blocks.len().saturating_sub(1) * BLOCK_TICKS)?;
        for text in blocks {
            if !now {
                if self.is_too_late(state, "EXEC/NEXT") {
                    return Ok(());
                }
                state.grow(text.len() + 64);
                self.leave_for_later(|matching| Later::Text(text, matching))?;
                continue;
            }
            let asked = self.kernel.flow.pending.is_some();
            self.hooks().meanwhile(state, |kernel| kernel.nested_block(|kernel| kernel.issued_block(text)))?;
            // A jump or an end leads away from the blocks after it.
            if !asked && self.kernel.flow.pending.is_some() {
                break;
            }
        }
        Ok(())
    }

    fn exec_items(&mut self, state: &mut MacroState, now: bool, items: &[MacroValue]) -> Outcome<()> {
        self.may_exec(state)?;
        self.trace_exec_items(now, items);
        if now {
            return self.hooks().meanwhile(state, |kernel| kernel.nested_block(|kernel| kernel.item_block(items)));
        }
        if self.is_too_late(state, "EXEC/NEXT") {
            return Ok(());
        }
        let items: Arc<[MacroValue]> = items.into();
        state.grow(items.len() * 16 + 64);
        self.leave_for_later(|matching| Later::Items(items, matching))
    }

    /// Whether the program has ended, so that a command for its next block has no effect.
    fn is_too_late(&self, state: &mut MacroState, command: &str) -> bool {
        let late = self.kernel.macros.course.closing;
        if late {
            let text = format!("{command} has no effect: the program has ended and reads no further block");
            state.warn(fault(&diag::NO_NEXT_BLOCK, text));
        }
        late
    }

    fn leave_for_later(&mut self, block: impl FnOnce(bool) -> Later) -> Outcome<()> {
        let runtime = &mut *self.kernel.macros;
        if runtime.issued.later.len() >= MOST_QUEUED {
            let text = format!("more than {MOST_QUEUED} blocks of EXEC/NEXT are waiting");
            return Err(fault(&diag::EXEC_QUEUE, text));
        }
        let matching = runtime.calls.innermost().is_none_or(|call| call.matching);
        runtime.issued.later.push_back(block(matching));
        Ok(())
    }

    /// TAPERD: the next block that is not blank.
    fn tape_read(&mut self, state: &mut MacroState) -> Outcome<()> {
        let sources = self.kernel.channel.env.sources;
        let found = self.kernel.flow.frames.last_mut().and_then(|frame| {
            let source = sources.get(frame.file)?;
            let line = (frame.next..=frame.range.last).find(|&line| !source.line(line).trim_ascii().is_empty())?;
            frame.next = line + 1;
            Some((line, String::from_utf8_lossy(source.line(line)).into_owned()))
        });
        let (number, text) = match found {
            Some((line, text)) => (line, text),
            None => {
                state.warn(MacroFault::new(DiagnosticNumber::PROGRAM_END, "the NC program has no further block"));
                (0, String::new())
            }
        };
        let store = &mut self.kernel.macros.variables.store;
        store.set(names().mcdrd, MacroValue::text(text));
        if number > 0 {
            store.number = number;
        }
        Ok(())
    }

    /// SEARCH: the next block read is this record of the file; the block still in process is not repeated.
    fn search_record(&mut self, state: &mut MacroState, number: i64) -> Outcome<()> {
        if self.is_too_late(state, "SEARCH") {
            return Ok(());
        }
        let Some((first, last)) = self.kernel.flow.frame().map(|frame| (frame.range.first, frame.range.last)) else {
            return Ok(());
        };
        let wanted = u32::try_from(number).ok().filter(|line| (first..=last.saturating_add(1)).contains(line));
        let Some(line) = wanted else {
            let text = format!("SEARCH for record {number}, the program has {first} to {last}");
            return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, text));
        };
        if line > self.kernel.channel.at.line {
            if let Some(frame) = self.kernel.flow.frame() {
                frame.next = line;
            }
            return Ok(());
        }
        if line == self.kernel.channel.at.line {
            if let Some(frame) = self.kernel.flow.frame() {
                frame.next = line + 1;
            }
            return Ok(());
        }
        self.hooks().meanwhile(state, |hooks| hooks.kernel.jump_to_line(line))
    }
}
