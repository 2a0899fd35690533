//! ISG kernel, as in Beckhoff TF5200: parameters, variables, control blocks, signals between channels.
//!
//! Facts: reference channel-synchronisation.md 1.7. A block is read once (`line`, kept by file and line) and executed
//! item by item (`run`): statements act at once, words are added to the block. Invariants: a mistake of the program is
//! an alarm with a text and never goes unreported; text that is not a statement, variable or subprogram remains for the
//! tables of the machine.

mod control;
mod cursor;
mod expr;
mod flow;
mod line;
mod message;
mod outline;
mod places;
mod run;
mod signals;
mod store;

use std::sync::Arc;

use counterpoint_fault as diag;
use counterpoint_fault::{Facts, Halt};
use counterpoint_lang::value::Value;
use counterpoint_machine::model::Externals;

pub(crate) use control::Control;

use super::host::Host;
use super::interpreter::{Interpreter, Remaining, Setting};
use counterpoint_event::FileId;
use counterpoint_program::kept::{Kept, Tables};
use cursor::{Cursor, Mistake};
use expr::{Expr, Reader, Variable};

/// Why executing a block failed.
#[derive(Debug)]
enum Fault {
    /// The channel stops.
    Halt(Halt),
    /// An alarm that is still to be reported.
    Alarm(&'static Facts, String),
}

impl From<Halt> for Fault {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

impl From<Mistake> for Fault {
    fn from(mistake: Mistake) -> Self {
        Self::Alarm(mistake.facts, mistake.text)
    }
}

type Outcome<T> = Result<T, Fault>;

/// The pre-processor with its variables.
#[derive(Debug)]
pub(crate) struct Isg {
    store: store::Store,
    /// Blocks that were read.
    read: Kept<Result<line::Line, Mistake>>,
    /// A line may run again, so its compiled form is worth keeping.
    caching: bool,
    /// Labels and control blocks of files.
    places: Tables<FileId, places::Places>,
    /// The last `#SIGNAL READ` has found its signal.
    signal_read: bool,
}

impl Isg {
    /// With the external variables of a machine.
    pub(crate) fn new(external: &Externals) -> Self {
        Self {
            store: store::Store::new(external),
            read: Kept::default(),
            caching: false,
            places: Tables::default(),
            signal_read: false,
        }
    }

    /// A block of a file, read.
    fn line_of(&mut self, host: &dyn Host, file: FileId, line: u32) -> Arc<Result<line::Line, Mistake>> {
        let source = host.source(file);
        let text = source.as_ref().map(|source| source.line(line)).unwrap_or_default();
        self.read_line((file, line), text, true)
    }

    /// A block, read; kept if its text is that of the file.
    fn read_line(&mut self, key: (FileId, u32), text: &[u8], as_read: bool) -> Arc<Result<line::Line, Mistake>> {
        if let Some(line) = self.read.get(key).filter(|_| as_read) {
            return Arc::clone(line);
        }
        let line = Arc::new(line::read(text));
        if as_read && self.caching {
            self.read.insert(key, &line, text.len());
        }
        line
    }

    /// A variable in native spelling, with its indices in it or apart.
    fn spelled(name: &str, indices: &[f64]) -> Option<Variable> {
        let upper = name.trim().to_ascii_uppercase();
        let mut cursor = Cursor::new(upper.as_bytes());
        let variable = Reader::new(&mut cursor).variable().ok()?;
        cursor.end().ok()?;
        let more = || indices.iter().map(|index| Expr::constant(*index)).collect();
        Some(match variable {
            Variable::Parameter(number, own) if own.is_empty() => Variable::Parameter(number, more()),
            Variable::Named(name, own) if own.is_empty() => Variable::Named(name, more()),
            variable => variable,
        })
    }

    /// A fault becomes an alarm.
    fn reported<T>(host: &mut dyn Host, outcome: Outcome<T>) -> Result<T, Halt> {
        match outcome {
            Ok(done) => Ok(done),
            Err(Fault::Halt(halt)) => Err(halt),
            Err(Fault::Alarm(facts, text)) => {
                let text = format!("{text} in '{}'", host.block_text());
                Err(host.alarm(facts, text))
            }
        }
    }
}

impl Interpreter for Isg {
    fn block(&mut self, host: &mut dyn Host, text: &[u8]) -> Result<Remaining, Halt> {
        let done = self.carry_out(host, text);
        Self::reported(host, done)
    }

    fn restart(&mut self, reset: bool) {
        self.store.begin(reset);
        self.signal_read = false;
        self.caching = false;
    }

    fn on_call(&mut self, _: &mut dyn Host) {
        self.store.enter();
        self.caching = true;
    }

    fn on_repeat(&mut self) {
        self.store.again();
    }

    fn on_return(&mut self, _: &mut dyn Host) {
        self.store.leave();
    }

    fn forget_lines(&mut self) {
        self.read.clear();
    }

    fn variable(&mut self, host: &mut dyn Host, name: &str, indices: &[f64]) -> Result<Option<Value>, Halt> {
        let Some(variable) = Self::spelled(name, indices) else { return Ok(None) };
        match self.read(host, &variable) {
            Ok(value) => Ok(Some(Value::Real(value))),
            Err(Fault::Halt(halt)) => Err(halt),
            Err(Fault::Alarm(..)) => Ok(None),
        }
    }

    fn set_variable(&mut self, host: &mut dyn Host, name: &str, indices: &[f64], value: &Value) -> Result<bool, Halt> {
        let Some(value) = value.as_real().filter(|value| value.is_finite()) else { return Ok(false) };
        let Some(variable) = Self::spelled(name, indices) else { return Ok(false) };
        match self.assign(host, &variable, value) {
            Ok(()) => Ok(true),
            Err(Fault::Halt(halt)) => Err(halt),
            Err(Fault::Alarm(..)) => Ok(false),
        }
    }

    fn setting(&mut self, _: &mut dyn Host, _: &str, _: &[Value]) -> Setting {
        Setting::Unknown
    }

    fn memory(&self) -> u64 {
        (self.store.bytes() + self.read.bytes() + self.places.bytes()) as u64
    }
}

/// An alarm about a variable.
fn no_variable<T>(text: String) -> Outcome<T> {
    Err(Fault::Alarm(&diag::MACRO_VARIABLE, text))
}
