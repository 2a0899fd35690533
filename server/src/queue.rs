//! The queue: which job runs next, and how many are before a given one.
//!
//! [`Queue`] is the seam; the one in memory is in `local`. Tenants get equal shares of worker time: the tenant that has
//! used the least is next, and a run of the tenant that has used the most is suspended for it. Of one tenant, urgent
//! jobs go first and others in the order of acceptance; a job that has waited long counts as more urgent. Two kinds go
//! before these: jobs of the tenant whose run the host failed, when their time has come, and, one at a time, jobs that
//! were running when the previous server died, which run alone for a while. A job that is held back keeps its place
//! among the jobs that a tenant may let wait, but takes no turn. Invariant: a job is waiting, running or being stored,
//! and never two of these.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Debug;
use std::time::{Duration, Instant};

use crate::ledger::record::Priority;

/// Why a job is put into the queue, and with that where.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EnqueueReason {
    /// It was accepted then: after those of its tenant that are as urgent.
    Accepted(Instant),
    /// It was running when the previous server died: it goes first, and runs alone for this time, or for the rest of
    /// its time if it has already run alone.
    Suspect(Duration),
    /// It waits for another run until then, and goes first.
    Again(Instant),
    /// It is held back until it is taken out.
    Paused,
}

/// A job that is to wait.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ticket<'a> {
    pub(crate) id: &'a str,
    pub(crate) tenant: &'a str,
    pub(crate) priority: Priority,
}

/// State of the server when the queue decides.
pub(crate) struct SchedulingState<'a> {
    /// Runs that may use a core at the same time.
    pub(crate) slots: usize,
    /// Whether jobs may start now.
    pub(crate) starts: bool,
    /// Whether there is memory for more than twice as many runs as slots.
    pub(crate) room: bool,
    pub(crate) now: Instant,
    /// Whether a run takes no processor time until a client acts.
    pub(crate) waits_for_client: &'a dyn Fn(&str) -> bool,
}

/// The jobs of a tenant on workers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TenantWorkers {
    pub(crate) running: usize,
    /// Number of these jobs whose runs waited for a client at the last look.
    pub(crate) waiting_for_client: usize,
    /// Maximum number of workers of the tenant; 0 = no limit.
    pub(crate) quota: usize,
}

/// Jobs that wait, and who has a place. Calls do not block.
pub(crate) trait Queue: Send + Debug {
    /// Lets each tenant have `most` workers, and single tenants other numbers; 0 = without limit. Jobs that run
    /// continue.
    fn let_run(&mut self, most: usize, own: HashMap<String, usize>);

    /// Jobs that wait, also those held back.
    fn len(&self) -> usize;

    /// Jobs that wait for a worker.
    fn waiting(&self) -> usize;

    /// Whether a job is held back.
    fn is_paused(&self, id: &str) -> bool;

    /// Jobs of a tenant that wait.
    fn waiting_of(&self, tenant: &str) -> usize;

    /// Whether jobs of other tenants than this one take processor time, or wait for a worker that another job keeps
    /// busy. A run that `waits_for_client` takes none.
    fn others_work(&self, tenant: &str, waits_for_client: &dyn Fn(&str) -> bool) -> bool;

    /// Lets a job wait.
    fn push(&mut self, ticket: Ticket<'_>, entry: EnqueueReason);

    /// Divides the slots among the tenants: suspends and resumes runs, and takes the next job that starts. To be called
    /// until it returns none.
    fn next(&mut self, look: &SchedulingState<'_>) -> Option<String>;

    /// A run is over: its job gives its worker free before its end is stored, unless too many do that already.
    fn store(&mut self, id: &str, now: Instant);

    /// A job is neither running nor being stored any more.
    fn free(&mut self, id: &str, now: Instant);

    /// Takes a job out; `false` if it does not wait.
    fn remove(&mut self, id: &str) -> bool;

    /// Forgets an ended job, which is no longer a suspect.
    fn forget(&mut self, id: &str);

    /// Jobs cleared since the last call: former suspects that have run alone for their time, or have paused.
    fn take_cleared(&mut self) -> Vec<String>;

    /// The suspect that runs alone.
    fn alone(&self) -> Option<&str>;

    /// Jobs that are likely to run before this one; 0 if it does not wait.
    fn before(&self, id: &str) -> usize;

    /// Jobs on workers, also suspended ones.
    fn running(&self) -> Vec<String>;

    /// Jobs on workers whose runs are to be suspended.
    fn suspended(&self) -> BTreeSet<String>;

    /// Busy jobs whose runs use no processor time. They are suspended, were waiting at the last check, or have ended,
    /// and the end has been in storage for some time.
    fn idle(&self) -> BTreeSet<String>;

    /// Whether these are the jobs of [`Queue::idle`].
    fn are_idle(&self, jobs: &BTreeSet<String>) -> bool;

    /// The jobs of a tenant on workers.
    fn on_workers(&self, tenant: &str) -> TenantWorkers;

    /// Number of jobs on workers.
    fn workers(&self) -> usize;

    /// Jobs that run or are being stored.
    fn busy(&self) -> BTreeSet<String>;

    /// Number of jobs that run or are being stored.
    fn busy_count(&self) -> usize;
}
