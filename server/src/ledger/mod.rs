//! The ledger: every accepted job and every machine put there.
//!
//! [`Ledger`] is the seam; the implementation in a file of the data folder is in `local`. Invariants: an answered
//! request is on stable storage; jobs are ordered as they were accepted, regardless of the clock; a row that cannot be
//! read is reported to callers that request it and hidden from all others.

pub(crate) mod crashes;
pub(crate) mod first_error;
pub(crate) mod prefix;
pub(crate) mod record;
pub(crate) mod settled;
mod work;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::time::Duration;

use bytes::Bytes;
use tokio::sync::watch;
use uuid::Uuid;

use crate::machines::MachineRecord;
use crate::reason::Refusal;
use prefix::IdPrefix;
use record::{JobRecord, JobState, JobWork};
use settled::Settled;

/// Asked before something is stored, while no blob can be collected.
pub(crate) type Check<T> = Box<dyn FnOnce(&T) -> Result<(), Refusal> + Send>;
/// Called when a job is durable, in the order of acceptance.
pub(crate) type Accepted = Box<dyn FnOnce(&JobRecord) + Send>;

/// Called with how it went.
pub(crate) type Then = Box<dyn FnOnce(Result<(), Refusal>) + Send>;

/// A job to accept: its record has no identity yet. In a box, as each future that it passes through would copy it.
#[derive(Debug)]
pub(crate) struct NewJob {
    pub(crate) record: JobRecord,
    pub(crate) work: JobWork,
}

/// Answer to a submit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SubmitOutcome {
    /// Accepted now; it has got its identity.
    New(Box<JobRecord>),
    /// Accepted earlier under this id.
    Known(Box<JobRecord>),
}

/// The kept data of ended jobs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Keep {
    /// How long, ms.
    pub(crate) age_ms: Option<i64>,
    /// How many.
    pub(crate) jobs: Option<u64>,
    /// How many bytes.
    pub(crate) bytes: Option<u64>,
    /// How many of one tenant, and how many bytes.
    pub(crate) tenant_jobs: Option<u64>,
    pub(crate) tenant_bytes: Option<u64>,
    /// Tenants of which other amounts are kept.
    pub(crate) own: BTreeMap<String, TenantRetention>,
}

/// The kept data of the ended jobs of one tenant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct TenantRetention {
    /// How long, ms.
    pub(crate) age_ms: Option<i64>,
    /// How many.
    pub(crate) jobs: Option<u64>,
    /// How many bytes.
    pub(crate) bytes: Option<u64>,
}

impl Keep {
    /// The kept data of a tenant.
    pub(crate) fn of(&self, tenant: &str) -> TenantRetention {
        let all = || TenantRetention { age_ms: self.age_ms, jobs: self.tenant_jobs, bytes: self.tenant_bytes };
        self.own.get(tenant).copied().unwrap_or_else(all)
    }

    /// Whether everything is kept.
    pub(crate) fn everything(&self) -> bool {
        let limits = [self.jobs, self.bytes, self.tenant_jobs, self.tenant_bytes];
        let own = self.own.values().all(|own| *own == TenantRetention::default());
        own && self.age_ms.is_none() && limits.iter().all(Option::is_none)
    }
}

/// An ended job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct EndedJob {
    pub(crate) id: String,
    /// By the clock that never goes back.
    pub(crate) ended_ms: i64,
}

/// Which jobs are wanted, and how many.
#[derive(Debug, Clone, Default)]
pub(crate) struct Query {
    pub(crate) tenant: String,
    /// In one of these states; empty = in any, unless jobs that are held back are wanted.
    pub(crate) states: BTreeSet<JobState>,
    /// Jobs that run: the ledger knows them as waiting.
    pub(crate) running: BTreeSet<String>,
    /// Jobs that are held back, if those are wanted beside the ones in the states.
    pub(crate) paused: Option<BTreeSet<String>>,
    /// Submitted for this machine, perhaps with its revision.
    pub(crate) machine: Option<String>,
    pub(crate) labels: BTreeMap<String, String>,
    /// Accepted from here on, and before there, by the time in the identity, ms; 0 = any time.
    pub(crate) from_ms: i64,
    pub(crate) until_ms: i64,
    /// Prefix of the identities; empty = all.
    pub(crate) prefix: IdPrefix,
    pub(crate) newest_first: bool,
    /// After this job in the order asked for; empty = from the start.
    pub(crate) after: String,
    pub(crate) count: usize,
    /// Most bytes of the rows of the page; a single job may have more. 0 = [`PAGE_BYTES`].
    pub(crate) most_bytes: u64,
    /// The page has the short identities of its jobs.
    pub(crate) short_ids: bool,
}

/// Bytes of the rows of a page, or of the jobs of a message; a single job may have more.
pub(crate) const PAGE_BYTES: u64 = 1 << 20;

/// A page of jobs.
#[derive(Debug, Default)]
pub(crate) struct Page {
    pub(crate) jobs: Vec<JobRecord>,
    /// Of the same jobs, if requested.
    pub(crate) short_ids: Vec<String>,
    /// Bytes of their rows.
    pub(crate) bytes: u64,
    /// Where the next page begins; none if there is none.
    pub(crate) next: Option<String>,
}

/// Time in an identity, ms: when the job was accepted, by a clock that never goes back.
pub(crate) fn time_of(id: Uuid) -> i64 {
    i64::try_from(id.as_u128() >> 80).unwrap_or(i64::MAX)
}

/// A storage that was made smaller: bytes before and after, and the time for which operations waited.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Compacted {
    pub(crate) before: u64,
    pub(crate) after: u64,
    pub(crate) time: Duration,
}

/// The use of a tenant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Usage {
    /// Bytes of requests, logs, files and results of its ended jobs.
    pub(crate) bytes: u64,
    /// Bytes of its machines without their files.
    pub(crate) machines: u64,
    /// Day on which the last job ended, since 1970 UTC, and the processor time of the jobs of that day, µs.
    pub(crate) day: u64,
    pub(crate) cpu_us: u64,
}

/// A day, ms.
const DAY_MS: i64 = 86_400_000;

/// The day of a time, since 1970 UTC.
pub(crate) fn day(ms: i64) -> u64 {
    u64::try_from(ms / DAY_MS).unwrap_or(0)
}

impl Usage {
    /// Processor time of the jobs of a day, µs.
    pub(crate) fn cpu_us_on(&self, day: u64) -> u64 {
        if self.day == day { self.cpu_us } else { 0 }
    }
}

/// Keeps jobs and machines. Calls that are not async may block.
#[tonic::async_trait]
pub(crate) trait Ledger: Send + Sync + Debug {
    /// Completes the pending requests and releases the storage; later requests are refused.
    fn close(&self);

    /// Whether something can be stored, to be followed.
    fn writable(&self) -> watch::Receiver<bool>;

    /// Accepts a job and gives it its identity, or finds the one accepted under the same request id.
    async fn submit(
        &self,
        job: Box<NewJob>,
        check: Check<JobWork>,
        accepted: Accepted,
    ) -> Result<SubmitOutcome, Refusal>;

    /// Stores a new state of a job. Cancels and pauses that were stored before are kept, here, in
    /// [`Ledger::update_blocking`] and in [`Ledger::end`]; only the end of the job ends a pause.
    async fn update(&self, record: JobRecord) -> Result<(), Refusal>;

    /// Stores new states of jobs, either all or none, from a thread that may block.
    fn update_blocking(&self, records: Vec<JobRecord>) -> Result<(), Refusal>;

    /// Notes that the cancel of a job was accepted.
    async fn flag_cancel(&self, id: String) -> Result<(), Refusal>;

    /// Notes whether a job is held back, unless it has ended.
    async fn flag_paused(&self, id: String, paused: bool) -> Result<(), Refusal>;

    /// Stores that jobs are no longer suspects, unless they have ended, from a thread that may block.
    fn clear_blocking(&self, ids: Vec<String>) -> Result<(), Refusal>;

    /// Stores the outcome of a question to the operator, unless the job has ended.
    async fn answered(&self, id: String, settled: Settled) -> Result<(), Refusal>;

    /// Same from a thread that may block.
    fn answered_blocking(&self, id: String, settled: Settled) -> Result<(), Refusal>;

    /// Stores the end of a job, with its log if that is small, from a thread that may block until others have been
    /// taken; `then` is called when the end is durable or could not be made so, and must not block.
    fn end(&self, record: JobRecord, log: Option<Bytes>, then: Then);

    /// The log of a job, if it is kept here.
    fn log(&self, id: &str) -> Result<Option<Bytes>, Refusal>;

    /// Removes a job and its request id; `false` if it was removed before.
    async fn remove(&self, record: JobRecord) -> Result<bool, Refusal>;

    /// Removes ended jobs, from a thread that may block; returns for each job `false` if it was removed before.
    fn remove_blocking(&self, jobs: Vec<EndedJob>) -> Result<Vec<bool>, Refusal>;

    /// Ended jobs beyond the retention limits, oldest first, with the time of their end.
    fn expired(&self, keep: &Keep, now_ms: i64, most: usize) -> Result<Vec<EndedJob>, Refusal>;

    /// One job.
    fn job(&self, id: &str) -> Result<Option<JobRecord>, Refusal>;

    /// The work of a job.
    fn work(&self, id: &str) -> Result<Option<JobWork>, Refusal>;

    /// Whether there is a row of a job, readable or not.
    fn knows(&self, id: &str) -> Result<bool, Refusal>;

    /// The job of a tenant that was accepted under a request id.
    fn by_request(&self, tenant: &str, request_id: &str) -> Result<Option<JobRecord>, Refusal>;

    /// The most recently ended job of a tenant with this digest of its inputs.
    fn equal(&self, tenant: &str, digest: &str) -> Result<Option<JobRecord>, Refusal>;

    /// A page of jobs. It takes a bounded time, however many jobs there are and however few are wanted.
    fn jobs(&self, query: &Query) -> Result<Page, Refusal>;

    /// Jobs that had not ended when the server went down, in order of submission.
    fn unfinished(&self) -> Result<Vec<JobRecord>, Refusal>;

    /// The use of each tenant.
    fn usages(&self) -> Result<Vec<(String, Usage)>, Refusal>;

    /// The use of a tenant.
    fn usage(&self, tenant: &str) -> Result<Usage, Refusal>;

    /// The time by which jobs age when the ledger was opened, ms since 1970, as far as is known.
    fn highest_ms(&self) -> i64;

    /// Stores the time by which jobs age, from a thread that may block.
    fn keep_highest(&self, ms: i64) -> Result<(), Refusal>;

    /// Number of this opening of the ledger: each is larger than the one before.
    fn epoch(&self) -> u64;

    /// Stores a machine of a tenant under its name and its revision. One that is trusted is replaced by another such
    /// only.
    async fn put_machine(&self, definition: MachineRecord, check: Check<MachineRecord>) -> Result<(), Refusal>;

    /// Removes a machine of a tenant with all its revisions; `false` if there is none. One that is trusted is removed
    /// for `trusted` callers only.
    async fn remove_machine(&self, tenant: String, name: String, trusted: bool) -> Result<bool, Refusal>;

    /// A machine of a tenant by `name` or `name@revision`.
    fn machine(&self, tenant: &str, name: &str) -> Result<Option<MachineRecord>, Refusal>;

    /// All machines of a tenant, newest revision each, by name.
    fn machines(&self, tenant: &str) -> Result<Vec<MachineRecord>, Refusal>;

    /// Calls `remove` for those of the blobs of a tenant that no row needs; meanwhile no row can begin to need one.
    fn collect_blocking(
        &self,
        tenant: &str,
        digests: Vec<String>,
        remove: Box<dyn Fn(&str) -> bool + Send>,
    ) -> Result<usize, Refusal>;

    /// Copies itself for the backups that ask for it.
    fn serve_backups(&self);

    /// Makes its file smaller, from a thread that may block. Operations wait meanwhile.
    fn compact_blocking(&self) -> Result<Compacted, Refusal>;

    /// Size of its file in bytes; 0 for a ledger in memory.
    fn file_bytes(&self) -> u64;

    /// Bytes that its rows need in the file. Reads all pages.
    fn used_bytes(&self) -> Result<u64, Refusal>;
}
