//! Where the log of a job is: in its file, plain or compressed, or in the ledger if it is small.
//!
//! Invariant: all of them read as the same bytes, from the head on; the plain file is the one to read while both are
//! there.

use std::fmt::Debug;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek};
use std::path::PathBuf;
use std::sync::Arc;

use bytes::Bytes;

use super::damage::of_job;
use super::segments::CompressedLog;

/// A log to be read, and its job.
#[derive(Debug, Clone)]
pub(crate) struct StoredLog {
    pub(crate) job: Arc<str>,
    place: LogLocation,
}

#[derive(Debug, Clone)]
enum LogLocation {
    Files(LogPaths),
    Ledger(Bytes),
}

/// Where the file of a log is.
#[derive(Debug, Clone)]
pub(crate) struct LogPaths {
    pub(crate) plain: PathBuf,
    pub(crate) segments: PathBuf,
}

/// Source from which a log is read.
pub(crate) trait Input: Read + Seek + Send + Debug {
    /// A place shortly before the first event after `after`, if one is known.
    fn place(&mut self, after: u64) -> io::Result<Option<u64>>;

    /// Gives back memory that the next read can have again.
    fn rest(&mut self) {}

    /// Reading takes no time.
    fn in_memory(&self) -> bool {
        false
    }
}

impl Input for File {
    fn place(&mut self, _after: u64) -> io::Result<Option<u64>> {
        Ok(None)
    }
}

impl Input for Cursor<Bytes> {
    fn place(&mut self, _after: u64) -> io::Result<Option<u64>> {
        Ok(None)
    }

    fn in_memory(&self) -> bool {
        true
    }
}

impl Input for CompressedLog {
    fn place(&mut self, after: u64) -> io::Result<Option<u64>> {
        self.place(after).map(Some)
    }

    fn rest(&mut self) {
        self.rest();
    }
}

impl LogPaths {
    /// Whether there is a log.
    pub(crate) fn there(&self) -> bool {
        self.plain.is_file() || self.segments.is_file()
    }

    fn open(&self) -> io::Result<Box<dyn Input>> {
        match File::open(&self.plain) {
            Ok(file) => Ok(Box::new(file)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Box::new(CompressedLog::open(&self.segments)?)),
            Err(error) => Err(error),
        }
    }

    fn length(&self) -> io::Result<u64> {
        match self.plain.metadata() {
            Ok(meta) => Ok(meta.len()),
            Err(_) => Ok(CompressedLog::open(&self.segments)?.length()),
        }
    }
}

impl StoredLog {
    /// A log in files.
    pub(crate) fn in_files(job: &str, files: LogPaths) -> Self {
        Self { job: job.into(), place: LogLocation::Files(files) }
    }

    /// A log in the ledger.
    pub(crate) fn in_ledger(job: &str, log: Bytes) -> Self {
        Self { job: job.into(), place: LogLocation::Ledger(log) }
    }

    pub(crate) fn is_in_files(&self) -> bool {
        matches!(self.place, LogLocation::Files(_))
    }

    /// Checks the bytes that no reader needs.
    ///
    /// # Errors
    /// When they are damaged, or cannot be read.
    pub(crate) fn check_beginning(&self) -> io::Result<()> {
        match &self.place {
            LogLocation::Files(files) if !files.plain.is_file() => {
                CompressedLog::open(&files.segments)?.check_beginning().map_err(|error| of_job(error, &self.job))
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn open(&self) -> io::Result<Box<dyn Input>> {
        match &self.place {
            LogLocation::Files(files) => files.open(),
            LogLocation::Ledger(bytes) => Ok(Box::new(Cursor::new(bytes.clone()))),
        }
    }

    /// Bytes of the plain log.
    ///
    /// # Errors
    /// When its file is damaged or cannot be read.
    pub(crate) fn length(&self) -> io::Result<u64> {
        match &self.place {
            LogLocation::Files(files) => files.length(),
            LogLocation::Ledger(bytes) => Ok(bytes.len() as u64),
        }
    }
}
