//! Measurements on request, and the readiness of the server for jobs.
//!
//! Invariant: asking takes no lock for longer than one job's worth.

use std::collections::BTreeMap;

use counterpoint_kernel::job::STACK;

use super::Core;
use crate::ledger::day;
use crate::ledger::record::{JobState, Priority, now_ms};
use crate::metrics::{QuotaUsage, WaitingJobs};

impl Core {
    /// Sets the gauges.
    pub(crate) fn observe(&self) {
        let mut waiting: BTreeMap<(String, Priority), (i64, i64)> = BTreeMap::new();
        let mut paused: BTreeMap<String, i64> = BTreeMap::new();
        for live in &self.board.live {
            if live.state() == JobState::Queued {
                live.peek(|record| {
                    if record.paused {
                        *paused.entry(record.tenant.clone()).or_default() += 1;
                        return;
                    }
                    let class = (record.tenant.clone(), record.asked.priority);
                    let (jobs, oldest) = waiting.entry(class).or_insert((0, i64::MAX));
                    *jobs += 1;
                    *oldest = (*oldest).min(record.submitted_ms);
                });
            }
        }
        let now = now_ms();
        let waiting = waiting.into_iter().map(|((tenant, priority), (jobs, oldest))| WaitingJobs {
            tenant,
            priority: priority.name(),
            jobs,
            age_s: now.saturating_sub(oldest).max(0) / 1000,
        });
        self.metrics.queue(waiting, paused.into_iter());
        self.observe_tenants();
        self.metrics.process.observe(self.connections.count());
        let count = |value: usize| i64::try_from(value).unwrap_or(i64::MAX);
        self.metrics.jobs.running.set(count(*self.running().borrow()));
        let (watchers, lag) = self.streams.count();
        self.metrics.watchers.set(count(watchers));
        self.metrics.lag.set(i64::try_from(lag).unwrap_or(i64::MAX));
        self.metrics.storage.free_bytes.set(self.host.free().map_or(0, |free| i64::try_from(free).unwrap_or(i64::MAX)));
        self.metrics.process.clock_ahead_s.set(self.board.clock.ahead_ms() / 1000);
        self.metrics.storage.ledger_bytes.set(i64::try_from(self.ledger.file_bytes()).unwrap_or(i64::MAX));
        self.metrics.storage.writable.set(i64::from(*self.ledger.writable().borrow()));
    }

    /// Sets the usage of each tenant.
    fn observe_tenants(&self) {
        let number = |value: u64| i64::try_from(value).unwrap_or(i64::MAX);
        let mut used: BTreeMap<String, QuotaUsage> = BTreeMap::new();
        for live in self.workers().running {
            live.peek(|record| used.entry(record.tenant.clone()).or_default().running += 1);
        }
        let today = day(now_ms());
        // Usage that cannot be read now is shown the next time.
        for (tenant, usage) in self.ledger.usages().unwrap_or_default() {
            let used = used.entry(tenant).or_default();
            used.bytes = number(usage.bytes);
            used.machine_bytes = number(usage.machines);
            used.cpu_s = number(usage.cpu_us_on(today) / 1_000_000);
        }
        for tenant in self.blobs.tenants().unwrap_or_default() {
            let bytes = self.blobs.of(&tenant).bytes().unwrap_or(0);
            used.entry(tenant).or_default().file_bytes = number(bytes);
        }
        self.metrics.tenants(used.into_iter());
    }

    /// Why no job would be accepted now; `None` if one would be.
    pub(crate) fn unready(&self) -> Option<String> {
        if self.drain.begun() {
            return Some("the server is shutting down".to_owned());
        }
        if !*self.ledger.writable().borrow() {
            return Some("the ledger cannot be written".to_owned());
        }
        if let Err(refusal) = self.room() {
            return Some(refusal.to_string());
        }
        let kernel = std::thread::Builder::new().name("probe".to_owned()).stack_size(STACK).spawn(|| ());
        match kernel.map(std::thread::JoinHandle::join) {
            Ok(_) => None,
            Err(error) => Some(format!("no thread for a kernel can be started ({error}): is there a limit of memory?")),
        }
    }
}
