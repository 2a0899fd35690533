//! The machine that runs compiled macros.
//!
//! *Invariant:* numeric instructions allocate nothing; every backward jump and call costs ticks, so nothing runs
//! indefinitely; a fault of severity 8 ends the innermost macro and its caller continues, a used-up budget ends all of
//! them. Facts: reference macro-language.md 1.4, 1.7, 2, 3.

mod bodies;
mod calls;
mod commands;
mod data;
mod fast;
mod homes;
mod light;
mod run;
mod step;
mod units;
mod weigh;

pub use crate::state::{Limits, Scale, State, range, sequence_of};

use crate::bytecode::Code;
use crate::diag::Diagnostic;
use crate::fault::Fault;
use crate::host::{Host, Macro};
use crate::layout::standard_line;
use crate::program::Program;
use crate::source::Span;
use crate::value::Value;

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

/// Reports the notes of functions and commands.
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

/// Writes the pending output of open units and closes them.
pub fn close_all(state: &mut State, host: &mut dyn Host) {
    units::close_all(state, host);
}

fn report(code: &Code, place: Span, fault: Fault, severity: u8, state: &mut State, host: &mut dyn Host) {
    let mut diagnostic = Diagnostic::new(&code.source, place, fault.number, fault.message);
    diagnostic.severity = severity;
    diagnostic.macro_name = Some(code.name.clone());
    diagnostic.in_function = code.signature.is_function;
    diagnostic.statement = Some(standard_line(code.source.slice(place)));
    state.failed |= diagnostic.is_error();
    host.report(state, diagnostic);
}

/// A macro as the trace names it.
fn shown(code: &Code) -> Macro<'_> {
    Macro { name: &code.name, is_function: code.signature.is_function }
}
