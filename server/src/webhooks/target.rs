//! A target: its address, its secret, and the jobs that it is notified about.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ring::hmac;
use rustls::pki_types::ServerName;
use rustls::{ClientConfig, RootCertStore};
use tokio_rustls::TlsConnector;

use super::endpoint::Endpoint;
use crate::certificates::{self, wrong};
use crate::ledger::record::{JobRecord, JobState};
use crate::option_file::OptionFile;
use crate::options::Webhook;
use crate::tenant;

/// Fewest bytes of a secret.
const LEAST_SECRET: usize = 16;
/// Start of a secret in the spelling of Standard Webhooks; the rest is base64.
const ENCODED: &str = "whsec_";
/// The states that end a job.
const ENDS: [(&str, JobState); 3] =
    [("SUCCEEDED", JobState::Succeeded), ("FAILED", JobState::Failed), ("CANCELLED", JobState::Cancelled)];

/// A target of messages.
pub(super) struct WebhookTarget {
    pub(super) name: String,
    pub(super) endpoint: Endpoint,
    /// Encrypts connections, with the name that the certificate must have.
    pub(super) tls: Option<(TlsConnector, ServerName<'static>)>,
    /// Messages that wait or are being sent.
    pub(super) waiting: AtomicUsize,
    /// Number of messages given up while the server stops.
    pub(super) left: AtomicUsize,
    secret: hmac::Key,
    /// Tenants; none = all.
    tenants: Option<Vec<String>>,
    states: Vec<JobState>,
}

impl std::fmt::Debug for WebhookTarget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("WebhookTarget")
            .field("name", &self.name)
            .field("endpoint", &self.endpoint)
            .finish_non_exhaustive()
    }
}

impl WebhookTarget {
    /// Reads the table of a target and its files.
    pub(super) fn new(name: &str, webhook: &Webhook, insecure: bool) -> Result<Self, String> {
        if !tenant::is_tenant(name) {
            return Err(format!("the name of a target has {}", tenant::RULE));
        }
        let endpoint = Endpoint::parse(&webhook.url, insecure)?;
        let all = webhook.tenants.iter().any(|tenant| tenant == "*");
        let wrong = webhook.tenants.iter().find(|tenant| *tenant != "*" && !tenant::is_tenant(tenant));
        match wrong {
            Some(wrong) => return Err(format!("tenants: '{wrong}' is not a tenant name ({}), nor *", tenant::RULE)),
            None if webhook.tenants.is_empty() => return Err("tenants is empty; * stands for all".to_owned()),
            None => {}
        }
        let mut states = Vec::new();
        for state in &webhook.states {
            match ENDS.iter().find(|(name, _)| name == state) {
                Some((_, state)) => states.push(*state),
                None => return Err(format!("states: '{state}' ends no job; expected SUCCEEDED, FAILED or CANCELLED")),
            }
        }
        let tls = match (endpoint.encrypted, webhook.ca_file.as_deref()) {
            (true, ca_file) => Some(connector(ca_file, &endpoint.host)?),
            (false, None) => None,
            (false, Some(_)) => return Err("ca_file is for https, and url is not encrypted".to_owned()),
        };
        Ok(Self {
            name: name.to_owned(),
            endpoint,
            tls,
            waiting: AtomicUsize::new(0),
            left: AtomicUsize::new(0),
            secret: secret(&webhook.secret_file)?,
            tenants: (!all).then(|| webhook.tenants.clone()),
            states,
        })
    }

    /// Whether the target is notified of the end of a job.
    pub(super) fn wants(&self, record: &JobRecord) -> bool {
        let of_tenant = self.tenants.as_ref().is_none_or(|tenants| tenants.contains(&record.tenant));
        of_tenant && record.state.ended() && (self.states.is_empty() || self.states.contains(&record.state))
    }

    /// Number of messages that were undelivered when the server stopped.
    pub(super) fn undelivered(&self) -> usize {
        self.waiting.load(Ordering::Relaxed) + self.left.load(Ordering::Relaxed)
    }

    /// The signature of a message: of its id, the time of sending in seconds, and its body.
    pub(super) fn signature(&self, id: &str, seconds: i64, body: &str) -> String {
        let tag = hmac::sign(&self.secret, format!("{id}.{seconds}.{body}").as_bytes());
        format!("v1,{}", STANDARD.encode(tag))
    }
}

/// Reads a secret: `whsec_` and base64, or any text of one line.
fn secret(path: &Path) -> Result<hmac::Key, String> {
    let shown = path.display();
    let content = OptionFile::new("secret_file", path).read()?;
    let text = String::from_utf8(content).map_err(|_| format!("secret_file '{shown}' is not text in UTF-8"))?;
    let text = text.trim();
    if text.contains(['\n', '\r']) {
        return Err(format!("secret_file '{shown}' has several lines; expected one"));
    }
    let bytes = match text.strip_prefix(ENCODED) {
        Some(encoded) => {
            STANDARD.decode(encoded).map_err(|error| format!("secret_file '{shown}': after {ENCODED}: {error}"))?
        }
        None => text.as_bytes().to_vec(),
    };
    if bytes.len() < LEAST_SECRET {
        return Err(format!("secret_file '{shown}' has {} bytes; expected {LEAST_SECRET} or more", bytes.len()));
    }
    Ok(hmac::Key::new(hmac::HMAC_SHA256, &bytes))
}

/// Encrypts connections to a host whose certificate comes from these authorities, otherwise from those of the system.
fn connector(ca_file: Option<&Path>, host: &str) -> Result<(TlsConnector, ServerName<'static>), String> {
    let mut roots = RootCertStore::empty();
    match ca_file {
        Some(path) => {
            for certificate in certificates::read(path).map_err(|error| format!("ca_file {error}"))? {
                roots.add(certificate).map_err(|error| format!("ca_file {}", wrong(path, error)))?;
            }
        }
        None => {
            let system = rustls_native_certs::load_native_certs();
            roots.add_parsable_certificates(system.certs);
        }
    }
    if roots.is_empty() {
        return Err("no certificates of authorities are known; name them in ca_file".to_owned());
    }
    let name = ServerName::try_from(host.to_owned()).map_err(|error| format!("url: '{host}': {error}"))?;
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(|error| error.to_string())?
        .with_root_certificates(roots)
        .with_no_client_auth();
    Ok((TlsConnector::from(Arc::new(config)), name))
}
