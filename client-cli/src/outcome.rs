//! How a job ended, as text and as exit code.

use counterpoint_proto::v1;

use crate::error::Error;
use crate::findings;
use crate::job_status::{first_error, programs, simulated, simulated_label, state_name};
use crate::reused;
use crate::say;
use crate::severity::WARNING;

/// Prints how a job ended and returns the exit code.
pub(crate) fn ended(status: &v1::JobStatus, strict: bool) -> u8 {
    not_run(status).unwrap_or_else(|| {
        say::status_line(format!("{}  {}", end(status), status.verdict).trim_end());
        notes(status).iter().for_each(say::status_line);
        exit_code(status, strict)
    })
}

/// Same with the id and the programs of the job, for one of several jobs. `quiet`: only reasons why a job was not run.
pub(crate) fn ended_by_name(status: &v1::JobStatus, strict: bool, quiet: bool) -> u8 {
    if !quiet {
        let line = format!("{}  {}  {}  {}", status.job_id, end(status), programs(status), status.verdict);
        say::status_line(line.trim_end());
        notes(status).iter().for_each(say::status_line);
    }
    not_run(status).unwrap_or_else(|| exit_code(status, strict))
}

/// The state of an ended job with its simulated time.
fn end(status: &v1::JobStatus) -> String {
    let state = state_name(status);
    let succeeded = status.state() == v1::JobState::Succeeded;
    let warnings = if succeeded && status.highest_severity >= WARNING { ", with warnings" } else { "" };
    let time = simulated(status).map(|time| format!("  {} {time}", simulated_label(status)));
    format!("{state}{warnings}{}", time.unwrap_or_default())
}

/// Further lines about the end of a job: the source of its results, its first error, and the command that shows all
/// errors.
fn notes(status: &v1::JobStatus) -> Vec<String> {
    // `not_run` prints the reason why a job was not run.
    let ran = status.error.is_empty() && status.findings.is_empty();
    let first = first_error(status).filter(|_| ran).map(|error| format!("first error: {error}"));
    reused::note(status).into_iter().chain(first).chain(errors(status).map(|at| format!("errors: {at}"))).collect()
}

/// The command that shows the errors of a job, if its run failed and its status has no reason.
pub(crate) fn errors(status: &v1::JobStatus) -> Option<String> {
    let reason = !status.verdict.is_empty() || !status.error.is_empty() || !status.findings.is_empty();
    (status.state() == v1::JobState::Failed && !reason).then(|| format!("counterpoint result {} report", status.job_id))
}

/// Prints why a job could not be run and returns the exit code; `None` if it was run.
pub(crate) fn not_run(status: &v1::JobStatus) -> Option<u8> {
    if !status.findings.is_empty() {
        findings::print(&status.findings);
        return Some(2);
    }
    if !status.error.is_empty() {
        say::error(&Error::Usage(status.error.clone()));
        return Some(1);
    }
    None
}

/// Exit code of an ended job; `strict`: warnings count as errors.
pub(crate) fn exit_code(status: &v1::JobStatus, strict: bool) -> u8 {
    u8::from(status.state() != v1::JobState::Succeeded || strict && status.highest_severity >= WARNING)
}
