//! WRITE, READ and DELETE: files of the job that programs write line by line.
//!
//! They are files of the job by their path without `_N_` and in lower case; one without an extension is `.mpf`, one
//! without a folder lies in `mpf.dir`, which is the folder of the job itself. Channels reach them in the order of
//! simulated time. Results: 0 done, 1 a path that leads elsewhere, 3 no such file, 10 full; for READ 21 no such line,
//! 22 the table is too small, 23 the range of lines goes beyond the end of the file. *Invariant:* a result other than 0
//! has changed neither a file nor the table.

use std::sync::Arc;

use super::compiled::SiemensArgument;
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_machine::stored::StoredFile;
use counterpoint_program::shape::ProgramRange;

const NO_PATH: i64 = 1;
const NO_FILE: i64 = 3;
const FULL: i64 = 10;
const NO_LINE: i64 = 21;
const SMALL_TABLE: i64 = 22;
const BEYOND: i64 = 23;

/// Bytes of a path.
const LONGEST: usize = 200;

impl Siemens {
    /// Executes such a statement; returns whether it is one.
    pub(super) fn records(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<bool> {
        let statement = match name {
            "WRITE" => Self::write_record,
            "READ" => Self::read_records,
            "DELETE" => Self::delete_records,
            _ => return Ok(false),
        };
        let [result, file, ..] = arguments else {
            return syntax(format!("{name} needs a variable for its result and the name of a file"));
        };
        let result = self.variable_of(host, result)?;
        self.variables.writes |= name != "READ";
        let Some(Data::Text(file)) = self.argument(host, file)? else {
            return wrong_type("the name of a file is a text");
        };
        let code = match record_path(&file) {
            None => NO_PATH,
            Some(path) => statement(self, host, (&file, &path), arguments.get(2..).unwrap_or_default())?,
        };
        self.store(host, &result, Data::Int(code))?;
        Ok(true)
    }

    fn write_record(
        &mut self,
        host: &mut dyn InterpreterHost,
        (file, path): (&str, &str),
        arguments: &[SiemensArgument],
    ) -> Outcome<i64> {
        let line = arguments.first().map_or(Ok(None), |argument| self.argument(host, argument))?;
        let Some(Data::Text(line)) = line else { return wrong_type("the line of a file is a text") };
        let before = match host.has_written(path)? {
            None => self.job_text(host, file)?,
            Some(_) => None,
        };
        let text = before.map_or_else(String::new, |mut text| {
            if !text.is_empty() && !text.ends_with('\n') {
                text.push('\n');
            }
            text
        });
        Ok(if host.append(path, &format!("{text}{line}\n"))? { 0 } else { FULL })
    }

    fn read_records(
        &mut self,
        host: &mut dyn InterpreterHost,
        (file, path): (&str, &str),
        arguments: &[SiemensArgument],
    ) -> Outcome<i64> {
        let [line, count, table] = arguments else {
            return syntax("READ needs a line, a number of lines and a variable");
        };
        let table = self.variable_of(host, table)?;
        let mut range = [1, 1];
        for (slot, argument) in range.iter_mut().zip([line, count]) {
            let value = self.argument(host, argument)?;
            *slot = match value {
                None => *slot,
                Some(Data::Int(value)) => value,
                Some(_) => return wrong_type("lines of READ are integers"),
            };
        }
        let text = match host.has_written(path)? {
            None => self.job_text(host, file)?.map(Arc::from),
            Some(_) => host.written(path)?,
        };
        let Some(text) = text else { return Ok(NO_FILE) };
        let lines: Vec<&str> = text.lines().collect();
        host.work(lines.len())?;
        let [first, count] = range.map(|value| usize::try_from(value).ok());
        let (Some(first), Some(count)) = (first, count.filter(|count| (1..=lines.len()).contains(count))) else {
            return Ok(NO_LINE);
        };
        // Line 0: the last ones.
        let from = if first == 0 { lines.len() - count } else { first - 1 };
        if from >= lines.len() {
            return Ok(NO_LINE);
        }
        let Some(found) = lines.get(from..from + count) else { return Ok(BEYOND) };
        if found.len() > table.count.saturating_sub(table.at) {
            return Ok(SMALL_TABLE);
        }
        for (step, line) in found.iter().enumerate() {
            self.store(host, &table.element(step), Data::Text((*line).to_owned()))?;
        }
        Ok(0)
    }

    fn delete_records(
        &mut self,
        host: &mut dyn InterpreterHost,
        (file, path): (&str, &str),
        _: &[SiemensArgument],
    ) -> Outcome<i64> {
        match host.has_written(path)? {
            Some(true) => host.remove_written(path)?,
            None if self.job_text(host, file)?.is_some() => host.remove_written(path)?,
            _ => return Ok(NO_FILE),
        }
        Ok(0)
    }

    /// Refuses to call a program that was written, changed or removed after the job received it.
    pub(super) fn check_unchanged(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        place: Option<(FileId, ProgramRange)>,
    ) -> Outcome<()> {
        let files = host.files();
        let own = place.and_then(|(file, _)| files.get(usize::from(file)));
        let names = match own {
            Some(own) if own.starts_with(StoredFile::ROOT) => return Ok(()),
            Some(own) => vec![own.clone()],
            None => vec![format!("{name}.spf"), format!("{name}.mpf")],
        };
        for path in names.iter().filter_map(|name| record_path(name)) {
            let Some(exists) = host.has_written(&path)? else { continue };
            let text = if exists {
                format!("'{path}' has been written by a program; calls of such programs are not emulated")
            } else {
                format!("'{path}' has been removed by DELETE")
            };
            let facts = if exists { &diag::SIEMENS_STATE } else { &diag::SUBPROGRAM_MISSING };
            return Err(SiemensBlockError::Alarm(facts, text));
        }
        Ok(())
    }

    /// Whether programs have written such a file; false if it was removed.
    pub(super) fn has_record(&mut self, host: &mut dyn InterpreterHost, file: &str) -> Outcome<Option<bool>> {
        Ok(match record_path(file) {
            Some(path) => host.has_written(&path)?,
            None => None,
        })
    }

    /// Text of a program of the job.
    fn job_text(&mut self, host: &mut dyn InterpreterHost, file: &str) -> Outcome<Option<String>> {
        let Some(id) = self.file_by_path(host, file) else { return Ok(None) };
        let files = host.files();
        if files.get(usize::from(id)).is_none_or(|name| name.starts_with(StoredFile::ROOT)) {
            return Ok(None);
        }
        host.load(id)?;
        let Some(source) = host.source(id) else { return Ok(None) };
        let line = |line| String::from_utf8_lossy(source.line(line)).trim_end_matches(['\r', '\n']).to_owned();
        Ok(Some(source.walk(1, source.lines()).map(line).collect::<Vec<_>>().join("\n")))
    }
}

/// Path of such a file in the job; none for one that leads elsewhere.
fn record_path(file: &str) -> Option<String> {
    let path = super::files::file_path(file.trim());
    let path = path.strip_prefix("mpf.dir/").unwrap_or(&path);
    let plain = |part: &str| {
        !part.is_empty()
            && !part.starts_with('.')
            && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'.'))
    };
    if path.len() > LONGEST || !path.split('/').all(plain) {
        return None;
    }
    let name = path.rsplit_once('/').map_or(path, |(_, name)| name);
    Some(if name.contains('.') { path.to_owned() } else { format!("{path}.mpf") })
}
