//! Quotas and retention of single tenants, where they differ from the general ones.
//!
//! Only the configuration file has these, one table per tenant: `[tenants.NAME]`. Invariant: a quota that the table of
//! a tenant does not name is the one for all.

use serde::{Deserialize, Serialize};

use super::Quotas;

/// The own quotas and retention of one tenant; 0 = without limit.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tenant {
    /// Most jobs that wait.
    pub queued: Option<usize>,
    /// Most jobs that run at the same time.
    pub running: Option<usize>,
    /// Most bytes of uploaded files, machines and ended jobs.
    pub bytes: Option<u64>,
    /// Most uploads at the same time.
    pub uploads: Option<usize>,
    /// Seconds of processor time on a day (UTC).
    pub cpu_s: Option<u64>,
    /// Seconds that an ended job is kept.
    pub keep_s: Option<u64>,
    /// Most ended jobs that are kept.
    pub keep_jobs: Option<u64>,
    /// Most bytes of logs, files and results of ended jobs that are kept.
    pub keep_bytes: Option<u64>,
}

impl Tenant {
    /// Quotas of the tenant, based on the quotas of `all`.
    pub(crate) fn quotas(&self, all: &Quotas) -> Quotas {
        Quotas {
            tenant_queued: self.queued.unwrap_or(all.tenant_queued),
            tenant_running: self.running.unwrap_or(all.tenant_running),
            tenant_bytes: self.bytes.unwrap_or(all.tenant_bytes),
            tenant_uploads: self.uploads.unwrap_or(all.tenant_uploads),
            tenant_cpu_s: self.cpu_s.unwrap_or(all.tenant_cpu_s),
        }
    }
}
