//! Macros around a whole program, around subprograms, and for what the pre-processor does not know.
//!
//! Facts: reference control-emulator.md 2.1, 2.4, 4.1, 4.3.

use counterpoint_lang::value::Value;

use super::flow::{Flow, Frame};
use super::state::Modal;
use super::{Acted, Halt, Kernel};
use crate::action;
use crate::diag;
use crate::dialect::fanuc::{Fault, Names, Statement, compile, number};
use crate::log::event::{FileId, Kind};
use crate::macros::model::Hook;
use crate::macros::runtime::{Restart, Task};
use crate::mcd::program::Range;

impl Kernel<'_> {
    /// Declaration and Program Startup.
    pub(crate) fn begin_macros(&mut self) -> Acted {
        if self.macros.is_none() {
            return Ok(());
        }
        self.plain_macro(Hook::Declaration)?;
        self.plain_macro(Hook::ProgramStartup)?;
        // A call that the startup macro made takes place before the first block.
        self.follow()
    }

    /// Program Shutdown, when the program has come to its end.
    pub(crate) fn end_macros(&mut self, halt: Halt) -> Halt {
        let Some(runtime) = self.macros.as_deref_mut() else { return halt };
        if !matches!(halt, Halt::End(_)) {
            return halt;
        }
        runtime.later.clear();
        runtime.closing = true;
        runtime.text = None;
        match self.plain_macro(Hook::ProgramShutdown) {
            Err(worse @ (Halt::Alarm | Halt::Stopped | Halt::Blocked)) => worse,
            _ => halt,
        }
    }

    /// Goes on with the file that Program Shutdown named; how that ended, or none if it named none. A restart counts
    /// as a block, so that a macro that restarts for ever comes to a limit.
    pub(crate) fn restarted(&mut self, halt: Halt) -> Option<Halt> {
        let runtime = self.macros.as_deref_mut()?;
        let Restart { file, line, reset } = runtime.restart.take().filter(|_| matches!(halt, Halt::End(_)))?;
        runtime.closing = false;
        if let Halt::End(Some(stop)) = halt {
            self.emit(0, Kind::Stop(stop));
        }
        self.blocks += 1;
        self.idle_blocks += 1;
        let done = self.check_limits().and_then(|()| self.load(file));
        Some(match done.and_then(|()| self.start_at(file, line, reset)) {
            Ok(()) => self.program(),
            Err(halt) => halt,
        })
    }

    fn start_at(&mut self, file: FileId, line: u32, reset: bool) -> Acted {
        let name = self.info.file_name(file).to_owned();
        let Some((file, range)) = self.place_in_file(&name, line)? else {
            let text = format!("the run cannot go on at line {line} of {name}");
            return Err(self.alarm(&diag::FILE_UNREADABLE, text));
        };
        self.start_over(file, range, name.into(), reset)
    }

    /// Begins another program in place of the one that has ended.
    pub(super) fn start_over(&mut self, file: FileId, range: Range, name: Box<str>, reset: bool) -> Acted {
        if reset {
            self.modal = Modal::new(self.machine);
            self.initial_codes();
            (self.place.tool, self.place.selected) = (0, 0);
            (self.cycle, self.arcs) = (action::cycle::State::new(self.machine), action::arc::State::default());
            action::frame::forget(self);
            if let Some(channel) = self.machine.channels.iter().find(|channel| channel.number == self.rank) {
                *self.states = action::states::States::new(self.machine, channel);
            }
            (*self.threads, *self.skip) = (action::thread::State::new(self.machine), action::skip::State::default());
            if let Some(runtime) = self.macros.as_deref_mut() {
                (runtime.store.counts, runtime.operations) = Default::default();
                runtime.store.listed.clear();
                runtime.tools.clear();
            }
        }
        self.block.clear();
        if !reset {
            self.switch_cutter();
        }
        (self.file, self.line) = (file, 0);
        for _ in self.flow.frames.iter().filter(|frame| frame.own_variables) {
            self.variables.leave();
        }
        self.flow = Flow::default();
        self.flow.frames.push(Frame::main(file, range, name));
        if let Some(interpreter) = self.interpreter.as_deref_mut() {
            interpreter.begin(reset);
        }
        self.interpreter_started();
        self.plain_macro(Hook::ProgramStartup)?;
        self.follow()
    }

    /// Asks the identification macro for a variable; without an answer, what the kernel itself knows counts.
    pub(crate) fn identified(&mut self, index: u32) -> Result<f64, Fault> {
        let asked = self.macros.as_deref().is_some_and(|runtime| runtime.identifying);
        let Some(code) = self.hook(Hook::Identification).filter(|_| !asked) else { return self.get_known(index) };
        match self.identify(code, index, Value::Null)? {
            Answer::Own => self.get_known(index),
            Answer::Drop => Ok(0.0),
            Answer::Keep => Err(Fault::Kept(index)),
            Answer::Text(text) => self.value_of_text(&text, index),
        }
    }

    /// Asks it where to write a variable that the kernel does not know; true if that is settled.
    pub(crate) fn identify_write(&mut self, index: u32, value: f64) -> Result<bool, Fault> {
        let Some(code) = self.hook(Hook::Identification).filter(|_| index >= 1000) else { return Ok(false) };
        match self.identify(code, index, Value::Real(number(value)))? {
            Answer::Own => Ok(false),
            Answer::Drop => Ok(true),
            Answer::Keep => Err(Fault::Kept(index)),
            Answer::Text(text) => {
                let wanted = text.trim().strip_prefix('#').and_then(|text| text.trim().parse::<u32>().ok());
                match wanted.filter(|wanted| *wanted != index && (*wanted < 1000 || self.is_common(*wanted))) {
                    Some(wanted) => self.set_variable(wanted, value).map(|()| true),
                    None => Err(Fault::NoVariable(f64::from(index))),
                }
            }
        }
    }

    fn identify(&mut self, code: u16, index: u32, assigned: Value) -> Result<Answer, Fault> {
        let asked = format!("#{index}");
        let (flag, text) = match self.ask_identification(code, &asked, assigned) {
            Ok(answer) => answer,
            Err(halt) => {
                self.keep_halt(halt);
                return Err(Fault::Stopped);
            }
        };
        Ok(match text.as_text().filter(|text| text.trim() != asked) {
            Some(text) if flag == 1.0 => Answer::Text(text.to_owned()),
            // Evaluating the same text again would ask for ever.
            _ if flag == 1.0 => return Err(Fault::NoVariable(f64::from(index))),
            _ if flag == -1.0 => Answer::Drop,
            _ if flag == 2.0 => Answer::Keep,
            _ => Answer::Own,
        })
    }

    /// Runs the identification macro: what it left in `$P1` and `$P2`.
    pub(super) fn ask_identification(&mut self, code: u16, asked: &str, assigned: Value) -> Result<(f64, Value), Halt> {
        let mut arguments = [Value::Real(0.0), Value::text(asked), assigned];
        self.run_macro(code, Task::None, &mut arguments)?;
        let [flag, text, _] = arguments;
        Ok((flag.as_real().unwrap_or(0.0), text))
    }

    fn set_identifying(&mut self, on: bool) {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.identifying = on;
        }
    }

    /// Value of an expression that a macro gave in place of a variable.
    fn value_of_text(&mut self, text: &str, index: u32) -> Result<f64, Fault> {
        let unknown = Fault::NoVariable(f64::from(index));
        let statement =
            compile(format!("#1=[{text}]").as_bytes(), Names::default()).map_err(|_| unknown.clone())?.statement;
        let Statement::Assign(list) = statement else { return Err(unknown) };
        match list.as_slice() {
            [(_, value)] => {
                self.set_identifying(true);
                let value = value.eval(self);
                self.set_identifying(false);
                value
            }
            _ => Err(unknown),
        }
    }
}

/// What the identification macro wants.
enum Answer {
    /// The kernel's own way.
    Own,
    /// Nothing is to happen; the value is 0.
    Drop,
    /// The text stays on the block.
    Keep,
    /// This text instead.
    Text(String),
}
