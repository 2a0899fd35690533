//! Errors of the host that name their file and the remedy.
//!
//! *Invariant:* the kind of the error is kept, and an error with its own text is not changed.

use std::io::{self, ErrorKind};
use std::path::Path;

/// The remedy for a place that cannot be used; `None` for other errors.
fn remedy(kind: ErrorKind) -> Option<&'static str> {
    match kind {
        ErrorKind::PermissionDenied => Some("run the command as the user that owns the data folder"),
        ErrorKind::ReadOnlyFilesystem => Some("mount its file system for writing, or choose another folder (--data)"),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Some("make room on its disk and start again"),
        _ => None,
    }
}

/// Whether an error says that the host refuses a place, whatever the place holds.
pub(crate) fn is_of_host(error: &io::Error) -> bool {
    remedy(error.kind()).is_some()
}

/// Adds the file and the remedy to an error of the system.
pub(crate) fn named(path: &Path, error: io::Error) -> io::Error {
    if error.get_ref().is_some() {
        return error;
    }
    let remedy = remedy(error.kind()).map_or(String::new(), |remedy| format!(": {remedy}"));
    io::Error::new(error.kind(), format!("'{}': {error}{remedy}", path.display()))
}

/// Results of the system.
pub(crate) trait PathContext<T> {
    /// Has an error name its file and the remedy.
    fn at(self, path: &Path) -> io::Result<T>;
}

impl<T> PathContext<T> for io::Result<T> {
    fn at(self, path: &Path) -> io::Result<T> {
        self.map_err(|error| named(path, error))
    }
}

/// Whether a file or folder can be written by the user of this process.
///
/// # Errors
/// When it cannot; one that is not there can.
pub(crate) fn can_be_written(path: &Path) -> io::Result<()> {
    #[cfg(unix)]
    match rustix::fs::access(path, rustix::fs::Access::WRITE_OK).map_err(io::Error::from) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(named(path, error)),
        _ => Ok(()),
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_its_file_and_the_remedy_once() {
        let full = named(Path::new("/data/x"), ErrorKind::StorageFull.into());
        assert_eq!(full.to_string(), "'/data/x': no storage space: make room on its disk and start again");
        assert!(is_of_host(&full));
        assert_eq!(named(Path::new("/data"), full).to_string().matches('/').count(), 2);
        let other = named(Path::new("a"), ErrorKind::UnexpectedEof.into());
        assert!(!is_of_host(&other) && other.to_string().starts_with("'a': "), "{other}");
    }
}
