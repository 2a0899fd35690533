//! Macros without a machine: checked, and run against a host that keeps everything in memory.
//!
//! Serves `macro check` and `macro run` of the command line, and tests of macros.

mod answers;
mod files;
mod identifiers;
mod model;
mod order;
mod output;
mod outside;
mod program;
mod registers;
mod standalone;
mod tables;
mod variables;

pub use answers::PreparedAnswer;
pub use files::VirtualDisk;
pub use identifiers::Spelling;
pub use output::MacroOutput;
pub use outside::{HostEnvironment, OutputStream};
pub use program::NcProgram;
pub use standalone::Standalone;
pub use variables::Domain;

use counterpoint_lang::compile::{self, CompileOptions, DeclarationStrictness, MacroProgram, MacroRole};
use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang::host::ConsoleHost;
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{self, MacroEnd, MacroLimits, MacroState};

/// All diagnostics of a file.
#[must_use]
pub fn check(text: &str, name: &str) -> Vec<MacroDiagnostic> {
    let options = CompileOptions { uninitialised: true, ..CompileOptions::default() };
    compile::add(&mut MacroProgram::new(), &mut Standalone::new(), MacroSource::new(name, text), options).diagnostics
}

/// A name and a text.
pub type File = (String, String);

/// All diagnostics of files (name and text) that are used together, in their order. They know each other's functions
/// and shared variables. Under strong declaration the last one is a macro, those before it declare.
#[must_use]
pub fn check_all(files: &[File], host: &mut Standalone, strong: DeclarationStrictness) -> Vec<Vec<MacroDiagnostic>> {
    let mut program = MacroProgram::new();
    let mut found = vec![Vec::new(); files.len()];
    for at in order::order(files) {
        if let (Some(file), Some(place)) = (files.get(at), found.get_mut(at)) {
            let options = options(at + 1 == files.len(), strong);
            *place = compile::add(&mut program, host, source(file), options).diagnostics;
        }
    }
    found
}

fn source((name, text): &File) -> MacroSource {
    MacroSource::new(name.as_str(), text.as_str())
}

fn options(last: bool, strong: DeclarationStrictness) -> CompileOptions {
    let place = if last { MacroRole::Any } else { MacroRole::Library };
    CompileOptions { uninitialised: true, place, strong, ..CompileOptions::default() }
}

/// How to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions {
    /// Trace every statement.
    pub trace: bool,
    /// Strong declaration: the last file is a macro, those before it declare.
    pub strong: DeclarationStrictness,
    /// Budgets.
    pub limits: MacroLimits,
}

/// Runs the last of `files` (name and text); the others define functions. Everything that is printed, traced and found
/// goes to the host as it happens, findings of the checker first. Tells whether there was an error.
pub fn run(files: &[File], host: &mut Standalone, options: RunOptions) -> bool {
    let mut program = MacroProgram::new();
    let mut state = MacroState::new(options.limits);
    let (mut failed, mut macros) = (false, Vec::new());
    let order = order::order(files).into_iter().filter(|at| at + 1 < files.len());
    for at in order.chain(files.len().checked_sub(1)) {
        let Some(file) = files.get(at) else { continue };
        let how = CompileOptions { trace: options.trace, ..self::options(at + 1 == files.len(), options.strong) };
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
        if end != MacroEnd::Normal {
            break;
        }
    }
    vm::close_all(&mut state, host);
    host.clean();
    state.failed
}

/// An argument as a text.
fn text(arguments: &[MacroValue], position: usize) -> &str {
    arguments.get(position).and_then(MacroValue::as_text).unwrap_or("")
}
