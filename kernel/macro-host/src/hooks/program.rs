//! Macros around a whole program, around subprograms, and for names that the pre-processor does not know.
//!
//! Facts: reference control-emulator.md 2.1, 2.4, 4.1, 4.3.

use counterpoint_lang::value::MacroValue;

use crate::context::MacroHooks;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::parts::Restart;
use counterpoint_control_api::IdentificationAnswer;
use counterpoint_event::event::{FileId, Kind};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::macros::model::Hook;

impl MacroHooks<'_, '_> {
    /// Declaration and Program Startup.
    pub(crate) fn begin_macros(&mut self) -> Acted {
        self.plain_macro(Hook::Declaration)?;
        self.plain_macro(Hook::ProgramStartup)?;
        // A call that the startup macro made takes place before the first block.
        let done = self.kernel.follow();
        self.kernel.went_on(done)
    }

    /// Program Shutdown, and the programs that it starts; returns how the last program ended.
    pub(crate) fn end_program(&mut self, halt: Halt) -> Halt {
        let mut halt = self.end_macros(halt);
        while let Some(next) = self.restarted(halt) {
            halt = self.end_macros(next);
        }
        halt
    }

    /// Program Shutdown, when the program has ended or an alarm has stopped it.
    fn end_macros(&mut self, halt: Halt) -> Halt {
        if !matches!(halt, Halt::ProgramEnd(_) | Halt::Alarm) {
            return halt;
        }
        let runtime = &mut *self.kernel.macros;
        runtime.calls.resume();
        runtime.issued.later.clear();
        runtime.course.closing = true;
        self.kernel.channel.context.text = None;
        self.kernel.channel.reports.alarms.stopping = false;
        match self.plain_macro(Hook::ProgramShutdown) {
            Err(worse @ (Halt::Alarm | Halt::Stopped | Halt::Blocked)) => worse,
            _ => halt,
        }
    }

    /// Continues with the file that Program Shutdown named, and returns how that program ended; none if no file was
    /// named. A restart counts as a block, so that a macro that restarts indefinitely reaches a limit.
    fn restarted(&mut self, halt: Halt) -> Option<Halt> {
        let runtime = &mut *self.kernel.macros;
        let Restart { file, line, reset } =
            runtime.course.restart.take().filter(|_| matches!(halt, Halt::ProgramEnd(_)))?;
        runtime.course.closing = false;
        if let Halt::ProgramEnd(Some(stop)) = halt {
            self.kernel.channel.emit(0, Kind::Stop(stop));
        }
        self.kernel.channel.at.blocks += 1;
        self.kernel.channel.at.idle_blocks += 1;
        let done = self.kernel.check_limits().and_then(|()| self.kernel.load(file));
        Some(match done.and_then(|()| self.start_at(file, line, reset)) {
            Ok(()) => self.kernel.program(),
            Err(halt) => halt,
        })
    }

    fn start_at(&mut self, file: FileId, line: u32, reset: bool) -> Acted {
        let name = self.kernel.channel.env.info.file_name(file).to_owned();
        let Some((file, range)) = self.place_in_file(&name, line)? else {
            let text = format!("the run cannot continue at line {line} of {name}");
            return Err(self.kernel.fatal(&diag::FILE_UNREADABLE, text));
        };
        self.kernel.start_over(file, range, name.into(), reset)
    }

    /// Runs the identification macro on a text that is unknown, with the value that is being assigned to it.
    ///
    /// # Errors
    /// The macro stopped the channel.
    pub(crate) fn ask_identification(
        &mut self,
        asked: &str,
        assigned: MacroValue,
    ) -> Result<IdentificationAnswer, Halt> {
        let Some(code) = self.kernel.macros.ready(Hook::Identification) else {
            return Ok(IdentificationAnswer::Unknown);
        };
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
                self.kernel.diagnose(&diag::MACRO_RESULT, text);
                IdentificationAnswer::Unknown
            }
        })
    }
}
