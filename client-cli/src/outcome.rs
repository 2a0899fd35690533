//! How a job ended, as text and as exit code.

use counterpoint_proto::v1;

use crate::error::Error;
use crate::findings;
use crate::say;
use crate::severity::WARNING;
use crate::text::time;

/// Prints how a job ended and returns the exit code.
pub(crate) fn ended(status: &v1::JobStatus, strict: bool) -> u8 {
    if let Some(code) = not_run(status) {
        return code;
    }
    let state = status.state().as_str_name().trim_start_matches("JOB_STATE_");
    let succeeded = status.state() == v1::JobState::Succeeded;
    let warnings = if succeeded && status.highest_severity >= WARNING { ", with warnings" } else { "" };
    let label = if succeeded { "cycle time" } else { "after" };
    let text = format!("{state}{warnings}  {label} {}  {}", time(status.makespan_ns), status.verdict);
    say::status_line(text.trim_end());
    exit_code(status, strict)
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
