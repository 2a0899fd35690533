//! `counterpoint macro`: checks, rewrites, runs and explains macros.
//!
//! *Invariant:* a running macro can access only files below the current folder, the clock and the environment.

mod alarms;
pub(crate) mod arguments;
mod check;
mod explain;
mod fmt;
mod kinds;
mod links;
mod run;
mod sandbox;
mod standalone;
mod terms;

use std::path::{Path, PathBuf};

use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang_standalone::File;

use crate::error::Error;
use crate::{say, standard_input};
#[cfg(test)]
pub(crate) use alarms::rows as alarm_rows;
use arguments::MacroCommand;
pub(crate) use explain::{diagnostic, explain, explanation, remedy, remedy_for, unknown};
pub(crate) use links::without_links;

/// Executes a command and returns the exit code.
pub(crate) fn dispatch(command: &MacroCommand) -> Result<u8, Error> {
    match command {
        MacroCommand::Check(arguments) => check::check(arguments),
        MacroCommand::Fmt(arguments) => fmt::fmt(arguments),
        MacroCommand::Run(arguments) => run::run(arguments),
        MacroCommand::Explain { what } => explain(what),
    }
}

/// Names and texts of files; bytes that are not UTF-8 become replacement characters.
fn read(paths: &[PathBuf]) -> Result<Vec<File>, Error> {
    input_once(paths)?;
    paths.iter().map(|path| Ok((name(path), String::from_utf8_lossy(&bytes(path)?).into_owned()))).collect()
}

/// Refuses a second `-`.
fn input_once(paths: &[PathBuf]) -> Result<(), Error> {
    if paths.iter().filter(|path| standard_input::is(path)).count() > 1 {
        return Err(Error::Usage(
            "standard input (-) can be read only once: give the other macros as files".to_owned(),
        ));
    }
    Ok(())
}

fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let bytes = if standard_input::is(path) {
        standard_input::read()?
    } else {
        std::fs::read(path).map_err(Error::file(path))?
    };
    Ok(bytes.strip_prefix(b"\xEF\xBB\xBF").map_or_else(|| bytes.clone(), <[u8]>::to_vec))
}

fn name(path: &Path) -> String {
    if standard_input::is(path) { standard_input::NAME.to_owned() } else { path.display().to_string() }
}

/// A finding with its line and a mark.
fn say_finding(finding: &MacroDiagnostic) {
    let style = if finding.is_error() { say::BAD } else { say::WARN };
    let text = finding.to_string();
    let (head, rest) = text.split_once(' ').unwrap_or((&text, ""));
    say::status_line(format_args!("{} {}", say::styled(style, head), rest.trim_end()));
}
