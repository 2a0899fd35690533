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
use counterpoint_fault::{DiagnosticFacts, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::model::Externals;

pub use control::IsgDialect;

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::{Interpreter, Remaining, SettingOutcome};
use counterpoint_event::FileId;
use counterpoint_program::kept::{LineCache, TableCache};
use cursor::{IsgCursor, IsgSyntaxError};
use expr::{Expr, IsgExpressionReader, IsgVariable};

/// Why executing a block failed.
#[derive(Debug)]
enum IsgBlockError {
    /// The channel stops.
    Halt(Halt),
    /// An alarm that is still to be reported.
    Alarm(&'static DiagnosticFacts, String),
}

impl From<Halt> for IsgBlockError {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

impl From<IsgSyntaxError> for IsgBlockError {
    fn from(mistake: IsgSyntaxError) -> Self {
        Self::Alarm(mistake.facts, mistake.text)
    }
}

type Outcome<T> = Result<T, IsgBlockError>;

/// The pre-processor with its variables.
#[derive(Debug)]
pub(crate) struct Isg {
    store: store::IsgVariableStore,
    /// Blocks that were read.
    read: LineCache<Result<line::IsgLine, IsgSyntaxError>>,
    /// A line may run again, so its compiled form is worth keeping.
    caching: bool,
    /// Labels and control blocks of files.
    places: TableCache<FileId, places::IsgFileIndex>,
    /// The last `#SIGNAL READ` has found its signal.
    signal_read: bool,
}

impl Isg {
    /// With the external variables of a machine.
    pub(crate) fn new(external: &Externals) -> Self {
        Self {
            store: store::IsgVariableStore::new(external),
            read: LineCache::default(),
            caching: false,
            places: TableCache::default(),
            signal_read: false,
        }
    }

    /// A block of a file, read.
    fn line_of(
        &mut self,
        host: &dyn InterpreterHost,
        file: FileId,
        line: u32,
    ) -> Arc<Result<line::IsgLine, IsgSyntaxError>> {
        let source = host.source(file);
        let text = source.as_ref().map(|source| source.line(line)).unwrap_or_default();
        self.read_line((file, line), text, true)
    }

    /// A block, read; kept if its text is that of the file.
    fn read_line(
        &mut self,
        key: (FileId, u32),
        text: &[u8],
        as_read: bool,
    ) -> Arc<Result<line::IsgLine, IsgSyntaxError>> {
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
    fn spelled(name: &str, indices: &[f64]) -> Option<IsgVariable> {
        let upper = name.trim().to_ascii_uppercase();
        let mut cursor = IsgCursor::new(upper.as_bytes());
        let variable = IsgExpressionReader::new(&mut cursor).variable().ok()?;
        cursor.end().ok()?;
        let more = || indices.iter().map(|index| Expr::constant(*index)).collect();
        Some(match variable {
            IsgVariable::Parameter(number, own) if own.is_empty() => IsgVariable::Parameter(number, more()),
            IsgVariable::Named(name, own) if own.is_empty() => IsgVariable::Named(name, more()),
            variable => variable,
        })
    }

    /// A fault becomes an alarm.
    fn reported<T>(host: &mut dyn InterpreterHost, outcome: Outcome<T>) -> Result<T, Halt> {
        match outcome {
            Ok(done) => Ok(done),
            Err(IsgBlockError::Halt(halt)) => Err(halt),
            Err(IsgBlockError::Alarm(facts, text)) => {
                let text = format!("{text} in '{}'", host.block_text());
                Err(host.alarm(facts, text))
            }
        }
    }
}

impl Interpreter for Isg {
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt> {
        let done = self.carry_out(host, text);
        Self::reported(host, done)
    }

    fn restart(&mut self, reset: bool) {
        self.store.begin(reset);
        self.signal_read = false;
        self.caching = false;
    }

    fn on_call(&mut self, _: &mut dyn InterpreterHost) {
        self.store.enter();
        self.caching = true;
    }

    fn on_repeat(&mut self) {
        self.store.again();
    }

    fn on_return(&mut self, _: &mut dyn InterpreterHost) {
        self.store.leave();
    }

    fn forget_lines(&mut self) {
        self.read.clear();
    }

    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt> {
        let Some(variable) = Self::spelled(name, indices) else { return Ok(None) };
        match self.read(host, &variable) {
            Ok(value) => Ok(Some(MacroValue::Real(value))),
            Err(IsgBlockError::Halt(halt)) => Err(halt),
            Err(IsgBlockError::Alarm(..)) => Ok(None),
        }
    }

    fn set_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
        value: &MacroValue,
    ) -> Result<bool, Halt> {
        let Some(value) = value.as_real().filter(|value| value.is_finite()) else { return Ok(false) };
        let Some(variable) = Self::spelled(name, indices) else { return Ok(false) };
        match self.assign(host, &variable, value) {
            Ok(()) => Ok(true),
            Err(IsgBlockError::Halt(halt)) => Err(halt),
            Err(IsgBlockError::Alarm(..)) => Ok(false),
        }
    }

    fn setting(&mut self, _: &mut dyn InterpreterHost, _: &str, _: &[MacroValue]) -> SettingOutcome {
        SettingOutcome::Unknown
    }

    fn memory(&self) -> u64 {
        (self.store.bytes() + self.read.bytes() + self.places.bytes()) as u64
    }
}

/// An alarm about a variable.
fn no_variable<T>(text: String) -> Outcome<T> {
    Err(IsgBlockError::Alarm(&diag::MACRO_VARIABLE, text))
}
