//! A channel whose failures name the address of the server.
//!
//! *Invariant:* a status sent by a server is passed on unchanged.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::{BoxFuture, Service, http};
use tonic::transport::{Channel, Error as TransportError};

/// The first cause of an error.
pub(crate) fn cause(error: &dyn std::error::Error) -> String {
    let mut cause = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    cause.to_string()
}

/// A failed connection, as the source of the status of a call.
#[derive(Debug, thiserror::Error)]
#[error("{} {address} ({cause})", Misfit::failure(.address, .cause))]
pub(crate) struct ConnectFailure {
    pub(crate) address: String,
    pub(crate) cause: String,
}

/// A channel that knows the address of its server.
#[derive(Debug, Clone)]
pub struct AddressedChannel {
    channel: Channel,
    address: Arc<str>,
    /// Whether a call has been answered.
    answered: Arc<AtomicBool>,
}

impl AddressedChannel {
    pub(crate) fn new(channel: Channel, address: &str) -> Self {
        Self { channel, address: address.into(), answered: Arc::default() }
    }
}

/// Cause of a failed connection without encryption to a server that encrypts.
const TLS_ALERT: &str = "answered with an alert of TLS";
/// Time for the answer to a connection without encryption.
const PROBE: Duration = Duration::from_secs(2);

/// The first byte that a server sends to a client without encryption.
async fn first_byte(address: &str) -> io::Result<u8> {
    let address: http::Uri = address.parse().map_err(io::Error::other)?;
    let host = address.host().unwrap_or_default().trim_matches(['[', ']']);
    let mut stream = TcpStream::connect((host, address.port_u16().unwrap_or(80))).await?;
    stream.write_all(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n").await?;
    stream.read_u8().await
}

/// Whether the server at an address without `https` encrypts its connections: its first message is then an alert.
async fn encrypts(address: &str) -> bool {
    const ALERT: u8 = 21;
    !is_https(address) && matches!(tokio::time::timeout(PROBE, first_byte(address)).await, Ok(Ok(ALERT)))
}

fn is_https(address: &str) -> bool {
    address.get(..6).is_some_and(|scheme| scheme.eq_ignore_ascii_case("https:"))
}

/// The status of a call that got no answer.
fn unreached(address: &str, cause: String, error: TransportError) -> Status {
    let unreached = ConnectFailure { address: address.to_owned(), cause };
    let code = Status::from_error(Box::new(error)).code();
    let mut status = Status::new(code, unreached.to_string());
    status.set_source(Arc::new(unreached));
    status
}

impl Service<http::Request<Body>> for AddressedChannel {
    type Response = http::Response<Body>;
    type Error = Status;
    type Future = BoxFuture<Self::Response, Status>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Status>> {
        self.channel.poll_ready(context).map_err(|error| unreached(&self.address, cause(&error), error))
    }

    fn call(&mut self, request: http::Request<Body>) -> Self::Future {
        let (call, address, answered) = (self.channel.call(request), self.address.clone(), self.answered.clone());
        Box::pin(async move {
            let error = match call.await {
                Ok(answer) => {
                    answered.store(true, Ordering::Relaxed);
                    return Ok(answer);
                }
                Err(error) => error,
            };
            // The error alone does not show the cause: how the connection breaks depends on the time of the alert.
            let alert = !answered.load(Ordering::Relaxed) && encrypts(&address).await;
            Err(unreached(&address, if alert { TLS_ALERT.to_owned() } else { cause(&error) }, error))
        })
    }
}

/// A setting that does not fit the server, derived from the cause of a failed connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misfit {
    /// The address has `http`, and the server encrypts its connections.
    Encrypted,
    /// The address has `https`, and the server does not encrypt its connections.
    Unencrypted,
    /// The certificate of the server is that of an authority, which clients do not accept for a server.
    Authority,
    /// One side does not accept the certificate of the other side, or the client has none.
    Certificate,
}

impl Misfit {
    pub(crate) fn of(address: &str, cause: &str) -> Option<Self> {
        let lower = cause.to_ascii_lowercase();
        let says = |words: &[&str]| words.iter().any(|word| lower.contains(word));
        match is_https(address) {
            false if cause == TLS_ALERT => Some(Self::Encrypted),
            true if says(&["corrupt message", "invalidcontenttype"]) => Some(Self::Unencrypted),
            true if says(&["causedasendentity"]) => Some(Self::Authority),
            true if says(&["certificate", "issuer", "alert"]) => Some(Self::Certificate),
            _ => None,
        }
    }

    /// The remedy, as the end of a message.
    pub(crate) fn hint(address: &str, cause: &str) -> &'static str {
        match Self::of(address, cause) {
            Some(Self::Encrypted) => ": it expects https://",
            Some(Self::Unencrypted) => ": it expects http://",
            Some(Self::Authority) => {
                ": that is the certificate of an authority; make one for the server with the extension \
                 basicConstraints=CA:FALSE"
            }
            Some(Self::Certificate) | None => "",
        }
    }

    /// The failure, as the beginning of a message.
    pub(crate) fn failure(address: &str, cause: &str) -> &'static str {
        match Self::of(address, cause) {
            Some(Self::Authority) => "the certificate of the server cannot be used at",
            _ => "no server answers at",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_do_not_fit_are_told_from_servers_that_are_not_there() {
        let (http, https) = ("http://cell:7878", "HTTPS://cell:7878");
        for (address, cause, misfit) in [
            (http, TLS_ALERT, Misfit::Encrypted),
            (https, "received corrupt message of type InvalidContentType", Misfit::Unencrypted),
            (https, "invalid peer certificate: UnknownIssuer", Misfit::Certificate),
            (https, "invalid peer certificate: Other(OtherError(CaUsedAsEndEntity))", Misfit::Authority),
            (https, "received fatal alert: CertificateRequired", Misfit::Certificate),
        ] {
            assert_eq!(Misfit::of(address, cause), Some(misfit), "{cause}");
        }
        for cause in ["Connection refused (os error 111)", "failed to lookup address information", "tls handshake eof"]
        {
            assert_eq!((Misfit::of(http, cause), Misfit::of(https, cause)), (None, None), "{cause}");
        }
    }
}
