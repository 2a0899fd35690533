//! Why a command failed, and its exit code.

use std::error::Error as _;
use std::ffi::OsStr;
use std::io::ErrorKind;
use std::time::Duration;

use counterpoint_client::Misfit;
use tonic::{Code, Status};
use tonic_types::StatusExt as _;

/// Environment variable with the token of the caller.
const TOKEN: &str = "COUNTERPOINT_TOKEN";

/// The quota of a tenant's waiting jobs, which has room again when one of them starts.
const WAITING_JOBS: &str = "tenant_queued";

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
    /// Results that the server refused: each file with its refusal. The other results were written.
    #[error("{}", not_written(.0))]
    NotWritten(Vec<(String, Error)>),
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

fn not_written(failed: &[(String, Error)]) -> String {
    let one = |(path, error): &(String, Error)| format!("'{path}' was not written: {error}");
    failed.iter().map(one).collect::<Vec<_>>().join("\n       ")
}

fn refusal(status: &Status) -> String {
    let text = match status.get_error_details().error_info() {
        Some(info) => format!("{} ({})", status.message(), info.reason),
        None => status.message().to_owned(),
    };
    match status.code() {
        Code::Unauthenticated => format!("{text}: {}", token(std::env::var_os(TOKEN).as_deref())),
        _ => text,
    }
}

/// The remedy for a refused token.
fn token(given: Option<&OsStr>) -> &'static str {
    match given {
        Some(token) if !token.is_empty() => "the token came from COUNTERPOINT_TOKEN",
        _ => "set COUNTERPOINT_TOKEN to a token for this server",
    }
}

/// The error of a server that does not answer, with its remedy.
fn unreachable(error: &counterpoint_client::Error) -> String {
    match error.misfit() {
        Some(Misfit::Certificate) => format!(
            "{error}: check the address, that the certificate of the server is valid for it and signed by an \
             authority that COUNTERPOINT_CA names, and the client's own in COUNTERPOINT_CLIENT_CERT and \
             COUNTERPOINT_CLIENT_KEY"
        ),
        // The text of the error contains the remedy.
        Some(Misfit::Encrypted | Misfit::Unencrypted | Misfit::Authority) => error.to_string(),
        None => format!(
            "{error}: start one with `counterpointd`, or give its address with --server or in COUNTERPOINT_SERVER"
        ),
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
            Self::NotWritten(failed) => failed.iter().map(|(_, error)| error.code()).max().unwrap_or(3),
            Self::Closed => 0,
        }
    }

    /// The reason of a refusal as the contract lists it, for example `QUEUE_FULL`.
    pub(crate) fn reason(&self) -> Option<String> {
        match self {
            Self::Refused(status) => status.get_error_details().error_info().map(|info| info.reason.clone()),
            _ => None,
        }
    }

    /// Whether the server refused this field of the request.
    pub(crate) fn is_about(&self, field: &str) -> bool {
        let Self::Refused(status) = self else { return false };
        let details = status.get_error_details();
        details.bad_request().is_some_and(|bad| bad.field_violations.iter().any(|violation| violation.field == field))
    }

    /// The pause before a repetition, if the server will have room for the request when other jobs end.
    pub(crate) fn until_room(&self) -> Option<Duration> {
        const PASSING: [&str; 4] = ["QUEUE_FULL", "MEMORY_FULL", "TOO_MANY_UPLOADS", "RATE_LIMITED"];
        /// The pause if the server names none.
        const PAUSE: Duration = Duration::from_secs(1);
        let Self::Refused(status) = self else { return None };
        let details = status.get_error_details();
        let info = details.error_info()?;
        let waiting = || info.metadata.get("quota").is_some_and(|quota| quota == WAITING_JOBS);
        let passing = PASSING.contains(&info.reason.as_str()) || info.reason == "QUOTA_EXCEEDED" && waiting();
        let pause = details.retry_info().and_then(|info| info.retry_delay);
        passing.then(|| pause.unwrap_or(PAUSE))
    }

    /// Adds the job whose end a lost connection leaves unknown.
    pub(crate) fn of_job(self, job: &str) -> Self {
        match self {
            Self::Connection(text) => Self::Connection(format!("the end of job {job} is not known yet: {text}")),
            other => other,
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
        counterpoint_client::Error::from(status).into()
    }
}

impl From<counterpoint_client::Error> for Error {
    fn from(error: counterpoint_client::Error) -> Self {
        use counterpoint_client::Error as Client;
        match error {
            Client::Settings(text) => Self::Usage(text),
            // The client made this error, not the server.
            Client::Refused(ref status) if status.source().is_some() => Self::Connection(error.to_string()),
            Client::Refused(status) => Self::Refused(status),
            Client::Unreachable { .. } => Self::Connection(unreachable(&error)),
            Client::Contract(_) => Self::Connection(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_connection_names_address_job_and_remedy() {
        let (address, cause) = ("http://cell:7878".to_owned(), "Connection refused (os error 111)".to_owned());
        let lost = counterpoint_client::Error::Unreachable { address, cause };
        let text = Error::from(lost).of_job("01938f2c").to_string();
        assert!(text.starts_with("the end of job 01938f2c is not known yet: no server answers at http://cell:7878"));
        assert!(text.contains("Connection refused") && text.contains("COUNTERPOINT_SERVER"), "{text}");
        assert_eq!(Error::Usage("wrong".to_owned()).of_job("x").to_string(), "wrong");
    }

    #[test]
    fn a_certificate_that_is_refused_names_the_variables_of_certificates() {
        let (address, cause) = ("https://cell:7878".to_owned(), "received fatal alert: CertificateRequired".to_owned());
        let text = Error::from(counterpoint_client::Error::Unreachable { address, cause }).to_string();
        assert!(text.contains("COUNTERPOINT_CLIENT_CERT") && !text.contains("COUNTERPOINT_SERVER"), "{text}");
    }
}
