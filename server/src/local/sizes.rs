//! Bytes of the blobs of each tenant: counted when they are first asked for, then with every blob that comes or goes.
//!
//! *Invariant:* no blob comes or goes while those of a tenant are counted, and one blob comes or goes at a time, so
//! none counts twice and none is left out.

use std::collections::HashMap;
use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard};

/// Locks of blobs; blobs with the same lock wait for each other.
const LOCKS: usize = 64;

/// The bytes by tenant.
#[derive(Debug)]
pub(super) struct Sizes {
    /// Held by those who put a blob in its place or take it away; alone by the one who counts.
    changing: RwLock<()>,
    /// Held with it for one blob.
    each: [Mutex<()>; LOCKS],
    counted: Mutex<HashMap<String, u64>>,
}

impl Default for Sizes {
    fn default() -> Self {
        Self { changing: RwLock::default(), each: std::array::from_fn(|_| Mutex::default()), counted: Mutex::default() }
    }
}

impl Sizes {
    fn counted(&self) -> MutexGuard<'_, HashMap<String, u64>> {
        self.counted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The right to change a blob, of all blobs with its digest.
    fn hold(&self, digest: &str) -> (RwLockReadGuard<'_, ()>, Option<MutexGuard<'_, ()>>) {
        let changing = self.changing.read().unwrap_or_else(PoisonError::into_inner);
        let number = crc32fast::hash(digest.as_bytes()) as usize % LOCKS;
        let each = self.each.get(number).map(|lock| lock.lock().unwrap_or_else(PoisonError::into_inner));
        (changing, each)
    }

    /// Bytes of a tenant; `count` tells them the first time.
    pub(super) fn of(&self, tenant: &str, count: impl FnOnce() -> io::Result<u64>) -> io::Result<u64> {
        if let Some(bytes) = self.counted().get(tenant) {
            return Ok(*bytes);
        }
        let _alone = self.changing.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(bytes) = self.counted().get(tenant) {
            return Ok(*bytes);
        }
        let bytes = count()?;
        self.counted().insert(tenant.to_owned(), bytes);
        Ok(bytes)
    }

    /// Puts a blob in its place; `place` returns its bytes if it was not there.
    pub(super) fn place<E>(
        &self,
        tenant: &str,
        digest: &str,
        place: impl FnOnce() -> Result<Option<u64>, E>,
    ) -> Result<(), E> {
        let _held = self.hold(digest);
        if let Some(bytes) = place()?
            && let Some(counted) = self.counted().get_mut(tenant)
        {
            *counted = counted.saturating_add(bytes);
        }
        Ok(())
    }

    /// Takes a blob away; `take` returns its bytes if it has gone.
    pub(super) fn take(&self, tenant: &str, digest: &str, take: impl FnOnce() -> Option<u64>) -> bool {
        let _held = self.hold(digest);
        let gone = take();
        if let (Some(bytes), Some(counted)) = (gone, self.counted().get_mut(tenant)) {
            *counted = counted.saturating_sub(bytes);
        }
        gone.is_some()
    }
}
