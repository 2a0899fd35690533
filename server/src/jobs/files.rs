//! A job's sandbox: its files by path, read from the blobs.
//!
//! Invariant: a path that is not in the job's list does not exist, whatever lies in the data folder.

use std::collections::BTreeMap;

use bytes::Bytes;
use counterpoint_kernel::files::{Error, Files};

use crate::blobs::Blobs;

/// The files of one job.
#[derive(Debug)]
pub(crate) struct Sandbox {
    blobs: Blobs,
    files: BTreeMap<String, String>,
}

impl Sandbox {
    pub(crate) fn new(blobs: Blobs, files: &[(String, String)]) -> Self {
        Self { blobs, files: files.iter().cloned().collect() }
    }
}

impl Files for Sandbox {
    fn read(&self, path: &str) -> Result<Bytes, Error> {
        let digest = self.files.get(path).ok_or_else(|| Error::Missing(path.to_owned()))?;
        let unreadable = |error: std::io::Error| Error::Unreadable { name: path.to_owned(), reason: error.to_string() };
        self.blobs.read(digest).map_err(unreadable)
    }

    fn list(&self) -> Vec<String> {
        self.files.keys().cloned().collect()
    }
}
