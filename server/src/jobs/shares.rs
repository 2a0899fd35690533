//! Quotas of each tenant: the options for all, and the tables of single tenants, which may change while the server
//! runs.
//!
//! *Invariant:* a refusal names the quota, its limit, the usage, and a remedy; a quota that a table does not name is
//! the one for all.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use super::Core;
use super::growing::Growing;
use super::lock::lock;
use crate::ledger::day;
use crate::ledger::record::now_ms;
use crate::options::{Quotas, ServerOptions, Tenant};
use crate::places::SlotLimiter;
use crate::reason::Refusal;

/// Tables of tenants by name.
pub(crate) type Tenants = BTreeMap<String, Tenant>;

/// Tables of tenants, and places for uploads.
#[derive(Debug)]
pub(crate) struct TenantQuotas {
    tenants: RwLock<Arc<Tenants>>,
    by_connection: Arc<SlotLimiter<Option<SocketAddr>>>,
    by_tenant: Arc<SlotLimiter<String>>,
    /// Bytes of uploads in progress by tenant.
    growing: Arc<Mutex<BTreeMap<String, u64>>>,
}

impl TenantQuotas {
    pub(super) fn new(options: &ServerOptions) -> Self {
        let limits = &options.connections;
        Self {
            tenants: RwLock::new(Arc::new(options.tables.tenants.clone())),
            by_connection: Arc::new(SlotLimiter::new(limits.max_uploads, limits.max_uploads_per_connection)),
            by_tenant: Arc::new(SlotLimiter::new(usize::MAX, usize::MAX)),
            growing: Arc::default(),
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

    /// Refuses that a tenant stores so many bytes more.
    pub(crate) fn has_room_for(&self, tenant: &str, bytes: u64) -> Result<(), Refusal> {
        let most = self.quotas_of(tenant).tenant_bytes;
        if most == 0 {
            return Ok(());
        }
        let (usage, files) = (self.ledger.usage(tenant)?, self.blobs.of(tenant).bytes()?);
        let growing = lock(&self.shares.growing).get(tenant).copied().unwrap_or(0);
        let all = [usage.bytes, usage.machines, files, growing, bytes].into_iter().fold(0, u64::saturating_add);
        if all <= most {
            return Ok(());
        }
        if bytes > most {
            let text = format!("{bytes} bytes are more than the whole quota: ask the administrator to raise it");
            return Err(Refusal::quota(tenant, "tenant_bytes", most, text));
        }
        let text = format!(
            "{} bytes of ended jobs, {} of machines, {files} of files and {growing} of uploads and answers in progress \
             are stored: delete ended jobs (DeleteJob) or machines (DeleteMachine), or cancel jobs with long answers; \
             files that nothing needs are removed after blob_grace_s",
            usage.bytes, usage.machines
        );
        Err(Refusal::quota(tenant, "tenant_bytes", most, text))
    }

    /// The bytes of an upload of a tenant, or of the answers to one of its jobs.
    pub(crate) fn growing(&self, tenant: &str) -> Growing {
        Growing::new(self.shares.growing.clone(), tenant)
    }

    /// The bytes of an upload whose content the tenant already has.
    pub(crate) fn not_growing(&self, tenant: &str) -> Growing {
        self.growing(tenant).stored()
    }

    /// Counts bytes that an upload or an answer is about to store, or refuses them.
    pub(crate) fn grow(&self, upload: &mut Growing, bytes: u64) -> Result<(), Refusal> {
        let Some(tenant) = upload.counted_for() else { return Ok(()) };
        self.has_room_for(tenant, bytes)?;
        upload.add(bytes);
        Ok(())
    }

    /// Refuses new work of a tenant that has reached a quota.
    pub(crate) fn within_quotas(&self, tenant: &str) -> Result<(), Refusal> {
        let quotas = self.quotas_of(tenant);
        if quotas.tenant_bytes == 0 && quotas.tenant_cpu_s == 0 {
            return Ok(());
        }
        self.has_room_for(tenant, 1)?;
        if quotas.tenant_cpu_s == 0 {
            return Ok(());
        }
        let usage = self.ledger.usage(tenant)?;
        let seconds = usage.cpu_us_on(day(now_ms())) / 1_000_000;
        if seconds >= quotas.tenant_cpu_s {
            let text = format!(
                "the jobs that ended today have taken {seconds} s of processor time: submit again after midnight UTC"
            );
            return Err(Refusal::quota(tenant, "tenant_cpu_s", quotas.tenant_cpu_s, text));
        }
        Ok(())
    }
}
