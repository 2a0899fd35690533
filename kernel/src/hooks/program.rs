//! Macros around a whole program, around subprograms, and for what the pre-processor does not know.
//!
//! Facts: reference control-emulator.md 2.1, 2.4, 4.1, 4.3.

use counterpoint_lang::value::Value;

use crate::channel::Kernel;
use crate::channel::flow::{Flow, Frame};
use crate::diag;
use crate::dialect::Answer;
use crate::dialect::fanuc::{Fault, Names, Statement, compile, number};
use crate::log::event::{FileId, Kind};
use crate::machine::macros::model::Hook;
use crate::macros::calls::Task;
use crate::macros::parts::Restart;
use crate::mcd::program::Range;
use crate::state::modal::Modal;
use crate::state::probing::Probing;
use crate::state::thread::Threads;
use counterpoint_fault::{Acted, Halt};

impl Kernel<'_> {
    /// Declaration and Program Startup.
    pub(crate) fn begin_macros(&mut self) -> Acted {
        self.plain_macro(Hook::Declaration)?;
        self.plain_macro(Hook::ProgramStartup)?;
        // A call that the startup macro made takes place before the first block.
        let done = self.follow();
        self.went_on(done)
    }

    /// Program Shutdown, when the program has come to its end or stands on an alarm.
    pub(crate) fn end_macros(&mut self, halt: Halt) -> Halt {
        if self.plan.hooks.is_none() || !matches!(halt, Halt::End(_) | Halt::Alarm) {
            return halt;
        }
        let runtime = &mut *self.macros;
        runtime.calls.resume();
        runtime.issued.later.clear();
        runtime.course.closing = true;
        runtime.block.text = None;
        self.channel.clear_stop();
        match self.plain_macro(Hook::ProgramShutdown) {
            Err(worse @ (Halt::Alarm | Halt::Stopped | Halt::Blocked)) => worse,
            _ => halt,
        }
    }

    /// Goes on with the file that Program Shutdown named; how that ended, or none if it named none. A restart counts
    /// as a block, so that a macro that restarts for ever comes to a limit.
    pub(crate) fn restarted(&mut self, halt: Halt) -> Option<Halt> {
        let runtime = &mut *self.macros;
        let Restart { file, line, reset } = runtime.course.restart.take().filter(|_| matches!(halt, Halt::End(_)))?;
        runtime.course.closing = false;
        if let Halt::End(Some(stop)) = halt {
            self.emit(0, Kind::Stop(stop));
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
            let text = format!("the run cannot go on at line {line} of {name}");
            return Err(self.fatal(&diag::FILE_UNREADABLE, text));
        };
        self.start_over(file, range, name.into(), reset)
    }

    /// Begins another program in place of the one that has ended.
    pub(crate) fn start_over(&mut self, file: FileId, range: Range, name: Box<str>, reset: bool) -> Acted {
        if reset {
            self.channel.state.modal = Modal::new(self.channel.env.machine);
            self.initial_codes();
            (
                self.channel.state.place.tools.current,
                self.channel.state.place.tools.selected,
                self.channel.state.place.tools.chosen,
            ) = (0, 0, false);
            (self.channel.state.cycle, self.channel.state.arcs) =
                (crate::state::cycle::Cycle::new(self.channel.env.machine), crate::state::arc::Arcs::default());
            self.forget_frame();
            if let Some(channel) =
                self.channel.env.machine.channels.iter().find(|channel| channel.number == self.channel.at.channel)
            {
                *self.channel.state.others = crate::state::Others::new(self.channel.env.machine, channel);
            }
            (*self.channel.state.threads, *self.channel.state.skip) =
                (Threads::new(self.channel.env.machine), Probing::default());
            let runtime = &mut *self.macros;
            (runtime.variables.store.counts, runtime.books.operations) = Default::default();
            runtime.variables.store.listed.clear();
            runtime.tools.loaded.clear();
        }
        self.channel.block.clear();
        if !reset {
            self.switch_compensation();
        }
        (self.channel.at.file, self.channel.at.line) = (file, 0);
        for _ in self.flow.frames.iter().filter(|frame| frame.own_variables) {
            self.dialect.variables.leave();
        }
        self.flow = Flow::default();
        self.flow.frames.push(Frame::main(file, range, name));
        if let Some(interpreter) = self.dialect.interpreter.as_deref_mut() {
            interpreter.begin(reset);
        }
        self.interpreter_started();
        self.plain_macro(Hook::ProgramStartup)?;
        let done = self.follow();
        self.went_on(done)
    }

    /// Asks the identification macro for a variable; without an answer, what the kernel itself knows counts.
    pub(crate) fn identified(&mut self, index: u32) -> Result<f64, Fault> {
        let asked = self.macros.course.identifying;
        let Some(code) = self.hook(Hook::Identification).filter(|_| !asked) else { return self.get_known(index) };
        match self.identify_variable(code, index, Value::Null)? {
            Answer::Unknown => self.get_known(index),
            Answer::Drop => Ok(0.0),
            Answer::Keep => Err(Fault::Kept(index)),
            Answer::Instead(text) => self.value_of_text(&text, Fault::NoVariable(f64::from(index))),
        }
    }

    /// Asks it for the value of a function that the control does not have.
    pub(crate) fn identified_function(&mut self, text: &str) -> Result<f64, Fault> {
        let unknown = Fault::NoFunction(text.to_owned());
        let asked = self.macros.course.identifying;
        let Some(code) = self.hook(Hook::Identification).filter(|_| !asked) else { return Err(unknown) };
        match self.identify_text(code, text, Value::Null)? {
            Answer::Unknown => Err(unknown),
            Answer::Drop => Ok(0.0),
            Answer::Keep => Err(Fault::KeptFunction(text.to_owned())),
            Answer::Instead(text) => self.value_of_text(&text, unknown),
        }
    }

    /// Asks it where to write a variable that the kernel does not know; true if that is settled.
    pub(crate) fn identify_write(&mut self, index: u32, value: f64) -> Result<bool, Fault> {
        let Some(code) = self.hook(Hook::Identification).filter(|_| index >= 1000) else { return Ok(false) };
        match self.identify_variable(code, index, Value::Real(number(value)))? {
            Answer::Unknown => Ok(false),
            Answer::Drop => Ok(true),
            Answer::Keep => Err(Fault::Kept(index)),
            Answer::Instead(text) => {
                let wanted = text.trim().strip_prefix('#').and_then(|text| text.trim().parse::<u32>().ok());
                match wanted.filter(|wanted| *wanted != index && (*wanted < 1000 || self.is_common(*wanted))) {
                    Some(wanted) => self.set_variable(wanted, value).map(|()| true),
                    None => Err(Fault::NoVariable(f64::from(index))),
                }
            }
        }
    }

    /// The same for a variable: a text that is not changed is an error.
    fn identify_variable(&mut self, code: u16, index: u32, assigned: Value) -> Result<Answer, Fault> {
        let asked = format!("#{index}");
        match self.identify_text(code, &asked, assigned)? {
            // Evaluating the same text again would ask for ever.
            Answer::Instead(text) if text.trim() == asked => Err(Fault::NoVariable(f64::from(index))),
            answer => Ok(answer),
        }
    }

    fn identify_text(&mut self, code: u16, text: &str, assigned: Value) -> Result<Answer, Fault> {
        self.ask_identification(code, text, assigned).map_err(|halt| {
            self.keep_halt(halt);
            Fault::Stopped
        })
    }

    /// Runs the identification macro on a text that nobody knows, with the value that is being assigned to it.
    ///
    /// # Errors
    /// The macro stopped the channel.
    pub(crate) fn ask_identification(&mut self, code: u16, asked: &str, assigned: Value) -> Result<Answer, Halt> {
        let mut arguments = [Value::Real(0.0), Value::text(asked), assigned];
        self.run_macro(code, Task::None, &mut arguments)?;
        let [flag, text, _] = arguments;
        let flag = flag.as_real().unwrap_or(0.0);
        if flag != 1.0 {
            return Ok(match flag {
                -1.0 => Answer::Drop,
                2.0 => Answer::Keep,
                _ => Answer::Unknown,
            });
        }
        Ok(match text {
            Value::Text(text) => Answer::Instead(text.as_ref().clone()),
            // As many digits as tell the number from every other.
            Value::Real(number) if number.is_finite() => Answer::Instead(number.to_string()),
            other => {
                let text = format!(
                    "$P2 of the identification macro is {} in place of '{asked}'; a text or a number is expected",
                    other.kind_name()
                );
                self.diagnose(&diag::MACRO_RESULT, text);
                Answer::Unknown
            }
        })
    }

    fn set_identifying(&mut self, on: bool) {
        self.macros.course.identifying = on;
    }

    /// Value of an expression that a macro gave in place of something that nobody knows; the same text again would be
    /// asked for ever, so what nobody knows in it stays `unknown`.
    fn value_of_text(&mut self, text: &str, unknown: Fault) -> Result<f64, Fault> {
        let Ok(line) = compile(format!("#1=[{text}]").as_bytes(), Names::default()) else { return Err(unknown) };
        let Statement::Assign(list) = line.statement else { return Err(unknown) };
        match list.as_slice() {
            [(_, value)] => {
                self.set_identifying(true);
                let value = value.eval(self);
                self.set_identifying(false);
                if let Err(Fault::NoFunction(_)) = value { Err(unknown) } else { value }
            }
            _ => Err(unknown),
        }
    }
}
