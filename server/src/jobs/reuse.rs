//! Copies the results of an equal job instead of running a job.
//!
//! Two jobs of a tenant are equal if they have the same machine files, programs, files, options and limits, on the same
//! version of the server. The later job gets a copy of the log and the files of the earlier job. If these cannot be
//! read, the later job runs.
//!
//! *Invariants:* a log is copied only if every run of the job gives the same log (see [`JobRecord::log_is_final`]) and the
//! log depends on nothing but the job. The copy has passed all checks of a reader.

use std::io::Read as _;
use std::sync::{Arc, LazyLock};

use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::options::JobOptions;
use prost::Message as _;
use serde::Serialize;

use super::Core;
use super::live::LiveJob;
use super::seal::{Change, RESULTS_FROM, seal};
use crate::blobs::digest;
use crate::ledger::record::{JobRecord, JobWork, Reuse};
use crate::log::damage::{cut_short, gone};
use crate::log::reader::LogReader;
use crate::log::wanted::ResultGate;
use crate::log::writer::{FinishedLog, Small, Writer};
use crate::machines::MachineRecord;
use crate::reason::Refusal;
use crate::results::StoredResult;

/// The version of the server and the digest of the sources that make results.
static VERSION: LazyLock<String> =
    LazyLock::new(|| format!("{} {}", env!("CARGO_PKG_VERSION"), env!("COUNTERPOINT_SOURCES")));

/// The inputs that determine the results of a job.
#[derive(Serialize)]
struct RunInputs<'a> {
    version: &'a str,
    machine: &'a MachineRecord,
    programs: &'a [ProgramSelection],
    files: &'a [(String, String)],
    options: JobOptions,
    wall_ms: u64,
    max_job_bytes: u64,
    /// Whether macros may start commands.
    system: bool,
    /// Whether the log and the toolpath are kept.
    kept: [bool; 2],
}

/// The digest of the inputs that determine the results of a job, including the limits of its run; `None` if the results
/// of this job are not shared.
pub(super) fn digest_of(
    core: &Core,
    record: &JobRecord,
    work: &JobWork,
    wall_ms: u64,
    max_job_bytes: u64,
) -> Option<String> {
    let embedded = core.options.embedded;
    if !core.options.retention.result_cache || embedded.ephemeral || record.attended || record.stepped {
        return None;
    }
    let content = RunInputs {
        version: &VERSION,
        machine: &work.machine,
        programs: &record.programs,
        files: &work.files,
        // The log is the same for any number of threads.
        options: JobOptions { threads: 0, ..work.options.clone() },
        wall_ms,
        max_job_bytes,
        system: core.options.system.allow_system && work.machine.trusted,
        kept: [embedded.log, embedded.toolpath],
    };
    serde_json::to_vec(&content).ok().map(|content| digest(&content))
}

/// An ended job with this digest whose results a job with this record may use.
fn equal(core: &Core, record: &JobRecord, digest: &str) -> Option<JobRecord> {
    if record.asked.no_cache || !record.asked.rerun_of.is_empty() {
        return None;
    }
    let found = core.ledger.equal(&record.tenant, digest);
    let found = found.inspect_err(|error| tracing::warn!(%error, "the equal job cannot be read; the job runs"));
    found.ok().flatten().filter(|found| found.log_is_final() && found.tenant == record.tenant)
}

/// Gives a job the results of an equal job; `None` if the job must run.
///
/// # Errors
/// The copy cannot be stored.
pub(super) fn take(
    core: &Arc<Core>,
    live: &LiveJob,
    record: &JobRecord,
    digest: &str,
) -> Result<Option<(Change, Option<Small>)>, Refusal> {
    let Some(from) = equal(core, record, digest) else { return Ok(None) };
    let Some((stored_bytes, log)) = copy(core, live, &from)? else {
        // Watchers of an abandoned copy keep their cursors.
        live.tail().begin_again();
        core.logs.remove(&live.id)?;
        return Ok(None);
    };
    core.metrics.jobs.reused.inc();
    Ok(Some((of_equal(from, stored_bytes, digest.to_owned()), log)))
}

/// The change to the record of a job that got the results of another job.
fn of_equal(from: JobRecord, stored_bytes: u64, digest: String) -> Change {
    Box::new(move |record| {
        record.state = from.state;
        (record.runs.cause, record.runs.has_files) = (from.runs.cause, from.runs.has_files);
        (record.events, record.makespan_ns) = (from.events, from.makespan_ns);
        (record.log_digest, record.verdict) = (from.log_digest, from.verdict);
        record.highest_severity = from.highest_severity;
        record.first_error = from.first_error;
        record.runs.stored_bytes = stored_bytes;
        record.reuse = match from.reuse.from.is_empty() {
            true => Reuse { digest, from: from.id, ended_ms: from.ended_ms },
            false => Reuse { digest, ..from.reuse },
        };
    })
}

/// The result of a read; `None`, with a warning, if the data of an ended job are damaged or removed.
fn unreadable<T>(read: Result<T, Refusal>, from: &JobRecord) -> Option<T> {
    read.inspect_err(|error| {
        tracing::warn!(%error, from = from.id, "the results of the equal job cannot be read; the job runs");
    })
    .ok()
}

/// Copies log, files and stored results of an ended job; returns their size in bytes and the log, if it is small.
/// `None` if they cannot be read, or if the job is stopped during the copy.
fn copy(core: &Arc<Core>, live: &LiveJob, from: &JobRecord) -> Result<Option<(u64, Option<Small>)>, Refusal> {
    let files = match from.runs.has_files {
        true => match unreadable(document(core, from, StoredResult::Files), from) {
            Some(files) => Some(files),
            None => return Ok(None),
        },
        false => None,
    };
    let Some(writer) = copy_log(core, live, from)? else { return Ok(None) };
    let bytes = writer.bytes();
    let (log, mut place) = match writer.finish()? {
        FinishedLog::Small(log) => (Some(log), None),
        FinishedLog::Placed(place) => (None, Some(place)),
    };
    let mut stored = place.as_mut().map_or(Ok(bytes), |place| place.pack())?;
    if let Some(files) = &files {
        core.logs.write(&live.id, StoredResult::Files.file(), files)?;
        stored += files.len() as u64;
    }
    if bytes >= RESULTS_FROM {
        // Missing results are made from the log on request.
        for name in StoredResult::ALL.into_iter().filter(|document| *document != StoredResult::Files) {
            let Ok(content) = document(core, from, name) else { continue };
            core.logs.write_spare(&live.id, name.file(), &content, &ResultGate::default())?;
            stored += content.len() as u64;
        }
    }
    seal(core, live, place, files.is_some())?;
    Ok(Some((stored, log)))
}

/// Copies the log of an ended job; `None` if it cannot be read, or if the job is stopped during the copy.
fn copy_log(core: &Core, live: &LiveJob, from: &JobRecord) -> Result<Option<Writer>, Refusal> {
    let open = || {
        let Some(kept) = core.kept_log(&from.id)? else { return Err(gone(&from.id).into()) };
        Ok(LogReader::open_ended(&kept, 0)?)
    };
    let Some(mut reader) = unreadable(open(), from) else { return Ok(None) };
    let head = reader.description().encode_to_vec();
    let mut writer = Writer::of_copy(&live.id, core.logs.begin(&live.id)?, live.tail().clone(), &head);
    let stop = live.stop();
    let mut last = 0;
    loop {
        let read = match reader.next_batch() {
            Ok(None) if last != from.events => Err(cut_short(&from.id, last, from.events)),
            other => other,
        };
        match unreadable(read.map_err(Refusal::from), from) {
            Some(Some(_)) if stop.asked_once_resumed() => return Ok(None),
            Some(Some(batch)) => {
                writer.copy(batch.first, batch.last, &batch.body)?;
                last = batch.last;
            }
            Some(None) => return Ok(Some(writer)),
            None => return Ok(None),
        }
    }
}

/// Reads a result that is stored beside a log.
fn document(core: &Core, from: &JobRecord, document: StoredResult) -> Result<Vec<u8>, Refusal> {
    let mut content = Vec::new();
    core.logs.open(&from.id, document.file())?.read_to_end(&mut content)?;
    Ok(content)
}
