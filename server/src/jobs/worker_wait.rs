//! The wait of a queued job for a worker that the jobs of its own tenant hold.
//!
//! *Invariant:* a tenant learns nothing about the jobs of other tenants.

use counterpoint_proto::v1;

use super::Core;
use super::lock::lock;
use crate::queue::TenantWorkers;

/// Why no queued job of a tenant starts; `None` if its own jobs do not prevent it. Unless the quota is reached, jobs
/// are a reason only if one of them waits for a client.
pub(crate) fn of(core: &Core, tenant: &str) -> Option<v1::WorkerWait> {
    let own = lock(&core.board.queue).jobs.on_workers(tenant);
    reason(own, core.options.slots())
}

fn reason(TenantWorkers { running, waiting_for_client, quota }: TenantWorkers, slots: usize) -> Option<v1::WorkerWait> {
    let by_quota = quota > 0 && quota < slots;
    let workers = if by_quota { quota } else { slots };
    let wire = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let held = running >= workers && (by_quota || waiting_for_client > 0);
    held.then(|| v1::WorkerWait {
        workers: wire(workers),
        waiting_for_client: wire(waiting_for_client),
        tenant_running: by_quota,
    })
}

/// Adds the reason to the status of a job of the tenant.
pub(crate) fn mark(reason: Option<v1::WorkerWait>, status: &mut v1::JobStatus) {
    if status.state() == v1::JobState::Queued && !status.paused && !status.waits_for_suspect {
        status.worker_wait = reason;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_jobs_that_stand_and_the_quota_are_reasons() {
        let of = |running, waiting_for_client, quota| {
            let wait = reason(TenantWorkers { running, waiting_for_client, quota }, 2)?;
            Some((wait.workers, wait.waiting_for_client, wait.tenant_running))
        };
        assert_eq!(of(2, 2, 0), Some((2, 2, false)));
        assert_eq!(of(2, 1, 5), Some((2, 1, false)));
        assert_eq!(of(1, 0, 1), Some((1, 0, true)));
        assert_eq!(of(1, 1, 1), Some((1, 1, true)));
        assert_eq!((of(2, 0, 0), of(1, 1, 0), of(0, 0, 1)), (None, None, None));
    }
}
