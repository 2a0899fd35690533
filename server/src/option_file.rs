//! Files that options name.
//!
//! *Invariant:* every error names the file and its option; if access is denied, also the user that needs it.

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

    /// The content of the file.
    pub(crate) fn read(&self) -> Result<Vec<u8>, String> {
        std::fs::read(self.path).map_err(|error| match error.kind() {
            io::ErrorKind::PermissionDenied => self.wrong(format_args!("{error}; {}", remedy())),
            _ => self.wrong(error),
        })
    }

    /// An error about the file.
    pub(crate) fn wrong(&self, error: impl Display) -> String {
        format!("'{}' (option {}): {error}", self.path.display(), self.option)
    }
}

/// Names the user that must be able to read the file.
#[cfg(unix)]
fn remedy() -> String {
    let user = rustix::process::geteuid();
    format!("the user of the server (uid {user}) must be able to read the file and enter its folder")
}

/// Names the user that must be able to read the file.
#[cfg(not(unix))]
fn remedy() -> String {
    "the user of the server must be able to read the file".to_owned()
}
