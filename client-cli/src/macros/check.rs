//! `macro check`: reports every mistake in every file.

use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang_standalone::check_all;
use serde_json::json;

use super::arguments::MacroCheckArgs;
use super::sandbox::MacroSandbox;
use super::say_finding;
use crate::error::Error;
use crate::say;

pub(super) fn check(arguments: &MacroCheckArgs) -> Result<u8, Error> {
    let files = super::read(&arguments.files)?;
    let mut host = super::standalone::standalone();
    host.attach(Box::new(MacroSandbox::here()?));
    let found = check_all(&files, &mut host, arguments.strong.into());
    let errors = found.iter().flatten().filter(|finding| finding.is_error()).count();
    let warnings = found.iter().flatten().count() - errors;
    if arguments.json {
        let all: Vec<_> = files.iter().zip(&found).map(|((name, _), found)| of_file(name, found)).collect();
        let document = json!({ "errors": errors, "warnings": warnings, "files": all });
        say::verdict(format!("{document:#}\n").as_bytes())?;
    } else {
        found.iter().flatten().for_each(say_finding);
        let verdict = format!("files: {}, errors: {errors}, warnings: {warnings}\n", files.len());
        say::verdict(verdict.as_bytes())?;
    }
    Ok(u8::from(errors > 0))
}

fn of_file(name: &str, found: &[MacroDiagnostic]) -> serde_json::Value {
    json!({ "file": name, "findings": found.iter().map(as_json).collect::<Vec<_>>() })
}

fn as_json(finding: &MacroDiagnostic) -> serde_json::Value {
    json!({
        "file": finding.file,
        "line": finding.line,
        "column": finding.column,
        "width": finding.width,
        "number": finding.number.to_string(),
        "name": finding.number.name(),
        "severity": finding.severity,
        "type": finding.word().to_lowercase(),
        "text": finding.message,
        "help": finding.help,
        "source": finding.source_line,
    })
}
