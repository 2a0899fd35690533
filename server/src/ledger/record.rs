//! A job as the ledger keeps it: its [`JobRecord`], which a status needs and which stays in memory while the job has not
//! ended, and its [`JobWork`], which only a run needs.
//!
//! Invariants: the memory of a waiting job does not depend on its `JobWork`, unless the work is small. States only go
//! forward (QUEUED → RUNNING → one of the three ends), except after a crash or a shutdown during a run:
//! RUNNING → QUEUED.

use std::collections::BTreeMap;

use counterpoint_kernel::control::Limit;
use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::options::{JobLimits, JobOptions};
use serde::{Deserialize, Serialize};

pub(crate) use super::work::JobWork;
use super::{crashes::Crashes, first_error::FirstError};
use crate::clock::Clock;
pub(crate) use crate::clock::now_ms;
use crate::machines::Pinned;
use crate::tenant;

/// State of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum JobState {
    /// Accepted.
    Queued,
    /// A worker runs it.
    Running,
    /// Ended without error and verdict.
    Succeeded,
    /// Ended with an error or verdict, or could not be run.
    Failed,
    /// Stopped on request.
    Cancelled,
}

impl JobState {
    /// Whether nothing more will happen.
    #[must_use]
    pub fn ended(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

/// How urgent a job is among those of its tenant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Priority {
    /// Before the others.
    High,
    /// As usual.
    #[default]
    Normal,
    /// After the others.
    Low,
}

impl Priority {
    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::High => "high",
            Self::Normal => "normal",
            Self::Low => "low",
        }
    }
}

/// The cause of the failure of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Cause {
    /// Its programs.
    Program,
    /// Its machine.
    Machine,
    /// A limit, or its deadline.
    Limit,
    /// The server or its host.
    Host,
}

/// A limit that stopped a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReachedLimit {
    /// Time of the run by the clock.
    WallMs,
    /// Bytes of log and files.
    MaxJobBytes,
    /// The deadline of the job.
    Deadline,
    /// Simulated time.
    SimulatedNs,
    /// Blocks of a channel.
    Blocks,
    /// Consecutive blocks that take no time.
    ZeroTimeBlocks,
    /// Events of a channel.
    Events,
    /// Memory.
    Memory,
    /// Steps of macros.
    MacroSteps,
}

impl ReachedLimit {
    /// Its name, that of the option of the job.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::WallMs => "wall_ms",
            Self::MaxJobBytes => "max_job_bytes",
            Self::Deadline => "deadline",
            Self::SimulatedNs => "simulated_ns",
            Self::Blocks => "blocks",
            Self::ZeroTimeBlocks => "zero_time_blocks",
            Self::Events => "events",
            Self::Memory => "memory",
            Self::MacroSteps => "macro_steps",
        }
    }
}

impl From<Limit> for ReachedLimit {
    fn from(limit: Limit) -> Self {
        match limit {
            Limit::SimulatedTime => Self::SimulatedNs,
            Limit::Blocks => Self::Blocks,
            Limit::ZeroTimeBlocks => Self::ZeroTimeBlocks,
            Limit::Events => Self::Events,
            Limit::Memory => Self::Memory,
            Limit::MacroSteps => Self::MacroSteps,
        }
    }
}

/// A reason why a job could not be run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reason {
    /// `true` = cannot be used.
    pub error: bool,
    /// File.
    pub file: String,
    /// Line from 1, 0 = none.
    pub line: u32,
    /// Column from 1, 0 = unknown.
    pub column: u32,
    /// The error.
    pub text: String,
}

impl From<Finding> for Reason {
    fn from(f: Finding) -> Self {
        Self { error: f.error, file: f.file, line: f.line, column: f.column, text: f.text }
    }
}

/// The runs of a job: their limits and their results.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Runs {
    /// Runs begun.
    pub attempt: u32,
    /// Start of the last run, milliseconds since 1970; 0 = no run has started, or the last run was discarded.
    pub started_ms: i64,
    /// Server crashes during the runs of the job.
    #[serde(flatten)]
    pub crashes: Crashes,
    /// It was running when the server died, and has not ended since: at first it runs alone.
    pub suspect: bool,
    /// Runs that the host failed (disk, descriptors, memory of the system); none of them is an attempt.
    pub host_failures: u32,
    /// The cause of the last failure; empty = none.
    pub host_failure: String,
    /// Longest run by the clock that was requested, ms; 0 = the server's.
    pub wall_ms: u64,
    /// Most bytes of log and files that were requested; 0 = the server's.
    pub max_job_bytes: u64,
    /// Effect of a limit of the server or of the deadline, as a text; empty = neither stopped the job.
    pub limit: String,
    /// Its macros have written files.
    pub has_files: bool,
    /// Bytes of its log, files and results.
    pub stored_bytes: u64,
    /// Processor time of its runs, µs.
    pub cpu_us: u64,
    /// The limit that stopped the job.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reached: Option<ReachedLimit>,
    /// The cause of the failure of the job.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cause: Option<Cause>,
    /// The W3C `traceparent` that its submit came with; empty = none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub traceparent: String,
}

impl Runs {
    /// Discards the last run: it does not count, and the job waits as if the run had not started.
    pub(crate) fn drop_last(&mut self) {
        self.attempt = self.attempt.saturating_sub(1);
        self.started_ms = 0;
    }
}

/// Request of a client besides programs and options.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct JobAttributes {
    /// Labels to find the job by.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// How urgent it is.
    pub priority: Priority,
    /// When it is stopped, milliseconds since 1970; 0 = never.
    pub deadline_ms: i64,
    /// The job that it runs again; empty = none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub rerun_of: String,
    /// The signs by which its machine was guessed; empty = the client named it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub guess: String,
    /// The job runs even if the results of an equal job exist.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub no_cache: bool,
    /// Limits of the kernel that were requested, 0 = none; absent = none at all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<JobLimits>,
}

/// Whether a time has never been stored.
fn unknown(ms: &i64) -> bool {
    *ms == 0
}

/// Results shared with equal jobs.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Reuse {
    /// Digest of the inputs that determine the results, once equal jobs may use the results; empty = they may not.
    #[serde(rename = "result_digest", skip_serializing_if = "String::is_empty")]
    pub digest: String,
    /// The job whose run made the results; empty = this job has run itself.
    #[serde(rename = "reused_from", skip_serializing_if = "String::is_empty")]
    pub from: String,
    /// Time at which the reused run ended, ms since 1970; 0 = the job has a run of its own, or the time is unknown.
    #[serde(rename = "reused_ended_ms", skip_serializing_if = "unknown")]
    pub ended_ms: i64,
}

/// Start of the digest of a content that covers only the client's request. Earlier digests also covered defaults of the
/// server.
pub(crate) const CONTENT: &str = "2:";

/// A job without its `JobWork`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JobRecord {
    /// Identity, ascending in order of submission.
    pub id: String,
    /// Tenant that it belongs to.
    #[serde(default = "tenant::default", skip_serializing_if = "tenant::is_default")]
    pub tenant: String,
    /// Identity given by the client.
    pub request_id: String,
    /// Digest of the submitted content, without the request id, after `CONTENT`.
    #[serde(default)]
    pub content: String,
    /// Machine as the client named it.
    pub machine_name: String,
    /// The machine, pinned.
    pub machine: Pinned,
    /// Programs, left to right.
    pub programs: Vec<ProgramSelection>,
    /// Its options say that an operator answers its dialogs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub attended: bool,
    /// Its options say that an operator steps through it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stepped: bool,
    /// Further requests.
    #[serde(flatten)]
    pub asked: JobAttributes,
    /// Results shared with equal jobs.
    #[serde(flatten)]
    pub reuse: Reuse,
    /// State.
    pub state: JobState,
    /// Its runs.
    #[serde(flatten)]
    pub runs: Runs,
    /// A cancel was accepted.
    #[serde(default)]
    pub cancel: bool,
    /// It is held back: no run begins.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub paused: bool,
    /// Milliseconds since 1970.
    #[serde(default)]
    pub submitted_ms: i64,
    /// Likewise; 0 = not ended.
    #[serde(default)]
    pub ended_ms: i64,
    /// Time of its end by which it ages: by the clock that never goes back; 0 = `ended_ms`.
    #[serde(default)]
    pub aging_ms: i64,
    /// Events in the log.
    #[serde(default)]
    pub events: u64,
    /// Simulated time, ns.
    #[serde(default)]
    pub makespan_ns: i64,
    /// Highest severity.
    #[serde(default)]
    pub highest_severity: u8,
    /// Text of the verdict, empty = none.
    #[serde(default)]
    pub verdict: String,
    /// Why it could not be run or kept.
    #[serde(default)]
    pub error: String,
    /// Reasons with places.
    #[serde(default)]
    pub findings: Vec<Reason>,
    /// Digest of the log.
    #[serde(default)]
    pub log_digest: String,
    /// The first error of the job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_error: Option<FirstError>,
}

impl JobRecord {
    /// A job with this work that has not run, without a name or programs.
    pub(crate) fn queued(work: &JobWork) -> Self {
        Self {
            id: String::new(),
            tenant: tenant::default(),
            request_id: String::new(),
            content: String::new(),
            machine_name: String::new(),
            machine: Pinned::from(&work.machine),
            programs: Vec::new(),
            attended: work.options.attended,
            stepped: work.options.stepped,
            asked: JobAttributes::default(),
            reuse: Reuse::default(),
            state: JobState::Queued,
            runs: Runs::default(),
            cancel: false,
            paused: false,
            submitted_ms: 0,
            ended_ms: 0,
            aging_ms: 0,
            events: 0,
            makespan_ns: 0,
            highest_severity: 0,
            verdict: String::new(),
            error: String::new(),
            findings: Vec::new(),
            log_digest: String::new(),
            first_error: None,
        }
    }

    /// Notes that it ends now: never before its submit and its start.
    pub(crate) fn end(&mut self, clock: &Clock) {
        self.ended_ms = now_ms().max(self.submitted_ms).max(self.runs.started_ms);
        self.aging_ms = clock.now_ms();
    }

    /// Time from which it ages after its end, ms.
    pub(crate) fn ages_from(&self) -> i64 {
        if self.aging_ms == 0 { self.ended_ms } else { self.aging_ms }
    }

    /// Memory that it takes about, with the state of its job.
    pub(crate) fn bytes(&self) -> u64 {
        const STATE: usize = 2048;
        let programs = self.programs.iter();
        let programs: usize =
            programs.map(|program| 128 + program.file.len() + program.section.as_ref().map_or(0, String::len)).sum();
        let labels: usize = self.asked.labels.iter().map(|(key, value)| 96 + key.len() + value.len()).sum();
        (STATE + self.asked.guess.len() + self.machine_name.len() + programs + labels) as u64
    }

    /// Whether any further run would give the log of this one. A run that was stopped may have logged less than an
    /// earlier run that a pause or the end of a server has stopped; so may a run that an operator has stepped through.
    pub(crate) fn log_is_final(&self) -> bool {
        let stopped = match self.state {
            JobState::Queued | JobState::Running | JobState::Cancelled => true,
            JobState::Failed => self.runs.cause != Some(Cause::Program),
            JobState::Succeeded => false,
        };
        !stopped && !self.stepped
    }

    /// Whether another job asks for the same; `None` if that depends on the work of both.
    pub(crate) fn asks_the_same(&self, other: &Self) -> Option<bool> {
        self.content.starts_with(CONTENT).then(|| self.content == other.content)
    }

    /// Same with the work of both. The content of an early row covers limits that the server filled in: only fields
    /// that the client certainly sent are compared.
    pub(crate) fn asks_the_same_work(&self, work: &JobWork, other: &Self, other_work: &JobWork) -> bool {
        let sent = |work: &JobWork| JobOptions { limits: JobLimits::default(), ..work.options.clone() };
        self.machine_name == other.machine_name
            && self.programs == other.programs
            && work.files == other_work.files
            && other.asked == JobAttributes { limits: other.asked.limits.clone(), ..JobAttributes::default() }
            && sent(work) == sent(other_work)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::machines::MachineRecord;

    /// Work on a shipped machine.
    pub(crate) fn work() -> JobWork {
        let machine = MachineRecord::shipped("fanuc-mill");
        JobWork { machine, files: Vec::new(), options: JobOptions::default(), answers: Vec::new(), late: Vec::new() }
    }

    #[test]
    fn no_job_ends_before_its_submit_or_its_start() {
        let ahead = now_ms() + 3_600_000;
        let mut later = JobRecord { submitted_ms: ahead, ..record("a") };
        later.end(&Clock::from(ahead));
        assert!(later.ended_ms == ahead && later.aging_ms >= ahead);
        later.runs.started_ms = 2 * ahead;
        later.end(&Clock::from(0));
        assert_eq!(later.ended_ms, 2 * ahead);
        assert!(later.aging_ms < ahead);
    }

    /// A queued job.
    pub(crate) fn record(id: &str) -> JobRecord {
        JobRecord { id: id.to_owned(), request_id: id.to_owned(), ..JobRecord::queued(&work()) }
    }
}
