//! Bytes that are being stored for a tenant.
//!
//! *Invariant:* added bytes count once, for their tenant, until the value is dropped.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use super::lock::lock;

/// Bytes of an upload in progress, or of the answers to a job that has not ended. They count until this value is
/// dropped.
#[derive(Debug)]
pub(crate) struct Growing {
    all: Arc<Mutex<BTreeMap<String, u64>>>,
    tenant: String,
    bytes: u64,
    /// The content is already stored, so its bytes do not count.
    stored: bool,
}

impl Growing {
    /// No bytes yet; `all` has the bytes of all tenants.
    pub(super) fn new(all: Arc<Mutex<BTreeMap<String, u64>>>, tenant: &str) -> Self {
        Self { all, tenant: tenant.to_owned(), bytes: 0, stored: false }
    }

    /// The same for content that is already stored.
    pub(super) fn stored(mut self) -> Self {
        self.stored = true;
        self
    }

    /// The tenant for which further bytes count; none if they do not count.
    pub(super) fn counted_for(&self) -> Option<&str> {
        (!self.stored).then_some(self.tenant.as_str())
    }

    /// The bytes that count.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Counts bytes that are stored already.
    pub(super) fn add(&mut self, bytes: u64) {
        self.bytes = self.bytes.saturating_add(bytes);
        let mut all = lock(&self.all);
        let of_tenant = all.entry(self.tenant.clone()).or_default();
        *of_tenant = of_tenant.saturating_add(bytes);
    }

    /// Subtracts bytes that were not stored after all.
    pub(crate) fn remove(&mut self, bytes: u64) {
        let bytes = bytes.min(self.bytes);
        self.bytes -= bytes;
        if let Some(of_tenant) = lock(&self.all).get_mut(&self.tenant) {
            *of_tenant = of_tenant.saturating_sub(bytes);
        }
    }
}

impl Drop for Growing {
    fn drop(&mut self) {
        let mut all = lock(&self.all);
        match all.get(&self.tenant).map_or(0, |bytes| bytes.saturating_sub(self.bytes)) {
            0 => drop(all.remove(&self.tenant)),
            left => drop(all.insert(self.tenant.clone(), left)),
        }
    }
}
