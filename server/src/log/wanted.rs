//! Whether results are still wanted that are stored while their job ends.
//!
//! *Invariant:* after [`ResultGate::end`] nothing more is stored, so the folder of a deleted job is not created again.

use std::io;
use std::sync::{Mutex, PoisonError};

/// Shared by the run of a job and the thread that stores its results.
#[derive(Debug)]
pub(crate) struct ResultGate(Mutex<bool>);

impl Default for ResultGate {
    fn default() -> Self {
        Self(Mutex::new(true))
    }
}

impl ResultGate {
    /// Stops storing results. Waits while a file gets its name.
    pub(crate) fn end(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = false;
    }

    /// Gives a finished file its name.
    ///
    /// # Errors
    /// `Interrupted` if the file is no longer wanted, and the errors of `store`.
    pub(crate) fn store(&self, store: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
        let wanted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if *wanted { store() } else { Err(io::ErrorKind::Interrupted.into()) }
    }
}
