//! Output of a running macro, and its input from the console.

use crate::diag::Diagnostic;
use crate::state::State;

/// A macro as the trace names it.
#[derive(Clone, Copy, Debug)]
pub struct Macro<'a> {
    /// Its name.
    pub name: &'a str,
    /// It is a user function.
    pub is_function: bool,
}

/// A step of the macro trace. Its text is the line in the documented layout, without the parts that only a control
/// knows.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// A macro begins.
    Entering(Macro<'a>),
    /// A statement is about to be executed, in standard style.
    Statement(Macro<'a>, &'a str),
    /// A macro is left; the name of the macro that continues, none for the outermost.
    Leaving(Macro<'a>, Option<&'a str>),
}

impl std::fmt::Display for Step<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Step::Entering(code) => write!(f, " Macro:* Entering {}", code.name),
            Step::Statement(_, text) => write!(f, " Macro:  {text}"),
            Step::Leaving(code, outer) => {
                write!(f, " Macro:* Leaving {}, Returning to {}", code.name, outer.unwrap_or("regular processing"))
            }
        }
    }
}

/// Console, diagnostics and trace.
pub trait Dialog {
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
    fn report(&mut self, state: &mut State, diagnostic: Diagnostic);

    /// Severity and text of a diagnostic of the host's tables, for `ERROR/number`.
    fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        let _ = number;
        None
    }

    /// Takes one step of the macro trace.
    fn trace(&mut self, step: Step<'_>);
}
