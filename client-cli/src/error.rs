//! Why a command failed, and its exit code.

use std::io::ErrorKind;

use tonic::{Code, Status};
use tonic_types::StatusExt as _;

/// A failed command.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// Bad usage, a bad file or a bad machine.
    #[error("{0}")]
    Usage(String),
    /// The server refused.
    #[error("{}", refusal(.0))]
    Refused(Box<Status>),
    /// The server cannot be reached, or the connection was lost.
    #[error("{0}")]
    Connection(String),
    /// A file cannot be read or written.
    #[error("{}", file_problem(.path, .error))]
    File {
        /// The file.
        path: String,
        /// Error of the operating system.
        error: std::io::Error,
    },
    /// Standard output was closed by its reader: not an error.
    #[error("closed")]
    Closed,
}

/// The error in a file, in words.
fn file_problem(path: &str, error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => format!("'{path}' does not exist"),
        ErrorKind::PermissionDenied => format!("'{path}': permission denied"),
        ErrorKind::IsADirectory => format!("'{path}' is a folder, not a file"),
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => format!("'{path}' is a file, not a folder"),
        _ => format!("'{path}': {error}"),
    }
}

fn refusal(status: &Status) -> String {
    match status.get_error_details().error_info() {
        Some(info) => format!("{} ({})", status.message(), info.reason),
        None => status.message().to_owned(),
    }
}

impl Error {
    /// Exit code.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Usage(_) | Self::File { .. } => 2,
            Self::Refused(status) => match status.code() {
                Code::InvalidArgument | Code::NotFound | Code::AlreadyExists | Code::FailedPrecondition => 2,
                _ => 3,
            },
            Self::Connection(_) => 3,
            Self::Closed => 0,
        }
    }

    /// An error of a file.
    pub(crate) fn file(path: impl AsRef<std::path::Path>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.as_ref().display().to_string();
        move |error| Self::File { path, error }
    }
}

impl From<Status> for Error {
    fn from(status: Status) -> Self {
        Self::Refused(Box::new(status))
    }
}

impl From<counterpoint_client::Error> for Error {
    fn from(error: counterpoint_client::Error) -> Self {
        use counterpoint_client::Error as Client;
        match error {
            Client::Settings(text) => Self::Usage(text),
            Client::Refused(status) => Self::Refused(status),
            Client::Unreachable { .. } | Client::Contract(_) => Self::Connection(error.to_string()),
        }
    }
}
