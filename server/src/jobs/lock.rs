//! Locks of records.

use std::sync::Mutex;

/// A lock whose holder panicked is used as it is: records are replaced whole.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
