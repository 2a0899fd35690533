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
mod slots;
mod step;
mod units;
mod weigh;
mod window;

pub use crate::state::{MacroLimits, MacroState, MemoryTally, range, sequence_of};

use crate::bytecode::CompiledMacro;
use crate::diag::MacroDiagnostic;
use crate::fault::MacroFault;
use crate::host::{MacroHost, TracedMacro};
use crate::layout::standard_line;
use crate::program::MacroProgram;
use crate::source::Span;
use crate::value::MacroValue;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MacroEnd {
    /// At its end or at TERMAC.
    Normal,
    /// By an error in the macro.
    Error,
    /// By a used-up budget; every caller ends too.
    Budget,
}

/// Reports the notes of functions and commands.
fn report_notes(code: &CompiledMacro, place: Span, state: &mut MacroState, host: &mut dyn MacroHost) {
    for fault in std::mem::take(&mut state.notes) {
        let severity = fault.number.severity().min(4);
        report(code, place, fault, severity, state, host);
    }
}

/// Runs a macro. `arguments` become `$P1`, `$P2` … and hold their last values afterwards.
pub fn run(
    program: &MacroProgram,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    index: u16,
    arguments: &mut [MacroValue],
) -> (MacroEnd, MacroValue) {
    let Some(code) = program.macros.get(usize::from(index)) else { return (MacroEnd::Error, MacroValue::Null) };
    if state.depth == 0 {
        state.ticks = state.limits.ticks;
    }
    let end = run::enter(program, state, host, code, index, arguments);
    let value = calls::result(state, code, index).clone();
    (end, value)
}

/// Writes the pending output of open units and closes them.
pub fn close_all(state: &mut MacroState, host: &mut dyn MacroHost) {
    units::close_all(state, host);
}

fn report(
    code: &CompiledMacro,
    place: Span,
    fault: MacroFault,
    severity: u8,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
) {
    let mut diagnostic = MacroDiagnostic::new(&code.source, place, fault.number, fault.message);
    diagnostic.severity = severity;
    diagnostic.macro_name = Some(code.name.clone());
    diagnostic.in_function = code.signature.is_function;
    diagnostic.statement = Some(standard_line(code.source.slice(place)));
    state.failed |= diagnostic.is_error();
    host.report(state, diagnostic);
}

/// A macro as the trace names it.
fn shown(code: &CompiledMacro) -> TracedMacro<'_> {
    TracedMacro { name: &code.name, is_function: code.signature.is_function }
}
