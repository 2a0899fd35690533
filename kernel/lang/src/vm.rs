//! The machine that runs compiled macros.
//!
//! Invariant: numeric instructions allocate nothing; every backward jump and call costs ticks, so nothing runs for
//! ever; a fault of severity 8 ends the innermost macro and its caller goes on, a used-up budget ends all of them.
//! Facts: reference macro-language.md 1.4, 1.7, 2, 3.

mod bodies;
mod calls;
pub(crate) mod commands;
mod data;
mod fast;
mod homes;
mod light;
mod memory;
mod run;
mod step;
pub(crate) mod units;

pub(crate) use data::{pay_to_look_inside, pay_to_write};
pub use data::{range, sequence_of};
pub use memory::Scale;
pub use units::Unit;

use crate::bytecode::Code;
use crate::compile::Program;
use crate::diag::{Diagnostic, Number};
use crate::fault::{Fault, Outcome};
use crate::format::Format;
use crate::host::Host;
use crate::pattern::Pattern;
use crate::source::Span;
use crate::value::Value;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// What macros may use up.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Instructions of one run of a macro with everything it calls.
    pub ticks: u64,
    /// Macros active at once.
    pub depth: u32,
    /// Bytes of a text.
    pub text: usize,
    /// Elements of a sequence or an array.
    pub elements: usize,
    /// Units open at once.
    pub units: usize,
    /// Bytes that the values of all macros may keep.
    pub memory: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { ticks: 50_000_000, depth: 100_000, text: 1 << 20, elements: 1_000_000, units: 10, memory: 256 << 20 }
    }
}

/// Everything that lives from macro to macro: the object's variables, open units, budgets, caches.
#[derive(Debug)]
pub struct State {
    /// Budgets.
    pub limits: Limits,
    /// Ticks left; set by [`run`] for the outermost macro.
    pub ticks: u64,
    /// Macros active now.
    pub depth: u32,
    /// `$ERRNO`
    pub status: i32,
    /// `$CI`, 1-based.
    pub channel: u32,
    /// `$CHSIZ`
    pub channels: u32,
    /// A diagnostic of severity 8 or more was reported.
    pub failed: bool,
    objects: Vec<Value>,
    /// Frame of every macro, none while it runs.
    frames: Vec<Option<Box<calls::Frame>>>,
    units: FxHashMap<u8, Unit>,
    formats: FxHashMap<(String, bool), Arc<Format>>,
    patterns: FxHashMap<String, Arc<Pattern>>,
    names: Vec<String>,
    buffer: Vec<Value>,
    /// Shared variables that lie in registers of the running macro, a bit each.
    at_home: u64,
    notes: Vec<Fault>,
    /// Ticks when a stop of the run was looked at last.
    looked: u64,
    /// Bytes of what formats and patterns remember.
    remembered: [usize; 2],
    memory: memory::Memory,
}

/// Bytes of formats, and of patterns, that are remembered.
const MOST_REMEMBERED: usize = 4 << 20;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// At its end or at TERMAC.
    Normal,
    /// By an error in the macro.
    Error,
    /// By a used-up budget; every caller ends too.
    Budget,
}

impl State {
    /// A fresh state.
    #[must_use]
    pub fn new(limits: Limits) -> State {
        State {
            limits,
            ticks: limits.ticks,
            depth: 0,
            status: 0,
            channel: 1,
            channels: 1,
            failed: false,
            objects: Vec::new(),
            frames: Vec::new(),
            units: FxHashMap::default(),
            formats: FxHashMap::default(),
            patterns: FxHashMap::default(),
            names: Vec::new(),
            buffer: Vec::new(),
            at_home: 0,
            notes: Vec::new(),
            looked: limits.ticks,
            remembered: [0; 2],
            memory: memory::Memory::new(limits.memory),
        }
    }

    /// A variable of the object's store.
    pub fn object(&mut self, index: u32) -> Option<&mut Value> {
        let index = index as usize;
        if self.objects.len() <= index {
            self.objects.resize(index + 1, Value::Unset);
        }
        self.objects.get_mut(index)
    }

    /// The compiled form of a format text, remembered.
    ///
    /// # Errors
    /// The format is malformed.
    pub fn format(&mut self, text: &str, input: bool) -> Outcome<Arc<Format>> {
        let key = (text.to_owned(), input);
        if let Some(format) = self.formats.get(&key) {
            return Ok(Arc::clone(format));
        }
        self.spend(text.len() / 16)?;
        let format = Arc::new(if input { Format::input(text)? } else { Format::output(text)? });
        let size = text.len() + format.size();
        if self.formats.len() >= 1000 || self.remembered[0] + size > MOST_REMEMBERED {
            self.formats.clear();
            self.remembered[0] = 0;
        }
        if size > MOST_REMEMBERED {
            return Ok(format);
        }
        self.remembered[0] += size;
        self.formats.insert(key, Arc::clone(&format));
        Ok(format)
    }

    /// The compiled form of a regular expression, remembered.
    ///
    /// # Errors
    /// The expression is malformed.
    pub fn pattern(&mut self, text: &str) -> Outcome<Arc<Pattern>> {
        if let Some(pattern) = self.patterns.get(text) {
            return Ok(Arc::clone(pattern));
        }
        self.spend(text.len() / 16)?;
        let pattern = Arc::new(Pattern::new(text)?);
        self.spend(pattern.size() / 64)?;
        let size = text.len() + pattern.size();
        if self.patterns.len() >= 1000 || self.remembered[1] + size > MOST_REMEMBERED {
            self.patterns.clear();
            self.remembered[1] = 0;
        }
        if size > MOST_REMEMBERED {
            return Ok(pattern);
        }
        self.remembered[1] += size;
        self.patterns.insert(text.to_owned(), Arc::clone(&pattern));
        Ok(pattern)
    }

    /// Refuses a text that is too long.
    ///
    /// # Errors
    /// The text is larger than the budget.
    pub fn check_text(&self, length: usize) -> Outcome<()> {
        if length <= self.limits.text {
            return Ok(());
        }
        Err(Fault::new(Number::SIZE, format!("a text has more than {} bytes", self.limits.text)))
    }

    /// Refuses a sequence or array that is too long.
    ///
    /// # Errors
    /// There are more elements than the budget allows.
    pub fn check_elements(&self, length: usize) -> Outcome<()> {
        if length <= self.limits.elements {
            return Ok(());
        }
        Err(Fault::new(Number::SIZE, format!("there are more than {} elements", self.limits.elements)))
    }

    /// Notes a warning of a function that goes on with `$NULL`; it is reported with the place of the
    /// call, as a warning at most.
    pub fn warn(&mut self, fault: Fault) {
        self.notes.push(fault);
    }

    /// Uses up ticks for work done inside one instruction.
    ///
    /// # Errors
    /// None are left.
    pub fn spend(&mut self, ticks: usize) -> Outcome<()> {
        let ticks = ticks as u64;
        if self.ticks < ticks {
            self.ticks = 0;
            return Err(Fault::new(Number::TICKS, format!("the budget of {} steps is used up", self.limits.ticks)));
        }
        self.ticks -= ticks;
        Ok(())
    }
}

/// Reports what functions and commands noted.
fn report_notes(code: &Code, place: Span, state: &mut State, host: &mut dyn Host) {
    for fault in std::mem::take(&mut state.notes) {
        let severity = fault.number.severity().min(4);
        report(code, place, fault, severity, state, host);
    }
}

/// Runs a macro. `arguments` become `$P1`, `$P2` … and hold their last values afterwards.
pub fn run(
    program: &Program,
    state: &mut State,
    host: &mut dyn Host,
    index: u16,
    arguments: &mut [Value],
) -> (End, Value) {
    let Some(code) = program.macros.get(usize::from(index)) else { return (End::Error, Value::Null) };
    if state.depth == 0 {
        state.ticks = state.limits.ticks;
    }
    let end = calls::enter(program, state, host, code, index, arguments);
    let value = calls::result(state, code, index).clone();
    (end, value)
}

/// Writes what open units still hold and closes them.
pub fn close_all(state: &mut State, host: &mut dyn Host) {
    units::close_all(state, host);
}

fn report(code: &Code, place: Span, fault: Fault, severity: u8, state: &mut State, host: &mut dyn Host) {
    let mut diagnostic = Diagnostic::new(&code.source, place, fault.number, fault.message);
    diagnostic.severity = severity;
    diagnostic.macro_name = Some(code.name.clone());
    diagnostic.in_function = code.is_function;
    diagnostic.statement = Some(crate::tools::standard_line(code.source.slice(place)));
    state.failed |= diagnostic.is_error();
    host.report(state, diagnostic);
}
