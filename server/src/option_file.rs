//! Files named by options.
//!
//! *Invariant:* every error names the file and its option. If access is denied, the error also names the user that
//! needs access.

use std::fmt::Display;
use std::io;
use std::path::Path;

/// A file and its option.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OptionFile<'a> {
    option: &'a str,
    path: &'a Path,
}

impl<'a> OptionFile<'a> {
    pub(crate) fn new(option: &'a str, path: &'a Path) -> Self {
        Self { option, path }
    }

    /// Reads the file. A pipe or a socket is refused: the read could wait indefinitely, and a second read finds nothing.
    pub(crate) fn read(&self) -> Result<Vec<u8>, String> {
        if std::fs::metadata(self.path).is_ok_and(|meta| is_pipe(meta.file_type())) {
            return Err(self.wrong("is not a regular file"));
        }
        std::fs::read(self.path).map_err(|error| match error.kind() {
            io::ErrorKind::PermissionDenied => self.wrong(format_args!("{error}; {}", remedy())),
            _ => self.wrong(error),
        })
    }

    /// An error message that names the file and its option.
    pub(crate) fn wrong(&self, error: impl Display) -> String {
        format!("'{}' (option {}): {error}", self.path.display(), self.option)
    }
}

#[cfg(unix)]
fn is_pipe(kind: std::fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    kind.is_fifo() || kind.is_socket()
}

#[cfg(not(unix))]
fn is_pipe(_kind: std::fs::FileType) -> bool {
    false
}

/// The remedy for denied access; it names the user that must be able to read the file.
#[cfg(unix)]
fn remedy() -> String {
    let user = rustix::process::geteuid();
    format!("the user of the server (uid {user}) must be able to read the file and enter its folder")
}

/// The remedy for denied access; it names the user that must be able to read the file.
#[cfg(not(unix))]
fn remedy() -> String {
    "the user of the server must be able to read the file".to_owned()
}
