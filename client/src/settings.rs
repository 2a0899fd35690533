//! The address of the server and the identity of the caller.
//!
//! *Invariant:* a token is never shown, not even for debugging.

use std::io::ErrorKind;
use std::time::Duration;

use tonic::metadata::{Ascii, MetadataValue};
use tonic::service::Interceptor;
use tonic::transport::{Certificate, ClientTlsConfig, Endpoint, Identity};
use tonic::{Request, Status};

use crate::error::Error;
use crate::reach::cause;

/// Names in the environment: token, authorities, and certificate and key of the client, the last three PEM files; the
/// span that calls belong to.
const TOKEN: &str = "COUNTERPOINT_TOKEN";
const CA: &str = "COUNTERPOINT_CA";
const CERTIFICATE: &str = "COUNTERPOINT_CLIENT_CERT";
const KEY: &str = "COUNTERPOINT_CLIENT_KEY";
const TRACEPARENT: &str = "TRACEPARENT";

/// Receives the error that makes a client start to retry, and the client's patience.
pub type Notice = fn(&Error, Duration);

/// Where the server is and who calls.
#[derive(Clone)]
pub struct ClientSettings {
    address: String,
    /// The address was given without a scheme, so it is `https` if certificates are given.
    open_scheme: bool,
    call: CallMetadata,
    authorities: Option<Vec<u8>>,
    identity: Option<Identity>,
    patience: Duration,
    notice: Option<Notice>,
}

impl std::fmt::Debug for ClientSettings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ClientSettings").field("address", &self.address).finish_non_exhaustive()
    }
}

impl ClientSettings {
    /// A server at an address (`http://HOST:PORT`, `https://HOST:PORT` or `HOST:PORT`), without token and certificates.
    /// `HOST:PORT` is encrypted if authorities or a certificate are added.
    #[must_use]
    pub fn new(address: impl Into<String>) -> Self {
        let patience = Duration::from_secs(60);
        let given = address.into();
        let open_scheme = is_host_and_port(&given);
        Self {
            address: if open_scheme { format!("http://{given}") } else { given },
            open_scheme,
            call: CallMetadata::default(),
            authorities: None,
            identity: None,
            patience,
            notice: None,
        }
    }

    /// A server at an address, the rest from the environment: `COUNTERPOINT_TOKEN`, and the PEM files named by
    /// `COUNTERPOINT_CA`, `COUNTERPOINT_CLIENT_CERT` and `COUNTERPOINT_CLIENT_KEY`; `TRACEPARENT` is the W3C trace
    /// context that calls belong to. An empty variable counts as absent.
    ///
    /// # Errors
    /// When a file cannot be read, the token is not valid, or only one of certificate and key is given.
    pub fn from_environment(address: impl Into<String>) -> Result<Self, Error> {
        let file = |name: &str| {
            let path = std::env::var_os(name).filter(|path| !path.is_empty()).map(std::path::PathBuf::from);
            let read = |path: std::path::PathBuf| {
                std::fs::read(&path).map_err(|error| match error.kind() {
                    ErrorKind::NotFound => Error::Settings(format!("{name}: '{}' does not exist", path.display())),
                    _ => Error::Settings(format!("{name}: '{}': {error}", path.display())),
                })
            };
            path.map(read).transpose()
        };
        let mut settings = Self::new(address);
        let text = |name: &str| std::env::var(name).ok().filter(|text| !text.trim().is_empty());
        if let Some(token) = text(TOKEN) {
            settings = settings.with_token(&token).map_err(|_| Error::Settings(format!("{TOKEN} is not a token")))?;
        }
        if let Some(parent) = text(TRACEPARENT) {
            settings = settings.with_traceparent(&parent)?;
        }
        if let Some(authorities) = file(CA)? {
            settings = settings.with_authorities(&authorities);
        }
        match (file(CERTIFICATE)?, file(KEY)?) {
            (Some(certificate), Some(key)) => settings = settings.with_certificate(&certificate, &key),
            (Some(_), None) => return Err(alone(CERTIFICATE, KEY)),
            (None, Some(_)) => return Err(alone(KEY, CERTIFICATE)),
            (None, None) => {}
        }
        Ok(settings)
    }

    /// Sends a token with every call.
    ///
    /// # Errors
    /// When the text has characters that no token has.
    pub fn with_token(mut self, token: &str) -> Result<Self, Error> {
        let value = format!("Bearer {}", token.trim()).parse::<MetadataValue<Ascii>>();
        let mut value =
            value.map_err(|_| Error::Settings("the token has characters that cannot be sent".to_owned()))?;
        value.set_sensitive(true);
        self.call.token = Some(value);
        Ok(self)
    }

    /// Sends a W3C `traceparent` with every call: the server continues its trace.
    ///
    /// # Errors
    /// When the text has characters that cannot be sent.
    pub fn with_traceparent(mut self, parent: &str) -> Result<Self, Error> {
        let value = parent
            .trim()
            .parse()
            .map_err(|_| Error::Settings("the traceparent has characters that cannot be sent".to_owned()))?;
        self.call.traceparent = Some(value);
        Ok(self)
    }

    /// Checks the server's certificate with these authorities (PEM) instead of those of the system.
    #[must_use]
    pub fn with_authorities(mut self, pem: &[u8]) -> Self {
        self.authorities = Some(pem.to_vec());
        self.encrypted()
    }

    /// Adds `https` to an address that was given without a scheme.
    fn encrypted(mut self) -> Self {
        if std::mem::take(&mut self.open_scheme) {
            self.address = self.address.replacen("http://", "https://", 1);
        }
        self
    }

    /// Shows the server a certificate (PEM) with its key.
    #[must_use]
    pub fn with_certificate(mut self, certificate: &[u8], key: &[u8]) -> Self {
        self.identity = Some(Identity::from_pem(certificate, key));
        self.encrypted()
    }

    /// How long to continue trying when nothing succeeds; 60 s otherwise.
    #[must_use]
    pub fn with_patience(mut self, patience: Duration) -> Self {
        self.patience = patience;
        self
    }

    /// Calls this function when the client starts to retry after a failure.
    #[must_use]
    pub fn with_notice(mut self, notice: Notice) -> Self {
        self.notice = Some(notice);
        self
    }

    /// The address.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    pub(crate) fn patience(&self) -> Duration {
        self.patience
    }

    pub(crate) fn notice(&self) -> Option<Notice> {
        self.notice
    }

    pub(crate) fn call(&self) -> CallMetadata {
        self.call.clone()
    }

    pub(crate) fn endpoint(&self) -> Result<Endpoint, Error> {
        let address = &self.address;
        let scheme = address.split_once("://").map_or("", |(scheme, _)| scheme).to_ascii_lowercase();
        if scheme != "http" && scheme != "https" {
            return Err(Error::Settings(format!(
                "server address '{address}' is not an http address: expected HOST:PORT, http://HOST:PORT or \
                 https://HOST:PORT"
            )));
        }
        let endpoint = Endpoint::from_shared(address.clone())
            .map_err(|error| Error::Settings(format!("server address '{address}': {error}")))?
            .connect_timeout(Duration::from_secs(5))
            .tcp_nodelay(true)
            .http2_keep_alive_interval(Duration::from_secs(30))
            .keep_alive_timeout(Duration::from_secs(10))
            .initial_stream_window_size(1 << 20)
            .initial_connection_window_size(4 << 20);
        if scheme == "http" {
            return Ok(endpoint);
        }
        let mut tls = match &self.authorities {
            Some(authorities) => ClientTlsConfig::new().ca_certificate(Certificate::from_pem(authorities)),
            None => ClientTlsConfig::new().with_native_roots(),
        };
        if let Some(identity) = &self.identity {
            tls = tls.identity(identity.clone());
        }
        let unusable = |error| Error::Settings(format!("certificates for '{address}': {}", cause(&error)));
        endpoint.tls_config(tls).map_err(unusable)
    }
}

/// Whether an address has no scheme: `cell:7878`, `[::1]:7878`.
fn is_host_and_port(address: &str) -> bool {
    let Some((host, port)) = address.trim_end_matches('/').rsplit_once(':') else { return false };
    let inner = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    let is_host = inner.is_some_and(|host| host.contains(':')) || !host.contains([':', '[', ']']);
    !host.is_empty() && is_host && !host.contains(['/', '@']) && port.parse::<u16>().is_ok()
}

/// One of the two variables of the client's certificate is missing.
fn alone(given: &str, missing: &str) -> Error {
    Error::Settings(format!("{given} is set and {missing} is not: a client certificate needs both"))
}

/// The additions to each call.
#[derive(Debug, Clone, Default)]
pub struct CallMetadata {
    token: Option<MetadataValue<Ascii>>,
    traceparent: Option<MetadataValue<Ascii>>,
}

impl Interceptor for CallMetadata {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(token) = &self.token {
            request.metadata_mut().insert("authorization", token.clone());
        }
        if let Some(parent) = &self.traceparent {
            request.metadata_mut().insert("traceparent", parent.clone());
        }
        Ok(request)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_sent_and_never_shown() {
        let settings = ClientSettings::new("http://127.0.0.1:1").with_token(" cpt_secret\n").unwrap();
        let request = settings.call().call(Request::new(())).unwrap();
        assert_eq!(request.metadata().get("authorization").unwrap(), "Bearer cpt_secret");
        let shown = format!("{settings:?} {:?}", settings.call());
        assert!(!shown.contains("cpt_secret"), "{shown}");
        assert!(ClientSettings::new("http://127.0.0.1:1").with_token("a\nb").is_err());
    }

    #[test]
    fn only_http_addresses_are_taken() {
        for wrong in ["", "localhost", "::1:7878", "localhost:", ":7878", "ftp://localhost", "http://"] {
            assert!(matches!(ClientSettings::new(wrong).endpoint(), Err(Error::Settings(_))), "{wrong}");
        }
        assert!(ClientSettings::new("HTTP://localhost:7878").endpoint().is_ok());
        for (given, address) in [("localhost:7878", "http://localhost:7878"), ("[::1]:7878/", "http://[::1]:7878/")] {
            let settings = ClientSettings::new(given);
            assert!(settings.endpoint().is_ok() && settings.address() == address, "{settings:?}");
        }
    }
}
