//! The door of every call: ids, names, labels, paths and tokens of its request have a bounded length and permitted
//! characters before anything is looked up, logged or stored.
//!
//! *Invariant:* every call takes its request through [`enter`], and [`Bounded`] covers each text of the request. A
//! refusal names the field and its limit.

use std::collections::BTreeMap;

use counterpoint_kernel::event::letters::{ALL as LETTERS, Letters};
use counterpoint_proto::v1;
use tonic::{Request, Status};

use crate::access::Caller;
use crate::blobs::is_digest;
use crate::reason::Refusal;

/// Most labels of a job or a filter.
const LABELS: usize = 32;
/// Most characters of the parameters of a job.
const PARAMETERS: usize = 1000;
/// Most characters of the name of a section.
const SECTION: usize = 80;
/// Most bytes of a path.
const PATH: usize = 255;
/// Most bytes of the path of a file that macros have written.
const WRITTEN: usize = 4096;
/// Most values of the answer to a dialog.
const VALUES: usize = 1000;
/// Most bytes of a text of a dialog.
const TEXT: usize = 64 << 10;
/// Most bytes of all texts of the answer to a dialog.
const TEXTS: usize = 256 << 10;
/// Most answers to dialogs.
const ANSWERS: usize = 10_000;
/// Most states of a filter, levels of optional skip, and channels.
const STATES: usize = 16;
const LEVELS: usize = 16;
const CHANNELS: usize = 1000;
/// Maximum number of warnings that a job may switch off, and that it may switch on.
const WARNINGS: usize = 1000;
/// Most digests of a question.
const DIGESTS: usize = 10_000;
/// Most bytes of a chunk of an upload.
const UPLOAD: usize = 1 << 20;

/// A request whose texts have limits.
pub(super) trait Bounded {
    /// Refuses the first text beyond its limit.
    fn bounded(&self) -> Result<(), Refusal>;
}

/// The caller and the request of a call.
pub(super) fn enter<T: Bounded>(request: Request<T>) -> Result<(Caller, T), Status> {
    let (caller, request) = (Caller::of(&request)?, request.into_inner());
    request.bounded()?;
    Ok((caller, request))
}

fn check(good: bool, field: &str, rule: impl Into<String>) -> Result<(), Refusal> {
    if good { Ok(()) } else { Err(Refusal::field(field, rule)) }
}

/// Identity of a job; none is that of no job.
pub(super) fn id(field: &str, text: &str) -> Result<(), Refusal> {
    let allowed = text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-');
    check(text.len() <= 64 && allowed, field, "must be at most 64 characters of A-Z a-z 0-9 -")
}

/// Name of a machine, perhaps with its revision; none is fine.
fn machine(field: &str, text: &str) -> Result<(), Refusal> {
    let allowed = text.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-@".contains(&b));
    let (name, revision) = text.split_once('@').unwrap_or((text, ""));
    let rule = "must be at most 64 characters of A-Z a-z 0-9 . _ -, with a revision @ and 16 more";
    check(name.len() <= 64 && revision.len() <= 16 && allowed, field, rule)
}

/// Identity that a client gives to its request.
fn request_id(field: &str, text: &str) -> Result<(), Refusal> {
    let allowed = text.bytes().all(|b| b.is_ascii_alphanumeric() || b"._:-".contains(&b));
    check((1..=128).contains(&text.len()) && allowed, field, "must be 1 to 128 characters of A-Z a-z 0-9 . _ : -")
}

fn digest(field: &str, text: &str) -> Result<(), Refusal> {
    check(is_digest(text), field, "must be 64 lower-case hexadecimal digits")
}

/// A text of one line.
fn line(field: &str, text: &str, most: usize) -> Result<(), Refusal> {
    let good = text.chars().take(most + 1).count() <= most && !text.chars().any(char::is_control);
    check(good, field, format!("must have at most {most} characters and no control characters"))
}

/// A relative path that does not lead upwards.
fn path(field: &str, text: &str) -> Result<(), Refusal> {
    let rule = "must be a relative path of at most 255 bytes, with / between parts, without . and ..";
    check(text.len() <= PATH && path_is_clean(text), field, rule)
}

/// Whether a path is relative, leads downwards only, and means the same on every system.
fn path_is_clean(path: &str) -> bool {
    !path.chars().any(|c| c == '\\' || c == ':' || c.is_control())
        && path.split('/').all(|part| !matches!(part, "" | "." | ".."))
}

/// Labels, with a field for messages.
fn labels(field: &str, labels: &BTreeMap<String, String>) -> Result<(), Refusal> {
    entries(field, labels.len(), LABELS)?;
    for (key, value) in labels {
        let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b"._/-".contains(&b);
        let begins = key.starts_with(|c: char| c.is_ascii_lowercase() || c.is_ascii_digit());
        let good = (1..=63).contains(&key.len()) && key.bytes().all(allowed) && begins;
        let place = || format!("{field}[{key:?}]");
        let rule = "a key must have 1 to 63 characters of a-z 0-9 . _ / -, the first a letter or digit";
        check(good, &place(), rule)?;
        let good = value.len() <= 255 && !value.chars().any(char::is_control);
        check(good, &place(), "must have at most 255 bytes and no control characters")?;
    }
    Ok(())
}

/// Files of a machine or a job: path and digest.
fn files<'a>(files: impl Iterator<Item = (&'a str, &'a str)>) -> Result<(), Refusal> {
    for (at, (of_file, content)) in files.enumerate() {
        // The name of a field is made for a refusal only.
        path("", of_file).or_else(|_| path(&format!("files[{at}].path"), of_file))?;
        digest("", content).or_else(|_| digest(&format!("files[{at}].digest"), content))?;
    }
    Ok(())
}

/// A list with a limit.
fn list<T>(field: &str, list: &[T], most: usize) -> Result<(), Refusal> {
    entries(field, list.len(), most)
}

/// Checks the number of entries of a list that must not be empty and whose limit is an option of the server.
pub(super) fn some_entries(field: &str, count: usize, most: usize, option: &str) -> Result<(), Refusal> {
    let rule = || format!("must have 1 to {most} entries (option {option} of the server), has {count}");
    if (1..=most).contains(&count) { Ok(()) } else { Err(Refusal::field(field, rule())) }
}

/// The number of entries of a list or map.
pub(super) fn entries(field: &str, count: usize, most: usize) -> Result<(), Refusal> {
    check(count <= most, field, format!("must have at most {most} entries, has {count}"))
}

/// Letters of a trace.
fn trace(field: &str, text: &str) -> Result<(), Refusal> {
    line(field, text, PATH)?;
    let letters = Letters::parse(text).map(drop);
    letters.map_err(|letter| Refusal::field(field, format!("must be letters of {LETTERS}, or all; not {letter:?}")))
}

/// A chunk of an upload.
pub(super) fn chunk(data: &[u8]) -> Result<(), Refusal> {
    bytes(data, "send the content in smaller chunks")
}

/// Checks the content of a blob in one message.
fn content(data: &[u8]) -> Result<(), Refusal> {
    bytes(data, "send the content with Upload, in chunks")
}

fn bytes(data: &[u8], remedy: &str) -> Result<(), Refusal> {
    let rule = || format!("must have at most {UPLOAD} bytes in a message, has {}: {remedy}", data.len());
    if data.len() <= UPLOAD { Ok(()) } else { Err(Refusal::field("data", rule())) }
}

/// The place of a breakpoint.
pub(super) fn place(field: &str, text: &str, most: usize) -> Result<(), Refusal> {
    let good = text.len() <= most && !text.chars().any(char::is_control);
    check(good, field, format!("must have at most {most} bytes and no control characters"))
}

/// The answer to a dialog.
pub(super) fn answer(field: &str, answer: &v1::DialogAnswer) -> Result<(), Refusal> {
    line(&format!("{field}.dialog"), &answer.dialog, PATH)?;
    line(&format!("{field}.button"), &answer.button, PATH)?;
    let values = format!("{field}.values");
    entries(&values, answer.values.len(), VALUES)?;
    let length = |value: &v1::DialogValue| match &value.value {
        Some(v1::dialog_value::Value::Text(text)) => text.len(),
        _ => 0,
    };
    answer.values.iter().try_for_each(|(name, value)| {
        line(&values, name, PATH)?;
        let finite = !matches!(value.value, Some(v1::dialog_value::Value::Number(number)) if !number.is_finite());
        check(finite, &values, format!("the number of '{name}' must be finite"))?;
        let length = length(value);
        let rule = || format!("the text of '{name}' must have at most {TEXT} bytes; it has {length}");
        if length <= TEXT { Ok(()) } else { Err(Refusal::field(&values, rule())) }
    })?;
    let sum: usize = answer.values.values().map(length).sum();
    let rule = || format!("the texts of an answer must have at most {TEXTS} bytes together; they have {sum}");
    if sum <= TEXTS { Ok(()) } else { Err(Refusal::field(&values, rule())) }
}

fn filter(filter: Option<&v1::JobFilter>) -> Result<(), Refusal> {
    let Some(filter) = filter else { return Ok(()) };
    machine("filter.machine", &filter.machine)?;
    labels("filter.labels", &filter.labels)?;
    list("filter.states", &filter.states, STATES)?;
    line("filter.id_prefix", &filter.id_prefix, 64)
}

/// Rules of requests that consist of single fields.
macro_rules! bounded {
    ($($request:ident { $($field:ident: $rule:expr),* })*) => { $(
        impl Bounded for v1::$request {
            fn bounded(&self) -> Result<(), Refusal> {
                $( ($rule)(stringify!($field), self.$field.as_str())?; )*
                Ok(())
            }
        }
    )* };
}

fn token(field: &str, text: &str) -> Result<(), Refusal> {
    line(field, text, WRITTEN)
}

bounded! {
    GetJobRequest { job_id: id }
    WatchJobRequest { job_id: id }
    WaitJobRequest { job_id: id }
    CancelJobRequest { job_id: id }
    PauseJobRequest { job_id: id }
    ResumeJobRequest { job_id: id }
    DeleteJobRequest { job_id: id }
    GetListingRequest { job_id: id }
    GetTraceRequest { job_id: id }
    GetTimelineRequest { job_id: id }
    GetToolpathRequest { job_id: id }
    GetSummaryRequest { job_id: id }
    GetEventsRequest { job_id: id }
    ListFilesRequest { job_id: id, page_token: token }
    GetFileRequest { job_id: id, path: token }
    GetMachineRequest { name: machine }
    ListMachinesRequest { page_token: machine }
    ListConnectionsRequest { page_token: id }
    DeleteMachineRequest { name: machine }
    DownloadRequest { digest: digest }
    WatchQuestionsRequest { job_id: id }
}

impl Bounded for v1::PutBlobRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        content(&self.data)
    }
}

impl Bounded for v1::AnswerQuestionRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        id("job_id", &self.job_id)?;
        self.answer.as_ref().map_or(Ok(()), |given| answer("answer", given))
    }
}

impl Bounded for v1::FindMissingRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        list("digests", &self.digests, DIGESTS)?;
        let mut digests = self.digests.iter().enumerate();
        digests.try_for_each(|(at, text)| digest("", text).or_else(|_| digest(&format!("digests[{at}]"), text)))
    }
}

impl Bounded for v1::PutMachineRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        machine("name", &self.name)?;
        files(self.files.iter().map(|file| (file.path.as_str(), file.digest.as_str())))
    }
}

impl Bounded for v1::CheckMachineRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        machine("name", &self.name)?;
        files(self.files.iter().map(|file| (file.path.as_str(), file.digest.as_str())))
    }
}

impl Bounded for v1::ListJobsRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        line("page_token", &self.page_token, 64)?;
        list("states", &self.states, STATES)?;
        filter(self.filter.as_ref())
    }
}

impl Bounded for v1::WatchJobsRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        filter(self.filter.as_ref())
    }
}

impl Bounded for v1::CancelJobsRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        line("page_token", &self.page_token, 64)?;
        filter(self.filter.as_ref())
    }
}

impl Bounded for v1::DeleteJobsRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        line("page_token", &self.page_token, 64)?;
        filter(self.filter.as_ref())
    }
}

impl Bounded for v1::RerunJobRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        request_id("request_id", &self.request_id)?;
        id("job_id", &self.job_id)?;
        labels("labels", &self.labels)
    }
}

impl Bounded for v1::SubmitJobRequest {
    fn bounded(&self) -> Result<(), Refusal> {
        request_id("request_id", &self.request_id)?;
        machine("machine", &self.machine)?;
        labels("labels", &self.labels)?;
        files(self.files.iter().map(|file| (file.path.as_str(), file.digest.as_str())))?;
        for (at, program) in self.programs.iter().enumerate() {
            path(&format!("programs[{at}].path"), &program.path)?;
            if let Some(section) = &program.section {
                let field = format!("programs[{at}].section");
                check(!section.is_empty(), &field, format!("must have 1 to {SECTION} characters"))?;
                line(&field, section, SECTION)?;
            }
        }
        let Some(options) = &self.options else { return Ok(()) };
        trace("options.trace", &options.trace)?;
        list("options.opskip", &options.opskip, LEVELS)?;
        list("options.ignore_waits", &options.ignore_waits, CHANNELS)?;
        list("options.answers", &options.answers, ANSWERS)?;
        list("options.warnings_off", &options.warnings_off, WARNINGS)?;
        list("options.warnings_on", &options.warnings_on, WARNINGS)?;
        line("options.parameters", &options.parameters, PARAMETERS)?;
        let mut answers = options.answers.iter().enumerate();
        answers.try_for_each(|(at, of_dialog)| answer(&format!("options.answers[{at}]"), of_dialog))
    }
}

/// Refuses a text that is not the token of a page of jobs.
pub(super) fn page_token(text: &str) -> Result<(), Refusal> {
    match text.is_empty() || uuid::Uuid::try_parse(text).is_ok() {
        true => Ok(()),
        false => Err(Refusal::field("page_token", "is not a next_page_token of this call")),
    }
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
