//! Output of a running macro, and its input from the console.

use crate::diag::MacroDiagnostic;
use crate::state::MacroState;

/// A macro as the trace names it.
#[derive(Clone, Copy, Debug)]
pub struct TracedMacro<'a> {
    /// Its name.
    pub name: &'a str,
    /// It is a user function.
    pub is_function: bool,
}

/// A step of the macro trace. Its text is the line in the documented layout, without the parts that only a control
/// knows.
#[derive(Clone, Copy, Debug)]
pub enum TraceStep<'a> {
    /// A macro begins.
    Entering(TracedMacro<'a>),
    /// A statement is about to be executed, in standard style.
    Statement(TracedMacro<'a>, &'a str),
    /// A macro is left; the name of the macro that continues, none for the outermost.
    Leaving(TracedMacro<'a>, Option<&'a str>),
}

impl std::fmt::Display for TraceStep<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            TraceStep::Entering(code) => write!(f, " Macro:* Entering {}", code.name),
            TraceStep::Statement(_, text) => write!(f, " Macro:  {text}"),
            TraceStep::Leaving(code, outer) => {
                write!(f, " Macro:* Leaving {}, Returning to {}", code.name, outer.unwrap_or("regular processing"))
            }
        }
    }
}

/// Console, diagnostics and trace.
pub trait ConsoleHost {
    /// One line from the console.
    fn read_console(&mut self) -> Option<String> {
        None
    }

    /// One line to the console.
    fn write_console(&mut self, line: &str) {
        let _ = line;
    }

    /// Reports a diagnostic of a running macro.
    /// The state is that of the running macro, so that a host may run another one first.
    fn report(&mut self, state: &mut MacroState, diagnostic: MacroDiagnostic);

    /// Severity and text of a diagnostic of the host's tables, for `ERROR/number`.
    fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        let _ = number;
        None
    }

    /// Takes one step of the macro trace.
    fn trace(&mut self, step: TraceStep<'_>);
}
