//! Why a call is refused: one variant per stable reason code of docs/api.md.
//!
//! Invariant: every status that leaves the server carries an `ErrorInfo` with one of these reasons and the domain
//! `counterpoint`; a reason never changes its meaning or its gRPC code.

use std::borrow::Cow;
use std::collections::HashMap;
use std::time::Duration;

use tonic::{Code, Status};
use tonic_types::{ErrorDetails, StatusExt};

/// Domain of all reasons.
pub const DOMAIN: &str = "counterpoint";

/// A refused call.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// A field of the request is wrong.
    #[error("{field}: {text}")]
    InvalidField {
        /// Path of the field in the request.
        field: String,
        /// The error and the expected input.
        text: String,
    },
    /// The request id was used for another content.
    #[error("request_id '{0}' was used for a job with other content")]
    RequestIdReused(String),
    /// No such job.
    #[error("no job '{0}'")]
    UnknownJob(String),
    /// No such machine.
    #[error("no machine '{name}'; {}`counterpoint machine list` lists the machines", meant(.near))]
    UnknownMachine {
        /// The requested name.
        name: String,
        /// Machines that were probably meant.
        near: Vec<String>,
    },
    /// No such channel in the job.
    #[error("the job has no channel {0}")]
    UnknownChannel(u32),
    /// Macros have written no such file.
    #[error("the macros of the job have written no file '{0}'")]
    UnknownFile(String),
    /// No such blob.
    #[error("no blob {0}")]
    UnknownBlob(String),
    /// Blobs must be uploaded first.
    #[error("{} blobs are missing, the first is {}", .0.len(), .0.first().map_or("", String::as_str))]
    MissingBlobs(Vec<String>),
    /// Files of a job that is to run again are lost: path and digest of each.
    #[error("the server no longer has {}: submit the programs again", names(.0))]
    LostFiles(Vec<(String, String)>),
    /// The content does not have the digest it was announced with.
    #[error("the content has digest {actual}, announced was {announced}")]
    DigestMismatch {
        /// The digest that the client announced.
        announced: String,
        /// The digest of the content.
        actual: String,
    },
    /// A blob is larger than allowed.
    #[error("the blob is larger than the limit of {0} bytes (max_blob_bytes)")]
    BlobTooLarge(u64),
    /// The machine definition has errors.
    #[error("the machine cannot be used: {}", .0.first().map_or("", |v| v.1.as_str()))]
    MachineInvalid(Vec<(String, String)>),
    /// The job has not ended.
    #[error("job '{0}' has not ended")]
    JobNotEnded(String),
    /// The job was submitted without an operator.
    #[error("job '{0}' was submitted without options.attended, its dialogs are not put to an operator")]
    NotAttended(String),
    /// The job was submitted to run by itself.
    #[error("job '{0}' was submitted without options.stepped, it runs by itself")]
    NotStepped(String),
    /// Another client steps through the job.
    #[error("another client steps through job '{0}'")]
    SteppedAlready(String),
    /// The job has no log: it could not be run, or was cancelled while it waited.
    #[error("job '{0}' has no results: it ended without a finished run")]
    NoResults(String),
    /// The cursor lies behind the end of the log.
    #[error("the log ends at {last}, the cursor is {after}")]
    CursorBeyondLog {
        /// Cursor of the client.
        after: u64,
        /// Last event.
        last: u64,
    },
    /// The cursor of a watch of many jobs is older than the server's memory of changes.
    #[error(
        "changes after the cursor {after} are forgotten; the oldest cursor is {oldest}: watch without a cursor, wait \
         for the first message, and then list the jobs"
    )]
    CursorTooOld {
        /// Cursor of the client.
        after: u64,
        /// The oldest that can be continued from.
        oldest: u64,
    },
    /// A tenant has reached a quota.
    #[error("the tenant '{tenant}' has reached its quota {quota} of {limit}: {text}")]
    Quota {
        /// The tenant.
        tenant: String,
        /// Option that sets the quota.
        quota: &'static str,
        /// How much that allows.
        limit: u64,
        /// Its use, and the remedy.
        text: String,
    },
    /// The admission queue is full.
    #[error("the queue is full ({0} jobs, option queue): submit again later")]
    QueueFull(usize),
    /// The memory budget of the server does not have room for the request.
    #[error("the server has no memory for the request within its budget of {0} bytes (memory_bytes)")]
    MemoryFull(u64),
    /// The request is larger than the whole memory budget of the server.
    #[error(
        "the request needs {bytes} bytes of memory, more than the {budget} that such requests may have on this server: \
         make the request smaller, or ask the administrator to raise memory_bytes"
    )]
    BeyondMemory {
        /// Bytes of the request.
        bytes: u64,
        /// The part of the budget that it could have.
        budget: u64,
    },
    /// The server is going down; `cursor` is where a watch may continue.
    #[error("the server is shutting down")]
    Draining {
        /// Last sequence number sent on the stream.
        cursor: u64,
    },
    /// The disk or another part of the host failed; the same request may succeed later.
    #[error("storage failed: {0}")]
    Storage(String),
    /// The disk has too little free space for new work.
    #[error("the server has less than {0} bytes of free disk space (min_free_bytes)")]
    DiskFull(u64),
    /// Stored content is damaged or gone.
    #[error("{0}")]
    DataLoss(String),
    /// Too many uploads are in progress.
    #[error("too many uploads are under way (max_uploads, max_uploads_per_connection)")]
    TooManyUploads,
    /// Too many watches of the health service are open.
    #[error("too many health watches are open, in total or from this address: end others, or call Check instead")]
    TooManyHealthWatches,
    /// The answer does not fit into a message.
    #[error("the answer has {0} bytes, more than a message may have: {1}")]
    AnswerTooLarge(usize, &'static str),
    /// The request of a call makes no progress.
    #[error("nothing of the request came for {0} s (upload_stall_s)")]
    CallStalled(u64),
    /// An upload makes no progress.
    #[error("no chunk of the upload came for {0} s (upload_stall_s)")]
    UploadStalled(u64),
    /// The files of a machine have too many bytes.
    #[error("the files of the machine have more than {0} bytes (max_machine_bytes)")]
    MachineTooLarge(u64),
    /// The name belongs to a machine that is shipped with the server.
    #[error("'{0}' is the name of a machine shipped with the server; choose another name")]
    MachineShipped(String),
    /// The caller is not known.
    #[error("{0}")]
    Unauthenticated(String),
    /// The caller may not do this.
    #[error("{0}")]
    PermissionDenied(String),
    /// A message is larger than the server takes.
    #[error("{0}")]
    MessageTooLarge(String),
    /// A message is not one of the contract.
    #[error("{0}")]
    MalformedMessage(String),
    /// There is no such call, or it cannot be made in this way.
    #[error("{0}")]
    UnknownCall(String),
    /// The deadline that the client gave to the call is over.
    #[error("the deadline of the call is over")]
    CallDeadline,
    /// The server has no such service.
    #[error("{0}")]
    UnknownService(String),
    /// The server has failed.
    #[error("{0}")]
    Internal(String),
    /// Too many calls of one identity; when the next may come.
    #[error("too many calls a second (max_calls_per_s)")]
    RateLimited(Duration),
    /// Too many calls without a known identity from one address; when the next is answered.
    #[error("too many calls without a known identity (max_refused_per_s)")]
    RefusedTooOften(Duration),
}

/// Introduces similar names, before more text. There is no question mark, because some clients do not decode it.
fn meant(near: &[String]) -> String {
    if near.is_empty() { String::new() } else { format!("similar names: '{}'; ", near.join("', '")) }
}

impl Refusal {
    /// A wrong field.
    pub(crate) fn field(field: impl Into<String>, text: impl Into<String>) -> Self {
        Self::InvalidField { field: field.into(), text: text.into() }
    }

    /// The ledger accepts no change until its disk can be written again.
    pub(crate) fn unwritable_ledger() -> Self {
        Self::Storage("the ledger cannot be written at the moment".to_owned())
    }

    /// Adds the job to the text of lost data, unless the text has it.
    pub(crate) fn of_job(self, id: &str) -> Self {
        match self {
            Self::DataLoss(text) if !text.contains(id) => Self::DataLoss(format!("job '{id}': {text}")),
            other => other,
        }
    }

    /// A quota that is reached.
    pub(crate) fn quota(tenant: &str, quota: &'static str, limit: u64, text: String) -> Self {
        Self::Quota { tenant: tenant.to_owned(), quota, limit, text }
    }

    /// Refusal for a status without details, which the transport has made.
    pub(crate) fn of_transport(status: &Status) -> Self {
        let text = status.message().to_owned();
        match status.code() {
            Code::OutOfRange | Code::ResourceExhausted
                if text.contains("message length too large") || text.contains("exceeded while decompressing") =>
            {
                Self::MessageTooLarge(text)
            }
            Code::Unimplemented => {
                Self::UnknownCall(if text.is_empty() { "there is no such call".into() } else { text })
            }
            Code::DeadlineExceeded => Self::CallDeadline,
            Code::NotFound => Self::UnknownService(text),
            Code::Internal | Code::InvalidArgument => Self::MalformedMessage(text),
            _ => Self::Internal(text),
        }
    }

    /// Stable reason and gRPC code.
    #[must_use]
    pub fn reason(&self) -> (&'static str, Code) {
        match self {
            Self::InvalidField { .. } => ("INVALID_REQUEST", Code::InvalidArgument),
            Self::RequestIdReused(_) => ("REQUEST_ID_REUSED", Code::AlreadyExists),
            Self::UnknownJob(_) => ("UNKNOWN_JOB", Code::NotFound),
            Self::UnknownMachine { .. } => ("UNKNOWN_MACHINE", Code::NotFound),
            Self::UnknownChannel(_) => ("UNKNOWN_CHANNEL", Code::NotFound),
            Self::UnknownFile(_) => ("UNKNOWN_FILE", Code::NotFound),
            Self::UnknownBlob(_) => ("UNKNOWN_BLOB", Code::NotFound),
            Self::MissingBlobs(_) | Self::LostFiles(_) => ("MISSING_BLOBS", Code::FailedPrecondition),
            Self::DigestMismatch { .. } => ("DIGEST_MISMATCH", Code::InvalidArgument),
            Self::BlobTooLarge(_) => ("BLOB_TOO_LARGE", Code::InvalidArgument),
            Self::MachineInvalid(_) => ("MACHINE_INVALID", Code::InvalidArgument),
            Self::JobNotEnded(_) => ("JOB_NOT_ENDED", Code::FailedPrecondition),
            Self::NotAttended(_) => ("NOT_ATTENDED", Code::FailedPrecondition),
            Self::NotStepped(_) => ("NOT_STEPPED", Code::FailedPrecondition),
            Self::SteppedAlready(_) => ("STEPPED_ALREADY", Code::FailedPrecondition),
            Self::NoResults(_) => ("NO_RESULTS", Code::FailedPrecondition),
            Self::CursorBeyondLog { .. } => ("CURSOR_BEYOND_LOG", Code::OutOfRange),
            Self::CursorTooOld { .. } => ("CURSOR_TOO_OLD", Code::OutOfRange),
            Self::Quota { .. } => ("QUOTA_EXCEEDED", Code::ResourceExhausted),
            Self::QueueFull(_) => ("QUEUE_FULL", Code::ResourceExhausted),
            Self::MemoryFull(_) => ("MEMORY_FULL", Code::ResourceExhausted),
            Self::BeyondMemory { .. } => ("BEYOND_MEMORY", Code::FailedPrecondition),
            Self::Draining { .. } => ("DRAINING", Code::Unavailable),
            Self::Storage(_) => ("STORAGE", Code::Unavailable),
            Self::DiskFull(_) => ("DISK_FULL", Code::ResourceExhausted),
            Self::DataLoss(_) => ("DATA_LOSS", Code::DataLoss),
            Self::TooManyHealthWatches => ("TOO_MANY_HEALTH_WATCHES", Code::ResourceExhausted),
            Self::AnswerTooLarge(..) => ("ANSWER_TOO_LARGE", Code::ResourceExhausted),
            Self::TooManyUploads => ("TOO_MANY_UPLOADS", Code::ResourceExhausted),
            Self::CallStalled(_) => ("CALL_STALLED", Code::DeadlineExceeded),
            Self::UploadStalled(_) => ("UPLOAD_STALLED", Code::DeadlineExceeded),
            Self::MachineTooLarge(_) => ("MACHINE_TOO_LARGE", Code::InvalidArgument),
            Self::MachineShipped(_) => ("MACHINE_SHIPPED", Code::AlreadyExists),
            Self::Unauthenticated(_) => ("UNAUTHENTICATED", Code::Unauthenticated),
            Self::PermissionDenied(_) => ("PERMISSION_DENIED", Code::PermissionDenied),
            Self::RateLimited(_) | Self::RefusedTooOften(_) => ("RATE_LIMITED", Code::ResourceExhausted),
            Self::MessageTooLarge(_) => ("MESSAGE_TOO_LARGE", Code::ResourceExhausted),
            Self::MalformedMessage(_) => ("MALFORMED_MESSAGE", Code::InvalidArgument),
            Self::UnknownCall(_) => ("UNKNOWN_CALL", Code::Unimplemented),
            Self::CallDeadline => ("CALL_DEADLINE", Code::DeadlineExceeded),
            Self::UnknownService(_) => ("UNKNOWN_SERVICE", Code::NotFound),
            Self::Internal(_) => ("INTERNAL", Code::Internal),
        }
    }

    fn metadata(&self) -> HashMap<String, String> {
        let pair = |key: &str, value: String| HashMap::from([(key.to_owned(), value)]);
        match self {
            Self::Draining { cursor } => pair("cursor", cursor.to_string()),
            Self::CursorBeyondLog { last, .. } => pair("last_seq", last.to_string()),
            Self::CursorTooOld { oldest, .. } => pair("oldest", oldest.to_string()),
            Self::Quota { quota, limit, .. } => {
                HashMap::from([("quota".to_owned(), (*quota).to_owned()), ("limit".to_owned(), limit.to_string())])
            }
            Self::MissingBlobs(digests) => pair("digests", list(digests.iter())),
            Self::LostFiles(files) => pair("digests", list(files.iter().map(|(_, digest)| digest))),
            _ => HashMap::new(),
        }
    }
}

/// The first digests of a list.
fn list<'d>(digests: impl Iterator<Item = &'d String>) -> String {
    digests.take(16).map(String::as_str).collect::<Vec<_>>().join(",")
}

/// The first files of a list, in quotes, and the number of the others.
fn names(files: &[(String, String)]) -> String {
    const NAMED: usize = 5;
    let named: Vec<String> = files.iter().take(NAMED).map(|(path, _)| format!("'{path}'")).collect();
    match files.len().saturating_sub(NAMED) {
        0 => named.join(", "),
        more => format!("{} and {more} more files of the job", named.join(", ")),
    }
}

/// Most bytes of a text in a status, which travels in the headers of an answer.
const TEXT: usize = 1000;
/// Most bytes of a place and of its text, where there may be 20 of them.
const PLACE: usize = 200;

/// A text with its end left out if it is long: ids and names in it come from the client.
fn short(text: &str, most: usize) -> String {
    match text.get(..text.floor_char_boundary(most)) {
        Some(begin) if begin.len() < text.len() => format!("{begin}…"),
        _ => text.to_owned(),
    }
}

/// A text of the host without the paths in it: they are the server's, as those of clients are relative.
pub(crate) fn without_paths(text: &str) -> Cow<'_, str> {
    let begins = |text: &str| {
        let mut bytes = text.bytes();
        let first = bytes.next();
        let drive = first.is_some_and(|b| b.is_ascii_alphabetic()) && text.get(1..3) == Some(":\\");
        drive || first == Some(b'/') && bytes.next().is_some_and(|b| b != b'/' && !b.is_ascii_whitespace())
    };
    let (mut out, mut rest, mut before) = (String::new(), text, ' ');
    while let Some(next) = rest.chars().next() {
        if !before.is_alphanumeric() && !matches!(before, '/' | '.' | '_' | '-') && begins(rest) {
            // One in quotes ends with them, another at a space.
            let quoted = matches!(before, '\'' | '"' | '`');
            let end = rest.find(|c: char| if quoted { c == before } else { c.is_whitespace() || c == ',' });
            out.push('…');
            (rest, before) = (rest.get(end.unwrap_or(rest.len())..).unwrap_or_default(), '…');
            continue;
        }
        out.push(next);
        (rest, before) = (rest.get(next.len_utf8()..).unwrap_or_default(), next);
    }
    if out == text { Cow::Borrowed(text) } else { Cow::Owned(out) }
}

impl From<Refusal> for Status {
    fn from(refusal: Refusal) -> Self {
        let (reason, code) = refusal.reason();
        let mut details = ErrorDetails::new();
        details.set_error_info(reason, DOMAIN, refusal.metadata());
        match &refusal {
            Refusal::InvalidField { field, text } => {
                details.add_bad_request_violation(short(field, TEXT), short(text, TEXT));
            }
            Refusal::Quota { tenant, quota, limit, text } => {
                let text = format!("the quota {quota} is {limit}: {text}");
                details.add_quota_failure_violation(format!("tenant:{tenant}"), text);
            }
            Refusal::MachineInvalid(violations) => {
                for (place, text) in violations.iter().take(20) {
                    details.add_bad_request_violation(short(place, PLACE), short(text, PLACE));
                }
            }
            Refusal::QueueFull(_)
            | Refusal::MemoryFull(_)
            | Refusal::Draining { .. }
            | Refusal::Storage(_)
            | Refusal::TooManyUploads => {
                details.set_retry_info(Some(Duration::from_secs(1)));
            }
            Refusal::RateLimited(wait) | Refusal::RefusedTooOften(wait) => {
                details.set_retry_info(Some(*wait));
            }
            Refusal::DiskFull(_) => {
                details.set_retry_info(Some(Duration::from_secs(10)));
            }
            _ => {}
        }
        let text = refusal.to_string();
        let text = match refusal {
            Refusal::Storage(_) | Refusal::DataLoss(_) | Refusal::Internal(_) => without_paths(&text),
            _ => Cow::Borrowed(text.as_str()),
        };
        Status::with_error_details(code, short(&text, TEXT), details)
    }
}

impl From<std::io::Error> for Refusal {
    fn from(error: std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::InvalidData => Self::DataLoss(error.to_string()),
            _ => Self::Storage(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_fits_into_headers_whatever_the_client_has_sent() {
        let long = "ü".repeat(1 << 20);
        for refusal in [
            Refusal::UnknownJob(long.clone()),
            Refusal::UnknownMachine { name: long.clone(), near: vec![long.clone()] },
            Refusal::field(format!("labels[{long}]"), &long),
            Refusal::MachineInvalid(vec![(long.clone(), long.clone()); 30]),
        ] {
            let status = Status::from(refusal);
            assert!(status.message().len() < 1100, "{}", status.message().len());
            assert!(status.details().len() < 12_000, "{}", status.details().len());
            assert!(status.get_error_details().error_info().is_some());
        }
        assert_eq!(Status::from(Refusal::UnknownJob("ü".into())).message(), "no job 'ü'");
    }

    #[test]
    fn a_text_of_the_host_shows_no_path() {
        for (text, shown) in [
            ("No space left on device (os error 28) at path \"/srv/jobs/.part\"", "… at path \"…\""),
            ("'/var/lib/my data/ledger.redb' is empty", "'…' is empty"),
            ("/var/lib/cp: denied, /etc", "… denied, …"),
            ("open C:\\data\\x failed", "open … failed"),
            ("storage failed: (/data)", "storage failed: (…"),
        ] {
            let expected = shown.replace("… at path", "No space left on device (os error 28) at path");
            assert_eq!(without_paths(text), expected);
        }
        for text in ["2/3 of a/b, 1 / 2", "//ICAMFS/x", "", "/", "ü/ä", "the row 't/id' of the ledger", "a:\\"] {
            assert_eq!(without_paths(text), if text == "a:\\" { "…" } else { text });
        }
        let status = Status::from(Refusal::Storage("failed at '/secret/place'".into()));
        assert_eq!(status.message(), "storage failed: failed at '…'");
    }

    #[test]
    fn a_status_carries_reason_domain_and_details() {
        let status = Status::from(Refusal::QueueFull(3));
        assert_eq!(status.code(), Code::ResourceExhausted);
        let details = status.get_error_details();
        let info = details.error_info().unwrap();
        assert_eq!((info.reason.as_str(), info.domain.as_str()), ("QUEUE_FULL", DOMAIN));
        assert!(details.retry_info().is_some());
        let status = Status::from(Refusal::field("programs[0].path", "is absolute"));
        assert_eq!(status.get_error_details().bad_request().unwrap().field_violations[0].field, "programs[0].path");
    }
}
