//! Bytes of the blobs of each tenant: counted when they are first asked for, then with every blob that comes or goes.
//!
//! *Invariant:* no blob comes while those of a tenant are counted, so none counts twice and none is left out.

use std::collections::HashMap;
use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

/// The bytes by tenant.
#[derive(Debug, Default)]
pub(super) struct Sizes {
    /// Held by those who put a blob in its place; alone by the one who counts.
    placing: RwLock<()>,
    counted: Mutex<HashMap<String, u64>>,
}

impl Sizes {
    fn counted(&self) -> MutexGuard<'_, HashMap<String, u64>> {
        self.counted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes of a tenant; `count` tells them the first time.
    pub(super) fn of(&self, tenant: &str, count: impl FnOnce() -> io::Result<u64>) -> io::Result<u64> {
        if let Some(bytes) = self.counted().get(tenant) {
            return Ok(*bytes);
        }
        let _alone = self.placing.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(bytes) = self.counted().get(tenant) {
            return Ok(*bytes);
        }
        let bytes = count()?;
        self.counted().insert(tenant.to_owned(), bytes);
        Ok(bytes)
    }

    /// Puts a blob of so many bytes in its place; `place` tells whether it is new there.
    pub(super) fn place<E>(&self, tenant: &str, bytes: u64, place: impl FnOnce() -> Result<bool, E>) -> Result<(), E> {
        let _shared = self.placing.read().unwrap_or_else(PoisonError::into_inner);
        if place()?
            && let Some(counted) = self.counted().get_mut(tenant)
        {
            *counted = counted.saturating_add(bytes);
        }
        Ok(())
    }

    /// A blob of so many bytes has gone.
    pub(super) fn gone(&self, tenant: &str, bytes: u64) {
        if let Some(counted) = self.counted().get_mut(tenant) {
            *counted = counted.saturating_sub(bytes);
        }
    }
}
