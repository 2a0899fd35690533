//! Exit codes of `run --exit-code severity`: those of the emulated system.
//!
//! Facts: reference listing-and-trace.md 10. Decisions: a verdict or a cancelled job counts as fatal (16); a job that
//! the kernel refuses to start is 200 if its programs are the cause, otherwise 100; a file of answers counts as a job
//! file (105); a failure that the job did not cause is unexpected: 255 instead of -1.

use counterpoint_proto::v1;
use tonic::Code;

use crate::error::Error;

/// Severity of an end that has no diagnostic.
const FATAL: u32 = 16;

/// The stage at which a run failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FailureStage {
    /// Reading the programs.
    Programs,
    /// Looking for the machine.
    Machine,
    /// Submitting and running the job.
    Submission,
    /// Writing results.
    Results,
}

/// Exit code of a run that failed.
pub(crate) fn of_error(stage: FailureStage, error: &Error) -> u8 {
    match (stage, error) {
        (_, Error::Closed) => 0,
        (_, Error::Connection(_)) => 255,
        (FailureStage::Programs, _) => 200,
        (FailureStage::Machine, _) => 201,
        (FailureStage::Results, _) => 106,
        (FailureStage::Submission, Error::File { .. }) => 105,
        (FailureStage::Submission, Error::Refused(status)) => match status.code() {
            Code::NotFound => 201,
            Code::InvalidArgument | Code::FailedPrecondition | Code::AlreadyExists => 100,
            _ => 255,
        },
        (FailureStage::Submission, Error::Usage(_)) => 100,
        (FailureStage::Submission, Error::NotWritten(_)) => 106,
    }
}

/// Exit code of an invalid command line, if it asks for severity codes.
pub(crate) fn of_command_line() -> Option<u8> {
    let words: Vec<String> = std::env::args().collect();
    let asked =
        words.windows(2).any(|pair| matches!(pair, [key, value] if key == "--exit-code" && value == "severity"));
    (asked || words.iter().any(|word| word == "--exit-code=severity")).then_some(100)
}

/// Exit code of a job that has ended.
pub(crate) fn of_job(status: &v1::JobStatus) -> u8 {
    if let Some(finding) = status.findings.iter().find(|finding| finding.error) {
        return if finding.file == "job" { 100 } else { 200 };
    }
    if !status.error.is_empty() {
        return 255;
    }
    let succeeded = status.state() == v1::JobState::Succeeded;
    let highest = status.highest_severity;
    let severity = if succeeded || highest >= 8 && status.verdict.is_empty() { highest } else { highest.max(FATAL) };
    u8::try_from(severity.min(99)).unwrap_or(99)
}
