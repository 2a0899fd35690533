//! Fanuc custom macro: variables, expressions, branches and loops.
//!
//! Facts: reference control-emulator.md 5.4 (Fanuc row). A line is compiled (`compile`, `formula`, `words`) and
//! executed (`execute`, `access`). The kernel has the numbered variables: they belong to its call levels, channels and
//! axes. *Invariants:* compiling is linear in the length of the line and never panics; nesting of brackets is limited.
//! The only state of the interpreter is the text of programs that it has read, so a block within a block may run with
//! another interpreter.

mod access;
mod call;
mod compile;
mod control;
mod cursor;
mod execute;
mod expr;
mod formula;
mod loops;
mod outline;
mod print;
mod statement;
mod vocabulary;
mod words;

use counterpoint_machine::index::RegisterId;
use std::sync::Arc;

use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;

pub use control::FanucDialect;

use access::{Abandoned, HostVariables};
use compile::compile;
use counterpoint_control_api::host::{InterpreterHost, NotThere};
use counterpoint_control_api::interpreter::{Interpreter, MacroArguments, Remaining, SettingOutcome};
use counterpoint_control_api::numeric::is_vacant;
use counterpoint_event::FileId;
use counterpoint_program::kept::{LineCache, TableCache};
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;
use expr::FanucValueError;
use loops::Pairs;
use statement::FanucLine;

/// The interpreter.
#[derive(Debug, Default)]
struct Fanuc {
    lines: LineCache<FanucLine>,
    /// Partners of loops and branches by program.
    pairs: TableCache<(FileId, ProgramRange), Pairs>,
    /// Text of the block without comments.
    stripped: Vec<u8>,
}

impl Fanuc {
    /// The compiled form of the block, kept once the program has jumped back or called. `displays` shows its messages:
    /// on every pass, but once for a block that is read twice.
    #[inline]
    fn line(&mut self, host: &mut dyn InterpreterHost, text: &[u8], displays: bool) -> Result<Arc<FanucLine>, Halt> {
        if let Some(line) = host.unchanged_line().and_then(|line| self.lines.get(line).map(Arc::clone)) {
            if displays && !line.messages.is_empty() {
                host.display_again(text, &line.messages);
            }
            return Ok(line);
        }
        self.compiled(host, text, displays)
    }

    /// Executes a compiled line.
    #[inline]
    fn execute(&mut self, host: &mut dyn InterpreterHost, line: &FanucLine) -> Result<Remaining, Halt> {
        if let Some(number) = line.sequence {
            host.set_sequence(number);
        }
        if let Some(span) = line.name {
            host.set_program_name(span);
        }
        match self.statement(host, &line.statement) {
            Ok(made) => Ok(made),
            Err(Abandoned::Halt(halt)) => Err(halt),
            Err(Abandoned::Text) => {
                host.keep_text(line.place);
                Ok(Remaining::Words)
            }
        }
    }

    /// Compiles the block.
    #[inline(never)]
    fn compiled(
        &mut self,
        host: &mut dyn InterpreterHost,
        text: &[u8],
        displays: bool,
    ) -> Result<Arc<FanucLine>, Halt> {
        let place = host.place();
        let messages = host.strip(text, displays, &mut self.stripped);
        match compile(&self.stripped, host.names()) {
            Ok(line) => {
                let line = Arc::new(FanucLine { messages, ..line });
                if place.repeats && place.as_read {
                    self.lines.insert((place.file, place.line), &line, text.len());
                }
                Ok(line)
            }
            Err(error) => {
                let facts = if error.brackets { &diag::BRACKETS } else { &diag::MACRO_SYNTAX };
                let text = format!("{error} in '{}'", host.block_text());
                Err(host.alarm(facts, text))
            }
        }
    }
}

impl Interpreter for Fanuc {
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt> {
        let line = self.line(host, text, true)?;
        self.execute(host, &line)
    }

    fn known_block(&mut self, host: &mut dyn InterpreterHost, at: (FileId, u32)) -> Option<Result<Remaining, Halt>> {
        let line = self.lines.take(at)?;
        if !line.messages.is_empty() {
            display_again(host, at, &line.messages);
        }
        let done = self.execute(host, &line);
        self.lines.give_back(at, line);
        Some(done)
    }

    fn arguments(
        &mut self,
        host: &mut dyn InterpreterHost,
        text: &[u8],
        own: Option<(RegisterId, f64)>,
    ) -> Result<Option<MacroArguments>, Halt> {
        let line = self.line(host, text, false)?;
        if let Some(span) = line.name {
            host.set_program_name(span);
        }
        call::words_of(&line.statement).map(|words| call::arguments(host, words, own)).transpose()
    }

    fn restart(&mut self, _: bool) {
        *self = Self::default();
    }

    fn on_jump(&mut self, host: &mut dyn InterpreterHost, target: BlockStart) {
        self.leave_loops(host, target);
    }

    fn forget_lines(&mut self) {
        self.lines.clear();
        self.pairs.clear();
    }

    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt> {
        let Some(index) = spelled(name, indices) else { return Ok(None) };
        match host.number(index) {
            Ok(value) => Ok((!is_vacant(value)).then_some(MacroValue::Real(value))),
            Err(NotThere::Halt(halt)) => Err(halt),
            Err(_) => Ok(None),
        }
    }

    fn set_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
        value: &MacroValue,
    ) -> Result<bool, Halt> {
        let (Some(index), Some(value)) = (spelled(name, indices), value.as_real()) else { return Ok(false) };
        match HostVariables::new(host).set(index, value) {
            Err(FanucValueError::Halt(halt)) => Err(halt),
            done => Ok(done.is_ok()),
        }
    }

    fn setting(&mut self, host: &mut dyn InterpreterHost, name: &str, values: &[MacroValue]) -> SettingOutcome {
        let set = match name {
            "PROCESS,SYSVARASSIGNMENT" => |host: &mut dyn InterpreterHost, on| host.set_asking(on),
            "USENULL" => |host: &mut dyn InterpreterHost, on| host.set_vacant(on),
            _ => return SettingOutcome::Unknown,
        };
        let [value] = values else { return SettingOutcome::NotLogical };
        let Some(on) = value.as_logical() else { return SettingOutcome::NotLogical };
        set(host, on);
        SettingOutcome::Made
    }

    #[inline]
    fn executes(&mut self, line: (FileId, u32)) -> bool {
        self.lines.get(line).is_some_and(|line| line.executes)
    }

    fn tables(&self) -> u64 {
        (self.lines.bytes() + self.pairs.bytes()) as u64
    }
}

/// Shows the messages of a line again.
#[cold]
fn display_again(host: &mut dyn InterpreterHost, (file, line): (FileId, u32), messages: &[(u32, u32)]) {
    if let Some(source) = host.source(file) {
        host.display_again(source.line(line), messages);
    }
}

/// Number of a variable as macros name it: `#100`, or `#` with an index apart.
fn spelled(name: &str, indices: &[f64]) -> Option<u32> {
    let name = name.trim().strip_prefix('#')?.trim().trim_start_matches('[').trim_end_matches(']');
    match indices.first() {
        Some(index) if name.is_empty() => {
            let whole = index.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(index);
            whole.then_some(*index as u32)
        }
        _ => name.parse().ok(),
    }
}
