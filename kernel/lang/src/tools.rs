//! Checking, formatting, running and explaining, as a command line or an editor needs it.
//!
//! Invariant: formatting changes no meaning, keeps every comment, and formatting twice is formatting once.

pub mod explain;
mod order;

pub use crate::layout::{Style, format, standard_line};

use crate::compile::{self, Options, Place, Program, Strong};
use crate::diag::Diagnostic;
use crate::host::{Host, Test};
use crate::source::Source;
use crate::vm::{self, End, Limits, State};

/// All diagnostics of a file.
#[must_use]
pub fn check(text: &str, name: &str) -> Vec<Diagnostic> {
    let options = Options { uninitialised: true, ..Options::default() };
    compile::add(&mut Program::new(), &mut Test::new(), Source::new(name, text), options).diagnostics
}

/// A name and a text.
pub type File = (String, String);

/// All diagnostics of files (name and text) that are used together, in their order. They know each other's functions and
/// shared variables. Under strong declaration the last one is a macro, those before it declare.
#[must_use]
pub fn check_all(files: &[File], host: &mut Test, strong: Strong) -> Vec<Vec<Diagnostic>> {
    let mut program = Program::new();
    let mut found = vec![Vec::new(); files.len()];
    for at in order::order(files) {
        if let (Some(file), Some(place)) = (files.get(at), found.get_mut(at)) {
            let options = options(at + 1 == files.len(), strong);
            *place = compile::add(&mut program, host, source(file), options).diagnostics;
        }
    }
    found
}

fn source((name, text): &File) -> Source {
    Source::new(name.as_str(), text.as_str())
}

fn options(last: bool, strong: Strong) -> Options {
    let place = if last { Place::Any } else { Place::Library };
    Options { uninitialised: true, place, strong, ..Options::default() }
}

/// How to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions {
    /// Trace every statement.
    pub trace: bool,
    /// Strong declaration: the last file is a macro, those before it declare.
    pub strong: Strong,
    /// Budgets.
    pub limits: Limits,
}

/// Runs the last of `files` (name and text); the others define functions. Everything that is printed, traced and found
/// goes to the host as it happens, findings of the checker first. Tells whether there was an error.
pub fn run(files: &[File], host: &mut Test, options: RunOptions) -> bool {
    let mut program = Program::new();
    let mut state = State::new(options.limits);
    let (mut failed, mut macros) = (false, Vec::new());
    let order = order::order(files).into_iter().filter(|at| at + 1 < files.len());
    for at in order.chain(files.len().checked_sub(1)) {
        let Some(file) = files.get(at) else { continue };
        let how = Options { trace: options.trace, ..self::options(at + 1 == files.len(), options.strong) };
        let added = compile::add(&mut program, host, source(file), how);
        failed |= added.has_errors();
        macros = added.macros;
        added.diagnostics.into_iter().for_each(|diagnostic| host.report(&mut state, diagnostic));
    }
    if failed {
        return true;
    }
    for index in macros {
        let (end, _) = vm::run(&program, &mut state, host, index, &mut []);
        if end != End::Normal {
            break;
        }
    }
    vm::close_all(&mut state, host);
    host.clean();
    state.failed
}
