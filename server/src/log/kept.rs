//! Where the log of a job is: in its file, or in the ledger if it is small.
//!
//! Invariant: both hold the same bytes, from the head on.

use std::fmt::Debug;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek};
use std::path::PathBuf;

use bytes::Bytes;

/// A log to be read.
#[derive(Debug, Clone)]
pub(crate) enum Kept {
    File(PathBuf),
    Ledger(Bytes),
}

/// What a log is read from.
pub(crate) trait Input: Read + Seek + Send + Debug {}

impl<T: Read + Seek + Send + Debug> Input for T {}

impl Kept {
    pub(crate) fn open(&self) -> io::Result<Box<dyn Input>> {
        Ok(match self {
            Self::File(path) => Box::new(File::open(path)?),
            Self::Ledger(bytes) => Box::new(Cursor::new(bytes.clone())),
        })
    }

    /// Its length in bytes.
    pub(crate) fn length(&self) -> u64 {
        match self {
            Self::File(path) => std::fs::metadata(path).map_or(0, |meta| meta.len()),
            Self::Ledger(bytes) => bytes.len() as u64,
        }
    }
}
