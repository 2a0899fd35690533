//! `macro fmt`: files of macros in one style.
//!
//! *Invariant:* a file is replaced as a whole or not at all, and only if its text changes; it keeps its line endings.

use std::io::Write as _;
use std::path::Path;

use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang::layout;

use super::arguments::Fmt;
use super::say_finding;
use crate::error::Error;
use crate::{say, standard_input};

pub(super) fn fmt(arguments: &Fmt) -> Result<u8, Error> {
    super::input_once(&arguments.files)?;
    let mut code = 0;
    for path in &arguments.files {
        code = code.max(one(path, arguments)?);
    }
    Ok(code)
}

/// Formats one file; returns 1 if it has errors, or would change under `--check`.
fn one(path: &Path, arguments: &Fmt) -> Result<u8, Error> {
    let piped = standard_input::is(path);
    let text = text(path)?;
    let new = match formatted(&text, arguments.style.into()) {
        Ok(new) => new,
        Err(found) => {
            let name = super::name(path);
            for mut finding in found {
                finding.file.clone_from(&name);
                say_finding(&finding);
            }
            return Ok(1);
        }
    };
    if arguments.check {
        if new == text {
            return Ok(0);
        }
        say::data(format!("{}\n", path.display()).as_bytes())?;
        return Ok(1);
    }
    if piped || arguments.stdout {
        say::data(new.as_bytes())?;
    } else if new != text {
        replace(path, &new)?;
    }
    Ok(0)
}

fn formatted(text: &str, style: layout::SourceStyle) -> Result<String, Vec<MacroDiagnostic>> {
    let new = layout::format(text, style)?;
    let carriage_returns = text.find('\n').is_some_and(|at| text.get(..at).is_some_and(|line| line.ends_with('\r')));
    Ok(if carriage_returns { new.replace('\n', "\r\n") } else { new })
}

fn text(path: &Path) -> Result<String, Error> {
    utf8(super::bytes(path)?, &super::name(path))
}

/// A text that is not UTF-8 would be written back with other characters, so it is refused.
fn utf8(bytes: Vec<u8>, name: &str) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|_| Error::Usage(format!("{name}: the text is not UTF-8")))
}

/// Writes a new file beside the old one and then replaces the old one, keeping its permissions.
fn replace(path: &Path, text: &str) -> Result<(), Error> {
    let failed = || Error::file(path);
    let real = std::fs::canonicalize(path).map_err(failed())?;
    let permissions = std::fs::metadata(&real).map_err(failed())?.permissions();
    let folder = real.parent().unwrap_or_else(|| Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(failed())?;
    file.write_all(text.as_bytes()).map_err(failed())?;
    file.as_file().sync_all().map_err(failed())?;
    std::fs::set_permissions(file.path(), permissions).map_err(failed())?;
    file.persist(&real).map_err(|error| failed()(error.error))?;
    Ok(())
}
