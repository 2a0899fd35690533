//! Why something could not be done.

use std::error::Error as _;
use std::time::Duration;

use tonic::{Code, Status};
use tonic_types::StatusExt as _;

use crate::reach::{ConnectFailure, Misfit};

/// Why something could not be done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Address, token or certificates cannot be used.
    #[error("{0}")]
    Settings(String),
    /// No server answers, at first or again within the patience of the client.
    #[error("{} {address} ({cause}){}", Misfit::failure(.address, .cause), Misfit::hint(.address, .cause))]
    Unreachable {
        /// The address.
        address: String,
        /// The error of the system.
        cause: String,
    },
    /// The server refused.
    #[error("{}", refusal(.0))]
    Refused(Box<Status>),
    /// The server did not keep to the contract.
    #[error("the server does not keep to the contract: {0}")]
    Contract(String),
}

fn refusal(status: &Status) -> String {
    if status.source().is_some() {
        return "the connection to the server was lost".to_owned();
    }
    match status.get_error_details().error_info() {
        Some(info) => format!("{} ({})", status.message(), info.reason),
        None => status.message().to_owned(),
    }
}

impl Error {
    /// The reason of a refusal as the contract lists it, for example `QUEUE_FULL`.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Refused(status) => status.get_error_details().error_info().map(|info| info.reason.clone()),
            _ => None,
        }
    }

    /// The setting that does not fit the server, if it is the reason why no server answers.
    #[must_use]
    pub fn misfit(&self) -> Option<Misfit> {
        match self {
            Self::Unreachable { address, cause } => Misfit::of(address, cause),
            _ => None,
        }
    }

    /// Whether the same call may succeed later without intervention: the connection was lost, or the server says
    /// UNAVAILABLE.
    #[must_use]
    pub fn is_passing(&self) -> bool {
        match self {
            Self::Unreachable { .. } => self.misfit().is_none(),
            Self::Refused(status) => status.code() == Code::Unavailable || is_lost(status),
            Self::Settings(_) | Self::Contract(_) => false,
        }
    }

    /// How long the server asks to wait.
    pub(crate) fn pause(&self) -> Option<Duration> {
        match self {
            Self::Refused(status) => status.get_error_details().retry_info().and_then(|info| info.retry_delay),
            _ => None,
        }
    }
}

/// Whether a status was made here because the connection broke; a server's has no cause that can be seen here.
fn is_lost(status: &Status) -> bool {
    status.source().is_some() || status.code() == Code::Unknown && status.get_error_details().error_info().is_none()
}

impl From<Status> for Error {
    fn from(status: Status) -> Self {
        match status.source().and_then(|source| source.downcast_ref::<ConnectFailure>()) {
            Some(ConnectFailure { address, cause }) => {
                Self::Unreachable { address: address.clone(), cause: cause.clone() }
            }
            None => Self::Refused(Box::new(status)),
        }
    }
}

#[cfg(test)]
mod tests {
    use tonic_types::{ErrorDetails, StatusExt as _};

    use super::*;

    #[test]
    fn lost_connections_pass_and_refusals_do_not() {
        let broken = std::io::Error::from(std::io::ErrorKind::ConnectionReset);
        let mut lost = Status::internal("h2 protocol error");
        lost.set_source(std::sync::Arc::new(broken));
        let lost = Error::from(lost);
        assert!(lost.is_passing());
        assert_eq!(lost.to_string(), "the connection to the server was lost");
        assert!(Error::from(Status::unavailable("the server goes down")).is_passing());
        let unreachable = Error::Unreachable { address: String::new(), cause: String::new() };
        assert!(unreachable.is_passing());
        let mut details = ErrorDetails::with_retry_info(Some(Duration::from_secs(3)));
        details.set_error_info("QUEUE_FULL", "counterpoint", std::collections::HashMap::new());
        let full = Error::from(Status::with_error_details(Code::ResourceExhausted, "the queue is full", details));
        assert!(!full.is_passing());
        assert_eq!((full.reason().as_deref(), full.pause()), (Some("QUEUE_FULL"), Some(Duration::from_secs(3))));
        assert_eq!(full.to_string(), "the queue is full (QUEUE_FULL)");
        assert!(!Error::from(Status::not_found("no such job")).is_passing());
    }
}
