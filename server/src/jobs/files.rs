//! A job's sandbox: its files by path, read from the blobs.
//!
//! The reason why a file could not be read is kept: it is not a fault of the program. Invariant: a path that is not in
//! the job's list does not exist, regardless of the data folder.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use counterpoint_kernel::files::{FileError, JobFiles};

use crate::blobs::Blobs;
use crate::reason::Refusal;

/// The files of one job.
#[derive(Debug)]
pub(crate) struct JobSandbox {
    blobs: Arc<dyn Blobs>,
    files: BTreeMap<String, String>,
    trouble: OnceLock<Refusal>,
}

impl JobSandbox {
    pub(crate) fn new(blobs: Arc<dyn Blobs>, files: Vec<(String, String)>) -> Self {
        Self { blobs, files: files.into_iter().collect(), trouble: OnceLock::new() }
    }

    /// Why a file of the job could not be read, if one could not.
    pub(crate) fn trouble(&self) -> Result<(), Refusal> {
        self.trouble.get().map_or(Ok(()), |trouble| Err(trouble.clone()))
    }
}

impl JobFiles for JobSandbox {
    fn read(&self, path: &str) -> Result<Bytes, FileError> {
        let digest = self.files.get(path).ok_or_else(|| FileError::Missing(path.to_owned()))?;
        self.blobs.read(digest).map_err(|error| {
            let reason = error.to_string();
            let _ = self.trouble.set(error.into());
            FileError::Unreadable { name: path.to_owned(), reason }
        })
    }

    fn list(&self) -> Vec<String> {
        self.files.keys().cloned().collect()
    }
}
