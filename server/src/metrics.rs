//! The counters and measurements of the server.
//!
//! Invariants: [`TABLE`] names everything that is ever shown (a test compares it with the docs); labels have few
//! values, so nothing grows with jobs or callers but the list of tenants.

use std::sync::atomic::AtomicU64;
use std::time::Duration;

use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Metric, Registry};

use crate::ledger::Compacted;
use crate::process::ProcessMetrics;

/// Displayed name, kind, and description.
pub(crate) const TABLE: &[(&str, &str, &str)] = &[
    ("counterpoint_calls_total", "counter", "Calls answered, by `call` and `code`"),
    ("counterpoint_call_seconds", "histogram", "Time until a call was answered, or until a stream started, by `call`"),
    (
        "counterpoint_calls_deferred_total",
        "counter",
        "Calls that waited for earlier calls of their identity because other identities were active",
    ),
    ("counterpoint_calls_held_total", "counter", "Calls beyond `max_calls_per_s` that waited for their turn"),
    ("counterpoint_calls_waiting", "gauge", "Calls beyond `max_calls_per_s` that wait for their turn"),
    ("counterpoint_calls_limited_total", "counter", "Calls refused with `RATE_LIMITED`"),
    ("counterpoint_pauses_total", "counter", "Times that reading from a connection stopped after `RATE_LIMITED`"),
    ("counterpoint_jobs_accepted_total", "counter", "Jobs accepted"),
    ("counterpoint_jobs_ended_total", "counter", "Jobs ended, by `state`"),
    ("counterpoint_jobs_reused_total", "counter", "Jobs that got the results of an equal job instead of a run"),
    ("counterpoint_runs_failed_by_host_total", "counter", "Runs that the host failed; their jobs run again"),
    ("counterpoint_suspensions_total", "counter", "Times that a run was suspended for other tenants"),
    (
        "counterpoint_limits_reached_total",
        "counter",
        "Jobs stopped by a limit, by `limit`: wall_ms, max_job_bytes, deadline, simulated_ns, blocks, zero_time_blocks, events, memory, macro_steps",
    ),
    ("counterpoint_jobs_queued", "gauge", "Jobs waiting for a worker, by `tenant` and `priority`"),
    ("counterpoint_jobs_paused", "gauge", "Jobs that are held back, by `tenant`"),
    (
        "counterpoint_queue_age_seconds",
        "gauge",
        "Time since the acceptance of the job that has waited longest, by `tenant` and `priority`",
    ),
    ("counterpoint_tenant_running", "gauge", "Jobs on workers, by `tenant`"),
    ("counterpoint_tenant_stored_bytes", "gauge", "Bytes of logs, files and results of ended jobs, by `tenant`"),
    ("counterpoint_tenant_file_bytes", "gauge", "Bytes of uploaded files, by `tenant`"),
    ("counterpoint_tenant_machine_bytes", "gauge", "Bytes of the rows of machines, by `tenant`"),
    ("counterpoint_tenant_cpu_seconds", "gauge", "Processor time of the jobs that ended today (UTC), by `tenant`"),
    ("counterpoint_jobs_running", "gauge", "Jobs that are running or whose end is being stored"),
    ("counterpoint_events_total", "counter", "Events of all runs"),
    ("counterpoint_blocks_total", "counter", "Blocks of runs that are over"),
    ("counterpoint_watchers", "gauge", "Open watches"),
    ("counterpoint_watcher_lag_events", "gauge", "Events that the slowest watch is behind its log"),
    ("counterpoint_commit_seconds", "histogram", "Time of a commit of the ledger"),
    ("counterpoint_syncs_total", "counter", "Files and folders made durable"),
    ("counterpoint_free_bytes", "gauge", "Free bytes on the disk of the data folder"),
    ("counterpoint_ledger_bytes", "gauge", "Size of the ledger file, bytes"),
    ("counterpoint_ledger_compactions_total", "counter", "Compactions of the ledger"),
    ("counterpoint_ledger_compaction_seconds_total", "counter", "Seconds for which submits waited for compactions"),
    ("counterpoint_ledger_reclaimed_bytes_total", "counter", "Bytes by which compactions made the ledger smaller"),
    ("counterpoint_ledger_writable", "gauge", "1 while the ledger can be written, otherwise 0"),
    (
        "counterpoint_clock_ahead_seconds",
        "gauge",
        "Seconds by which the clock has jumped ahead, until the jump is confirmed; otherwise 0",
    ),
    (
        "counterpoint_webhooks_total",
        "counter",
        "Webhooks by `target` and `outcome`: delivered, refused, given_up, dropped",
    ),
    ("counterpoint_webhooks_waiting", "gauge", "Webhooks waiting for their target, by `target`"),
    ("counterpoint_connections", "gauge", "Open connections"),
    ("counterpoint_build_info", "gauge", "1, with the version of the server, by `version`"),
    ("process_resident_memory_bytes", "gauge", "Memory of the process"),
    ("process_open_fds", "gauge", "Open descriptors of the process"),
];

type One = [(&'static str, &'static str); 1];
type Two = [(&'static str, &'static str); 2];
type ByTenant = [(&'static str, String); 1];
type ByTarget = [(&'static str, String); 1];
type ByClass = [(&'static str, String); 2];

/// Waiting jobs of one tenant and priority: their number, and the age of the oldest in seconds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct WaitingJobs {
    pub(crate) tenant: String,
    pub(crate) priority: &'static str,
    pub(crate) jobs: i64,
    pub(crate) age_s: i64,
}

/// The use of the quotas of one tenant.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct QuotaUsage {
    pub(crate) running: i64,
    pub(crate) bytes: i64,
    pub(crate) file_bytes: i64,
    pub(crate) machine_bytes: i64,
    pub(crate) cpu_s: i64,
}

/// Jobs and bytes of tenants.
#[derive(Debug, Default)]
struct Tenants {
    running: Family<ByTenant, Gauge>,
    bytes: Family<ByTenant, Gauge>,
    file_bytes: Family<ByTenant, Gauge>,
    machine_bytes: Family<ByTenant, Gauge>,
    cpu_s: Family<ByTenant, Gauge>,
}

/// Calls of the contract.
#[derive(Debug)]
struct CallMetrics {
    total: Family<Two, Counter>,
    seconds: Family<One, Histogram, fn() -> Histogram>,
}

/// Calls of identities that call too often.
#[derive(Debug, Default)]
pub(crate) struct RateLimitMetrics {
    /// Calls that waited for the turn of their identity.
    pub(crate) deferred: Counter,
    pub(crate) held: Counter,
    waiting: Gauge,
    pub(crate) limited: Counter,
    pub(crate) pauses: Counter,
}

/// A call that waits, until it is dropped.
pub(crate) struct WaitingCall(Gauge);

impl RateLimitMetrics {
    /// Counts a call that waits.
    pub(crate) fn hold(&self) -> WaitingCall {
        self.held.inc();
        self.waiting.inc();
        WaitingCall(self.waiting.clone())
    }
}

impl Drop for WaitingCall {
    fn drop(&mut self) {
        self.0.dec();
    }
}

/// Jobs and their runs.
#[derive(Debug, Default)]
pub(crate) struct JobMetrics {
    pub(crate) accepted: Counter,
    ended: Family<One, Counter>,
    /// They got the results of an equal job.
    pub(crate) reused: Counter,
    pub(crate) failed_by_host: Counter,
    /// Times that a run was suspended.
    pub(crate) suspended: Counter,
    limits: Family<One, Counter>,
    queued: Family<ByClass, Gauge>,
    age: Family<ByClass, Gauge>,
    paused: Family<ByTenant, Gauge>,
    pub(crate) running: Gauge,
    pub(crate) events: Counter,
    pub(crate) blocks: Counter,
}

/// The stored data.
#[derive(Debug)]
pub(crate) struct StorageMetrics {
    commit_seconds: Histogram,
    pub(crate) syncs: Counter,
    pub(crate) free_bytes: Gauge,
    pub(crate) writable: Gauge,
    pub(crate) ledger_bytes: Gauge,
    compactions: Counter,
    compaction_seconds: Counter<f64, AtomicU64>,
    reclaimed: Counter,
}

/// Outcome of a webhook.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WebhookOutcome {
    /// The target took it.
    Delivered,
    /// The target does not want it.
    Refused,
    /// The target did not take it in time.
    GivenUp,
    /// Too many waited for the target.
    Dropped,
}

/// Webhooks of the targets.
#[derive(Debug, Default)]
struct WebhookMetrics {
    total: Family<ByClass, Counter>,
    waiting: Family<ByTarget, Gauge>,
}

/// All of it.
#[derive(Debug)]
pub(crate) struct Metrics {
    registry: Registry,
    calls: CallMetrics,
    pub(crate) rates: RateLimitMetrics,
    pub(crate) jobs: JobMetrics,
    tenants: Tenants,
    pub(crate) watchers: Gauge,
    pub(crate) lag: Gauge,
    pub(crate) storage: StorageMetrics,
    webhooks: WebhookMetrics,
    pub(crate) process: ProcessMetrics,
}

/// From half a millisecond to 16 s.
fn times() -> Histogram {
    Histogram::new(exponential_buckets(0.0005, 2.0, 16))
}

/// Registers a metric under its name in the table.
fn register(registry: &mut Registry, name: &str, metric: impl Metric) {
    let help = TABLE.iter().find(|row| row.0 == name).map_or("", |row| row.2);
    registry.register(name.strip_suffix("_total").unwrap_or(name), help, metric);
}

impl Metrics {
    pub(crate) fn new() -> Self {
        let seconds = Family::new_with_constructor(times as fn() -> Histogram);
        let calls = CallMetrics { total: Family::default(), seconds };
        let (rates, jobs) = (RateLimitMetrics::default(), JobMetrics::default());
        let tenants = Tenants::default();
        let storage = StorageMetrics {
            commit_seconds: times(),
            syncs: Counter::default(),
            free_bytes: Gauge::default(),
            writable: Gauge::default(),
            ledger_bytes: Gauge::default(),
            compactions: Counter::default(),
            compaction_seconds: Counter::default(),
            reclaimed: Counter::default(),
        };
        let (watchers, lag) = (Gauge::default(), Gauge::default());
        let mut registry = Registry::default();
        let all = &mut registry;
        register(all, "counterpoint_calls_total", calls.total.clone());
        register(all, "counterpoint_call_seconds", calls.seconds.clone());
        register(all, "counterpoint_calls_deferred_total", rates.deferred.clone());
        register(all, "counterpoint_calls_held_total", rates.held.clone());
        register(all, "counterpoint_calls_waiting", rates.waiting.clone());
        register(all, "counterpoint_calls_limited_total", rates.limited.clone());
        register(all, "counterpoint_pauses_total", rates.pauses.clone());
        register(all, "counterpoint_jobs_accepted_total", jobs.accepted.clone());
        register(all, "counterpoint_jobs_ended_total", jobs.ended.clone());
        register(all, "counterpoint_jobs_reused_total", jobs.reused.clone());
        register(all, "counterpoint_runs_failed_by_host_total", jobs.failed_by_host.clone());
        register(all, "counterpoint_suspensions_total", jobs.suspended.clone());
        register(all, "counterpoint_limits_reached_total", jobs.limits.clone());
        register(all, "counterpoint_jobs_queued", jobs.queued.clone());
        register(all, "counterpoint_jobs_paused", jobs.paused.clone());
        register(all, "counterpoint_queue_age_seconds", jobs.age.clone());
        register(all, "counterpoint_tenant_running", tenants.running.clone());
        register(all, "counterpoint_tenant_stored_bytes", tenants.bytes.clone());
        register(all, "counterpoint_tenant_file_bytes", tenants.file_bytes.clone());
        register(all, "counterpoint_tenant_machine_bytes", tenants.machine_bytes.clone());
        register(all, "counterpoint_tenant_cpu_seconds", tenants.cpu_s.clone());
        register(all, "counterpoint_jobs_running", jobs.running.clone());
        register(all, "counterpoint_events_total", jobs.events.clone());
        register(all, "counterpoint_blocks_total", jobs.blocks.clone());
        register(all, "counterpoint_watchers", watchers.clone());
        register(all, "counterpoint_watcher_lag_events", lag.clone());
        register(all, "counterpoint_commit_seconds", storage.commit_seconds.clone());
        register(all, "counterpoint_syncs_total", storage.syncs.clone());
        register(all, "counterpoint_free_bytes", storage.free_bytes.clone());
        register(all, "counterpoint_ledger_bytes", storage.ledger_bytes.clone());
        register(all, "counterpoint_ledger_compactions_total", storage.compactions.clone());
        register(all, "counterpoint_ledger_compaction_seconds_total", storage.compaction_seconds.clone());
        register(all, "counterpoint_ledger_reclaimed_bytes_total", storage.reclaimed.clone());
        register(all, "counterpoint_ledger_writable", storage.writable.clone());
        let process = ProcessMetrics::new();
        register(all, "counterpoint_clock_ahead_seconds", process.clock_ahead_s.clone());
        let webhooks = WebhookMetrics::default();
        register(all, "counterpoint_webhooks_total", webhooks.total.clone());
        register(all, "counterpoint_webhooks_waiting", webhooks.waiting.clone());
        register(all, "counterpoint_connections", process.connections.clone());
        register(all, "counterpoint_build_info", process.build.clone());
        register(all, "process_resident_memory_bytes", process.resident_bytes.clone());
        register(all, "process_open_fds", process.open_descriptors.clone());
        Self { registry, calls, rates, jobs, tenants, watchers, lag, storage, webhooks, process }
    }

    /// Counts an answered call; `call` is one of few names.
    pub(crate) fn call(&self, call: &'static str, code: &'static str, time: Duration) {
        self.calls.total.get_or_create(&[("call", call), ("code", code)]).inc();
        self.calls.seconds.get_or_create(&[("call", call)]).observe(time.as_secs_f64());
    }

    /// Counts the end of a job.
    pub(crate) fn ended(&self, state: &'static str) {
        self.jobs.ended.get_or_create(&[("state", state)]).inc();
    }

    /// Counts a limit that has stopped a job.
    pub(crate) fn limit(&self, limit: &'static str) {
        self.jobs.limits.get_or_create(&[("limit", limit)]).inc();
    }

    /// Counts the outcome of a webhook.
    pub(crate) fn webhook(&self, target: &str, outcome: WebhookOutcome) {
        let outcome = match outcome {
            WebhookOutcome::Delivered => "delivered",
            WebhookOutcome::Refused => "refused",
            WebhookOutcome::GivenUp => "given_up",
            WebhookOutcome::Dropped => "dropped",
        };
        self.webhooks.total.get_or_create(&[("target", target.to_owned()), ("outcome", outcome.to_owned())]).inc();
    }

    /// Counts webhooks that begin (1) or cease (-1) to wait for their target.
    pub(crate) fn webhooks_waiting(&self, target: &str, change: i64) {
        self.webhooks.waiting.get_or_create(&[("target", target.to_owned())]).inc_by(change);
    }

    /// Measures a commit of the ledger.
    pub(crate) fn commit(&self, time: Duration) {
        self.storage.commit_seconds.observe(time.as_secs_f64());
    }

    /// Counts a compaction of the ledger.
    pub(crate) fn compacted(&self, done: &Compacted) {
        self.storage.compactions.inc();
        self.storage.compaction_seconds.inc_by(done.time.as_secs_f64());
        self.storage.reclaimed.inc_by(done.reclaimed());
    }

    /// Sets the waiting jobs and the number of paused jobs of each tenant. A tenant without jobs is no longer shown.
    pub(crate) fn queue(
        &self,
        waiting: impl Iterator<Item = WaitingJobs>,
        paused: impl Iterator<Item = (String, i64)>,
    ) {
        self.jobs.queued.clear();
        self.jobs.age.clear();
        self.jobs.paused.clear();
        for WaitingJobs { tenant, priority, jobs, age_s } in waiting {
            let labels = [("tenant", tenant), ("priority", priority.to_owned())];
            self.jobs.queued.get_or_create(&labels).set(jobs);
            self.jobs.age.get_or_create(&labels).set(age_s);
        }
        for (tenant, jobs) in paused {
            self.jobs.paused.get_or_create(&[("tenant", tenant)]).set(jobs);
        }
    }

    /// Sets the usage of each tenant. A tenant without usage is no longer shown.
    pub(crate) fn tenants(&self, used: impl Iterator<Item = (String, QuotaUsage)>) {
        let Tenants { running, bytes, file_bytes, machine_bytes, cpu_s } = &self.tenants;
        [running, bytes, file_bytes, machine_bytes, cpu_s].iter().for_each(|family| family.clear());
        for (tenant, used) in used.filter(|(_, used)| *used != QuotaUsage::default()) {
            let labels = [("tenant", tenant)];
            running.get_or_create(&labels).set(used.running);
            bytes.get_or_create(&labels).set(used.bytes);
            file_bytes.get_or_create(&labels).set(used.file_bytes);
            machine_bytes.get_or_create(&labels).set(used.machine_bytes);
            cpu_s.get_or_create(&labels).set(used.cpu_s);
        }
    }

    /// All metrics as a text that Prometheus reads.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = encode(&mut text, &self.registry);
        text
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_docs_list_all_metrics_and_nothing_else() {
        let docs = include_str!("../../docs/operations.md");
        let part = docs.split_once("| metric | kind | meaning |").unwrap().1;
        let rows: Vec<&str> = part.lines().skip(2).take_while(|line| line.starts_with('|')).collect();
        let row = |(name, kind, help): &(&str, &str, &str)| format!("| `{name}` | {kind} | {help} |");
        let expected: Vec<String> = TABLE.iter().map(row).collect();
        assert_eq!(rows, expected, "expected:\n{}", expected.join("\n"));
    }

    #[test]
    fn what_is_shown_is_in_the_table() {
        let metrics = Metrics::new();
        metrics.call("GetJob", "Ok", Duration::from_millis(3));
        metrics.ended("SUCCEEDED");
        metrics.limit("wall_ms");
        metrics.webhook("mes", WebhookOutcome::Refused);
        metrics.webhooks_waiting("mes", 1);
        let waiting = WaitingJobs { tenant: "a".to_owned(), priority: "low", jobs: 3, age_s: 7 };
        metrics.queue([waiting].into_iter(), [("b".to_owned(), 2)].into_iter());
        let used = QuotaUsage { running: 1, bytes: 40, file_bytes: 50, machine_bytes: 60, cpu_s: 2 };
        metrics.tenants([("c".to_owned(), used), ("d".to_owned(), QuotaUsage::default())].into_iter());
        let text = metrics.text();
        assert!(text.contains("counterpoint_tenant_stored_bytes{tenant=\"c\"} 40"), "{text}");
        assert!(text.contains("counterpoint_tenant_file_bytes{tenant=\"c\"} 50"), "{text}");
        assert!(text.contains("counterpoint_tenant_machine_bytes{tenant=\"c\"} 60"), "{text}");
        assert!(!text.contains("tenant=\"d\""), "a tenant that uses nothing is not shown");
        let shown: BTreeSet<(&str, &str)> =
            text.lines().filter_map(|line| line.strip_prefix("# TYPE ")?.split_once(' ')).collect();
        let row =
            |(name, kind, _): &(&'static str, &'static str, &str)| (name.strip_suffix("_total").unwrap_or(name), *kind);
        let table: BTreeSet<_> = TABLE.iter().map(row).collect();
        assert_eq!(shown, table);
        assert!(text.contains("counterpoint_jobs_queued{tenant=\"a\",priority=\"low\"} 3"), "{text}");
        assert!(text.contains("counterpoint_jobs_paused{tenant=\"b\"} 2"), "{text}");
        metrics.queue(std::iter::empty(), std::iter::empty());
        assert!(!metrics.text().contains("tenant=\"a\""), "tenants whose jobs have gone are not shown");
    }
}
