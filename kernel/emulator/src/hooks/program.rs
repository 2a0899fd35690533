//! Macros around a whole program, around subprograms, and for names that the pre-processor does not know.
//!
//! Facts: reference control-emulator.md 2.1, 2.4, 4.1, 4.3.

use counterpoint_channel::at::BlockPlace;
use counterpoint_event::SourcePlace;
use std::sync::Arc;

use counterpoint_lang::value::MacroValue;

use crate::channel::Kernel;
use crate::channel::flow::{ProgramFlow, RunningProgram};
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::parts::Restart;
use counterpoint_channel::probing::Probing;
use counterpoint_channel::thread::ThreadingState;
use counterpoint_control_api::IdentificationAnswer;
use counterpoint_event::event::{FileId, Kind};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::macros::model::Hook;
use counterpoint_program::shape::ProgramRange;

impl Kernel<'_> {
    /// Declaration and Program Startup.
    pub(crate) fn begin_macros(&mut self) -> Acted {
        self.plain_macro(Hook::Declaration)?;
        self.plain_macro(Hook::ProgramStartup)?;
        // A call that the startup macro made takes place before the first block.
        let done = self.follow();
        self.went_on(done)
    }

    /// Program Shutdown, when the program has ended or an alarm has stopped it.
    pub(crate) fn end_macros(&mut self, halt: Halt) -> Halt {
        if self.plan.hooks.is_none() || !matches!(halt, Halt::ProgramEnd(_) | Halt::Alarm) {
            return halt;
        }
        let runtime = &mut *self.macros;
        runtime.calls.resume();
        runtime.issued.later.clear();
        runtime.course.closing = true;
        self.channel.context.text = None;
        self.channel.reports.alarms.stopping = false;
        match self.plain_macro(Hook::ProgramShutdown) {
            Err(worse @ (Halt::Alarm | Halt::Stopped | Halt::Blocked)) => worse,
            _ => halt,
        }
    }

    /// Continues with the file that Program Shutdown named, and returns how that program ended; none if no file was
    /// named. A restart counts as a block, so that a macro that restarts indefinitely reaches a limit.
    pub(crate) fn restarted(&mut self, halt: Halt) -> Option<Halt> {
        let runtime = &mut *self.macros;
        let Restart { file, line, reset } =
            runtime.course.restart.take().filter(|_| matches!(halt, Halt::ProgramEnd(_)))?;
        runtime.course.closing = false;
        if let Halt::ProgramEnd(Some(stop)) = halt {
            self.channel.emit(0, Kind::Stop(stop));
        }
        self.channel.at.blocks += 1;
        self.channel.at.idle_blocks += 1;
        let done = self.check_limits().and_then(|()| self.load(file));
        Some(match done.and_then(|()| self.start_at(file, line, reset)) {
            Ok(()) => self.program(),
            Err(halt) => halt,
        })
    }

    fn start_at(&mut self, file: FileId, line: u32, reset: bool) -> Acted {
        let name = self.channel.env.info.file_name(file).to_owned();
        let Some((file, range)) = self.place_in_file(&name, line)? else {
            let text = format!("the run cannot continue at line {line} of {name}");
            return Err(self.fatal(&diag::FILE_UNREADABLE, text));
        };
        self.start_over(file, range, name.into(), reset)
    }

    /// Starts the next program after the previous one has ended.
    pub(crate) fn start_over(&mut self, file: FileId, range: ProgramRange, name: Arc<str>, reset: bool) -> Acted {
        if reset {
            self.channel.state.forget_words(self.channel.env.machine);
            self.initial_codes();
            (
                self.channel.state.place.tools.current,
                self.channel.state.place.tools.selected,
                self.channel.state.place.tools.chosen,
            ) = (0, 0, false);
            (self.channel.state.cycle, self.channel.state.arcs) = (
                counterpoint_channel::cycle::Cycle::new(self.channel.env.machine),
                counterpoint_channel::arc::ArcState::default(),
            );
            self.forget_frame();
            if let Some(channel) =
                self.channel.env.machine.channels.iter().find(|channel| channel.number == self.channel.at.channel)
            {
                *self.channel.state.others = counterpoint_channel::RareState::new(self.channel.env.machine, channel);
            }
            (*self.channel.state.threads, *self.channel.state.skip) =
                (ThreadingState::new(self.channel.env.machine), Probing::default());
            let runtime = &mut *self.macros;
            runtime.variables.store.counts = Default::default();
            runtime.books.forget_operations();
            runtime.variables.store.listed.clear();
            runtime.tools.clear();
        }
        self.channel.block.clear();
        if !reset {
            self.switch_compensation();
        }
        self.channel.at.go_to(BlockPlace { file, line: 0, caller: SourcePlace::NONE });
        for _ in self.flow.frames.iter().filter(|frame| frame.own_variables) {
            self.dialect.variables.leave();
        }
        self.flow = ProgramFlow::default();
        self.flow.frames.push(RunningProgram::main(file, range, name));
        if let Some(interpreter) = self.dialect.interpreter.as_deref_mut() {
            interpreter.restart(reset);
            self.flow.watched = interpreter.watches();
        }
        self.interpreter_start();
        self.plain_macro(Hook::ProgramStartup)?;
        let done = self.follow();
        self.went_on(done)
    }

    /// Runs the identification macro on a text that is unknown, with the value that is being assigned to it.
    ///
    /// # Errors
    /// The macro stopped the channel.
    pub(crate) fn ask_identification(
        &mut self,
        code: u16,
        asked: &str,
        assigned: MacroValue,
    ) -> Result<IdentificationAnswer, Halt> {
        let mut arguments = [MacroValue::Real(0.0), MacroValue::text(asked), assigned];
        self.run_macro(code, OutputTask::None, &mut arguments)?;
        let [flag, text, _] = arguments;
        let flag = flag.as_real().unwrap_or(0.0);
        if flag != 1.0 {
            return Ok(match flag {
                -1.0 => IdentificationAnswer::Drop,
                2.0 => IdentificationAnswer::Keep,
                _ => IdentificationAnswer::Unknown,
            });
        }
        Ok(match text {
            MacroValue::Text(text) => IdentificationAnswer::Instead(text.as_ref().clone()),
            // As many digits as tell the number from every other.
            MacroValue::Real(number) if number.is_finite() => IdentificationAnswer::Instead(number.to_string()),
            other => {
                let text = format!(
                    "$P2 of the identification macro is {} in place of '{asked}'; a text or a number is expected",
                    other.kind_name()
                );
                self.diagnose(&diag::MACRO_RESULT, text);
                IdentificationAnswer::Unknown
            }
        })
    }
}
