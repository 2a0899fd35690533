//! Checking, formatting and running files of macros, as a command line or an editor needs it.
//!
//! Invariant: formatting changes no meaning, keeps every comment, and formatting twice is formatting once.

mod layout;

pub use layout::{Style, format, standard_line};

use crate::compile::{self, Options, Program};
use crate::diag::Diagnostic;
use crate::host::Test;
use crate::source::Source;
use crate::vm::{self, End, Limits, State};
use std::io::Write;

/// All diagnostics of a file.
#[must_use]
pub fn check(text: &str, name: &str) -> Vec<Diagnostic> {
    let options = Options { uninitialised: true, ..Options::default() };
    compile::add(&mut Program::new(), &mut Test::new(), Source::new(name, text), options).diagnostics
}

/// How to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions {
    /// Print the trace of every statement.
    pub trace: bool,
    /// Budgets.
    pub limits: Limits,
}

/// Runs the last of `files` (name and text) with a host without a machine; the others define functions. What it
/// PPRINTs goes to `out`, one line each, diagnostics go to `error`. The answer is 0, or 1 after an error.
///
/// # Errors
/// `out` or `error` cannot be written.
pub fn run(
    files: &[(String, String)],
    out: &mut dyn Write,
    error: &mut dyn Write,
    options: RunOptions,
) -> std::io::Result<u8> {
    let mut program = Program::new();
    let mut host = Test::new();
    host.files = files.iter().cloned().collect();
    let compile_options = Options { uninitialised: true, trace: options.trace, ..Options::default() };
    let (mut failed, mut macros) = (false, Vec::new());
    for (name, text) in files {
        let added = compile::add(&mut program, &mut host, Source::new(name.as_str(), text.as_str()), compile_options);
        failed |= added.has_errors();
        macros = added.macros;
        for diagnostic in added.diagnostics {
            write!(error, "{diagnostic}")?;
        }
    }
    if failed {
        return Ok(1);
    }
    let mut state = State::new(options.limits);
    for index in macros {
        let (end, _) = vm::run(&program, &mut state, &mut host, index, &mut []);
        if end != End::Normal {
            break;
        }
    }
    vm::close_all(&mut state, &mut host);
    let lines = if options.trace { &host.traced } else { &host.printed };
    for line in lines {
        writeln!(out, "{line}")?;
    }
    for diagnostic in &host.diagnostics {
        write!(error, "{diagnostic}")?;
    }
    Ok(u8::from(state.failed))
}
