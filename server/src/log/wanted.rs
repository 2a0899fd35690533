//! Whether results that are stored beside the end of their job are still wanted.
//!
//! *Invariant:* after [`Wanted::end`] nothing more is stored, so the folder of a job that is deleted does not come back.

use std::io;
use std::sync::{Mutex, PoisonError};

/// Shared by the run of a job and the thread that stores its results.
#[derive(Debug)]
pub(crate) struct Wanted(Mutex<bool>);

impl Default for Wanted {
    fn default() -> Self {
        Self(Mutex::new(true))
    }
}

impl Wanted {
    /// Ends the storing of results. Waits while a file gets its name.
    pub(crate) fn end(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = false;
    }

    /// Gives a finished file its name.
    ///
    /// # Errors
    /// Of kind `Interrupted` if the file is not wanted any more, and those of `store`.
    pub(crate) fn store(&self, store: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
        let wanted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if *wanted { store() } else { Err(io::ErrorKind::Interrupted.into()) }
    }
}
