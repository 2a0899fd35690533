//! Locks of records.

use std::sync::Mutex;

/// Ignores the panic of an earlier holder: records are always replaced as a whole.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
