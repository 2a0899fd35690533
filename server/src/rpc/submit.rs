//! Turns a submit into a record, or says which field is wrong.
//!
//! Invariant: a record that passes names an existing machine, only clean paths, and only blobs that are there.

use std::collections::BTreeMap;

use counterpoint_kernel::dialog::answers::{Answer, Value};
use counterpoint_kernel::job::Program;
use counterpoint_kernel::options::{Limits, Options};
use counterpoint_proto::v1;
use serde::Serialize;

use crate::blobs::{digest, is_digest};
use crate::jobs::Core;
use crate::ledger::record::{Record, Runs, now_ms};
use crate::machines::{Definition, is_shipped};
use crate::reason::Refusal;

/// Checks a request and makes the record of a new job.
pub(super) fn record(core: &Core, tenant: &str, request: v1::SubmitJobRequest) -> Result<Record, Refusal> {
    check_request_id(&request.request_id)?;
    let files = files(core, &request.files)?;
    let programs = programs(core, &request.programs, &files)?;
    let files: Vec<_> = files.into_iter().collect();
    let asked = request.options.unwrap_or_default();
    let (wall_ms, max_job_bytes) = asked.limits.map_or((0, 0), |limits| (limits.wall_ms, limits.max_job_bytes));
    let mut options = options(asked)?;
    let content = content(&request.machine, &programs, &files, &options, (wall_ms, max_job_bytes));
    // The maxima of the server are not part of what was submitted.
    options.limits = core.options.maxima.capped(&options.limits);
    let machine = machine(core, tenant, &request.machine)?;
    core.blobs.of(tenant).require(&mut files.iter().map(|(_, digest)| digest))?;
    // The ledger gives the job its name when it accepts it.
    Ok(Record {
        content,
        tenant: tenant.to_owned(),
        request_id: request.request_id,
        machine_name: request.machine,
        programs,
        files,
        options,
        runs: Runs { wall_ms, max_job_bytes, ..Runs::default() },
        submitted_ms: now_ms(),
        ..Record::queued(machine)
    })
}

fn check_request_id(id: &str) -> Result<(), Refusal> {
    let allowed = |b: u8| b.is_ascii_alphanumeric() || b"._:-".contains(&b);
    if (1..=128).contains(&id.len()) && id.bytes().all(allowed) {
        return Ok(());
    }
    Err(Refusal::field("request_id", "must be 1 to 128 characters of A-Z a-z 0-9 . _ : -"))
}

/// Checks paths and digests of a list of files.
pub(super) fn check_file(field: &str, path: &str, digest: &str) -> Result<(), Refusal> {
    if !path_is_clean(path) {
        return Err(Refusal::field(
            format!("{field}.path"),
            "must be relative, with / between parts, without . and ..",
        ));
    }
    if !is_digest(digest) {
        return Err(Refusal::field(format!("{field}.digest"), "must be 64 lower-case hexadecimal digits"));
    }
    Ok(())
}

fn files(core: &Core, files: &[v1::FileRef]) -> Result<BTreeMap<String, String>, Refusal> {
    if files.len() > core.options.maxima.max_files {
        return Err(Refusal::field("files", format!("at most {} are allowed", core.options.maxima.max_files)));
    }
    let mut found = BTreeMap::new();
    for (i, file) in files.iter().enumerate() {
        let field = format!("files[{i}]");
        check_file(&field, &file.path, &file.digest)?;
        if found.insert(file.path.clone(), file.digest.clone()).is_some() {
            return Err(Refusal::field(format!("{field}.path"), "is there twice"));
        }
    }
    Ok(found)
}

fn programs(core: &Core, programs: &[v1::Program], files: &BTreeMap<String, String>) -> Result<Vec<Program>, Refusal> {
    if programs.is_empty() || programs.len() > core.options.maxima.max_programs {
        let text = format!("must be 1 to {}", core.options.maxima.max_programs);
        return Err(Refusal::field("programs", text));
    }
    let one = |(i, program): (usize, &v1::Program)| {
        if !files.contains_key(&program.path) {
            return Err(Refusal::field(format!("programs[{i}].path"), "is not among the files of the job"));
        }
        let channel = program.channel.map(|c| small(&format!("programs[{i}].channel"), u64::from(c), 1, 9999));
        Ok(Program { file: program.path.clone(), number: program.number, channel: channel.transpose()? })
    };
    programs.iter().enumerate().map(one).collect()
}

fn small<T: TryFrom<u64>>(field: &str, value: u64, min: u64, max: u64) -> Result<T, Refusal> {
    let refuse = || Refusal::field(field, format!("must be {min} to {max}"));
    if !(min..=max).contains(&value) {
        return Err(refuse());
    }
    T::try_from(value).map_err(|_| refuse())
}

fn options(options: v1::JobOptions) -> Result<Options, Refusal> {
    let opskip = options.opskip.iter().map(|&level| small("options.opskip", u64::from(level), 0, 9));
    let ignore = options.ignore_waits.iter().map(|&c| small("options.ignore_waits", u64::from(c), 1, 9999));
    Ok(Options {
        opskip: opskip.collect::<Result<_, _>>()?,
        opstop: options.opstop,
        ignore_waits: ignore.collect::<Result<_, _>>()?,
        trace: options.trace,
        answers: options.answers.into_iter().map(answer).collect(),
        attended: options.attended,
        parameters: options.parameters,
        threads: small("options.threads", u64::from(options.threads), 0, 1024)?,
        limits: limits(options.limits.unwrap_or_default())?,
    })
}

/// An answer from the wire.
pub(super) fn answer(answer: v1::DialogAnswer) -> Answer {
    use v1::dialog_value::Value as Wire;
    let value = |value: v1::DialogValue| match value.value {
        Some(Wire::Flag(flag)) => Value::Flag(flag),
        Some(Wire::Number(number)) => Value::Number(number),
        Some(Wire::Text(text)) => Value::Text(text),
        None => Value::Text(String::new()),
    };
    Answer {
        dialog: answer.dialog,
        button: Some(answer.button).filter(|button| !button.is_empty()),
        values: answer.values.into_iter().map(|(name, v)| (name, value(v))).collect(),
    }
}

fn limits(asked: v1::JobLimits) -> Result<Limits, Refusal> {
    let default = Limits::default();
    let or = |value: u64, default: u64| if value == 0 { default } else { value };
    if asked.simulated_ns < 0 {
        return Err(Refusal::field("options.limits.simulated_ns", "must not be negative"));
    }
    let nesting = small("options.limits.nesting", u64::from(asked.nesting), 0, 1000)?;
    Ok(Limits {
        simulated_ns: if asked.simulated_ns == 0 { default.simulated_ns } else { asked.simulated_ns },
        blocks: or(asked.blocks, default.blocks),
        zero_time_blocks: or(asked.zero_time_blocks, default.zero_time_blocks),
        events: or(asked.events, default.events),
        block_length: match asked.block_length {
            0 => default.block_length,
            n => n as usize,
        },
        nesting: if nesting == 0 { default.nesting } else { nesting },
        diagnostics: if asked.diagnostics == 0 { default.diagnostics } else { asked.diagnostics },
        memory: or(asked.memory, default.memory),
        macro_steps: or(asked.macro_steps, default.macro_steps),
    }
    .capped())
}

/// The machine that a name means to a tenant, pinned to its revision.
pub(super) fn machine(core: &Core, tenant: &str, name: &str) -> Result<Definition, Refusal> {
    // A ledger written by an older server may hold a machine under the name of a shipped one.
    if core.reserved(name) {
        return Ok(Definition::shipped(name));
    }
    if let Some(definition) = core.ledger.machine(tenant, name)? {
        return Ok(definition);
    }
    if is_shipped(name) {
        return Ok(Definition::shipped(name));
    }
    Err(Refusal::UnknownMachine(name.to_owned()))
}

/// Digest of what a client submitted, request id left out.
fn content(
    machine: &str,
    programs: &[Program],
    files: &[(String, String)],
    options: &Options,
    own_limits: (u64, u64),
) -> String {
    #[derive(Serialize)]
    struct Content<'a> {
        machine: &'a str,
        programs: &'a [Program],
        files: &'a [(String, String)],
        options: &'a Options,
        #[serde(skip_serializing_if = "Option::is_none")]
        own_limits: Option<(u64, u64)>,
    }
    let own_limits = Some(own_limits).filter(|limits| *limits != (0, 0));
    let content = serde_json::to_vec(&Content { machine, programs, files, options, own_limits });
    digest(&content.unwrap_or_default())
}

/// Whether a path may be used inside a sandbox: relative, `/` between parts, no empty, `.` or `..` part, no
/// backslash, no colon (drive or stream on some systems), no control character, at most 255 bytes.
fn path_is_clean(path: &str) -> bool {
    !path.is_empty()
        && path.len() <= 255
        && !path.chars().any(|c| c == '\\' || c == ':' || c.is_control())
        && path.split('/').all(|part| !matches!(part, "" | "." | ".."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_relative_downward_paths_are_clean() {
        for path in ["O1000.nc", "sub/O9001", "a b/ü.tps"] {
            assert!(path_is_clean(path), "{path}");
        }
        for path in ["", "/etc/passwd", "../x", "a/../b", "a//b", "a/", "./a", "a\\b", "C:x", "a\nb"] {
            assert!(!path_is_clean(path), "{path}");
        }
    }
}
