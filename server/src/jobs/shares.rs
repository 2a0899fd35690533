//! Quotas of each tenant: the options for all, and the tables of single tenants, which may change while the server
//! runs.
//!
//! *Invariant:* a refusal names the quota, its limit, the usage, and a remedy; a quota that a table does not name is
//! the one for all.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, PoisonError, RwLock};

use super::Core;
use super::live::lock;
use crate::ledger::day;
use crate::ledger::record::now_ms;
use crate::options::{Options, Quotas, Tenant};
use crate::places::Places;
use crate::reason::Refusal;

/// Tables of tenants by name.
pub(crate) type Tenants = BTreeMap<String, Tenant>;

/// Tables of tenants, and places for uploads.
#[derive(Debug)]
pub(crate) struct Shares {
    tenants: RwLock<Arc<Tenants>>,
    by_connection: Arc<Places<Option<SocketAddr>>>,
    by_tenant: Arc<Places<String>>,
}

impl Shares {
    pub(super) fn new(options: &Options) -> Self {
        let limits = &options.connections;
        Self {
            tenants: RwLock::new(Arc::new(options.tenants.clone())),
            by_connection: Arc::new(Places::new(limits.max_uploads, limits.max_uploads_per_connection)),
            by_tenant: Arc::new(Places::new(usize::MAX, usize::MAX)),
        }
    }
}

impl Core {
    /// The tables of tenants.
    pub(crate) fn tenants(&self) -> Arc<Tenants> {
        self.shares.tenants.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Replaces the tables of tenants. Jobs and uploads beyond the new quotas continue.
    pub(crate) fn set_tenants(&self, tenants: Tenants) {
        let tenants = Arc::new(tenants);
        *self.shares.tenants.write().unwrap_or_else(PoisonError::into_inner) = tenants;
        self.let_run();
    }

    /// Tells the queue how many workers each tenant may have.
    pub(super) fn let_run(&self) {
        let own = self.tenants();
        let own = own.iter().filter_map(|(name, own)| Some((name.clone(), own.running?))).collect();
        lock(&self.board.queue).jobs.let_run(self.options.quotas.tenant_running, own);
    }

    /// Quotas of a tenant.
    pub(crate) fn quotas_of(&self, tenant: &str) -> Quotas {
        let all = &self.options.quotas;
        self.tenants().get(tenant).map_or_else(|| all.clone(), |own| own.quotas(all))
    }

    /// A place for an upload of a tenant, given back when dropped.
    pub(crate) fn upload(&self, peer: Option<SocketAddr>, tenant: &str) -> Result<impl Send + use<>, Refusal> {
        let most = self.quotas_of(tenant).tenant_uploads;
        let place = self.shares.by_connection.take(peer).ok_or(Refusal::TooManyUploads)?;
        let each = if most == 0 { usize::MAX } else { most };
        let quota = || {
            let text = "as many uploads are under way: upload again after one of them has ended";
            Refusal::quota(tenant, "tenant_uploads", most as u64, text.to_owned())
        };
        Ok((place, self.shares.by_tenant.take_of(tenant.to_owned(), each).ok_or_else(quota)?))
    }

    /// Refuses new work of a tenant that has reached a quota.
    pub(crate) fn within_quotas(&self, tenant: &str) -> Result<(), Refusal> {
        let quotas = self.quotas_of(tenant);
        if quotas.tenant_bytes == 0 && quotas.tenant_cpu_s == 0 {
            return Ok(());
        }
        let usage = self.ledger.usage(tenant)?;
        if quotas.tenant_bytes > 0 && usage.bytes >= quotas.tenant_bytes {
            let text = format!("{} bytes are stored: delete ended jobs (DeleteJob)", usage.bytes);
            return Err(Refusal::quota(tenant, "tenant_bytes", quotas.tenant_bytes, text));
        }
        let seconds = usage.cpu_us_on(day(now_ms())) / 1_000_000;
        if quotas.tenant_cpu_s > 0 && seconds >= quotas.tenant_cpu_s {
            let text = format!(
                "the jobs that ended today have taken {seconds} s of processor time: submit again after midnight UTC"
            );
            return Err(Refusal::quota(tenant, "tenant_cpu_s", quotas.tenant_cpu_s, text));
        }
        Ok(())
    }
}
