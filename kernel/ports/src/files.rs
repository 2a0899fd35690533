//! The files a job may read. The kernel knows no file system: the caller of a job passes this view of it.

pub use bytes::Bytes;

/// Why a file could not be had.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// No such file in the job.
    #[error("no file '{0}' in the job")]
    Missing(String),
    /// It exists but cannot be read.
    #[error("cannot read '{name}': {reason}")]
    Unreadable {
        /// Path.
        name: String,
        /// The error of the system.
        reason: String,
    },
}

/// Read-only view of a job's files by relative path with `/` between parts.
pub trait JobFiles: Send + Sync {
    /// Whole content of a file; cheap to hand on.
    ///
    /// # Errors
    /// [`FileError`] when there is no such file or it cannot be read.
    fn read(&self, path: &str) -> Result<Bytes, FileError>;

    /// All paths, sorted.
    fn list(&self) -> Vec<String>;
}

/// Files held in memory.
#[derive(Debug, Clone, Default)]
pub struct MemoryFiles(pub std::collections::BTreeMap<String, Bytes>);

impl MemoryFiles {
    /// Adds or replaces a file.
    pub fn insert(&mut self, path: impl Into<String>, content: impl AsRef<[u8]>) {
        self.0.insert(path.into(), Bytes::copy_from_slice(content.as_ref()));
    }
}

impl JobFiles for MemoryFiles {
    fn read(&self, path: &str) -> Result<Bytes, FileError> {
        self.0.get(path).cloned().ok_or_else(|| FileError::Missing(path.to_owned()))
    }

    fn list(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}
