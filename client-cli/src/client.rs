//! A connection to a remote server, or to one embedded in this process.
//!
//! *Invariant:* an embedded server leaves nothing behind: its data folder is temporary and removed with the client.

use std::time::Duration;

use bytes::Bytes;
use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_proto::v1::machines_client::MachinesClient;
use counterpoint_proto::v1::operator_client::OperatorClient;
use counterpoint_proto::v1::results_client::ResultsClient;
use counterpoint_server::options::{Options, System};
use counterpoint_server::service;
use tonic::metadata::{Ascii, MetadataValue};
use tonic::service::Interceptor;
use tonic::service::interceptor::InterceptedService;
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Identity};
use tonic::{Request, Status};

use crate::error::Error;
use crate::pack::Blob;

/// Names in the environment: token, authorities, and certificate and key of the client, the last three PEM files.
const TOKEN: &str = "COUNTERPOINT_TOKEN";
const CA: &str = "COUNTERPOINT_CA";
const CERTIFICATE: &str = "COUNTERPOINT_CLIENT_CERT";
const KEY: &str = "COUNTERPOINT_CLIENT_KEY";
/// Bytes of an upload chunk.
const CHUNK: usize = 64 * 1024;
/// Digests in one request, so that the message stays small.
const ASK: usize = 10_000;

/// A connection that adds the token of the caller to each call.
type Through = InterceptedService<Channel, Bearer>;

/// The token of the caller, if it has one.
#[derive(Debug, Clone)]
pub(crate) struct Bearer(Option<MetadataValue<Ascii>>);

impl Bearer {
    /// Reads the token from the environment, because every user of the computer can read command lines.
    fn from_environment() -> Result<Self, Error> {
        let Ok(token) = std::env::var(TOKEN) else { return Ok(Self(None)) };
        let value = format!("Bearer {}", token.trim()).parse::<MetadataValue<Ascii>>();
        let mut value = value.map_err(|_| Error::Usage(format!("{TOKEN} is not a token")))?;
        value.set_sensitive(true);
        Ok(Self(Some(value)))
    }
}

impl Interceptor for Bearer {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(token) = &self.0 {
            request.metadata_mut().insert("authorization", token.clone());
        }
        Ok(request)
    }
}

/// Certificates of the authorities that the server's is checked with, and the client's own.
fn tls() -> Result<ClientTlsConfig, Error> {
    let file = |name: &str| {
        let path = std::env::var_os(name);
        let read = |path| std::fs::read(&path).map_err(Error::file(path));
        path.map(|path| read(std::path::PathBuf::from(path))).transpose()
    };
    let mut config = match file(CA)? {
        Some(authorities) => ClientTlsConfig::new().ca_certificate(Certificate::from_pem(authorities)),
        None => ClientTlsConfig::new().with_native_roots(),
    };
    if let (Some(certificate), Some(key)) = (file(CERTIFICATE)?, file(KEY)?) {
        config = config.identity(Identity::from_pem(certificate, key));
    }
    Ok(config)
}

fn cause(error: &dyn std::error::Error) -> String {
    let mut cause = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    cause.to_string()
}

/// A client.
#[derive(Debug)]
pub(crate) struct Client {
    channel: Through,
    embedded: bool,
    _data: Option<tempfile::TempDir>,
}

impl Client {
    /// Connects to a server.
    pub(crate) async fn connect(address: &str) -> Result<Self, Error> {
        let scheme = address.split_once("://").map_or("", |(scheme, _)| scheme).to_ascii_lowercase();
        if scheme != "http" && scheme != "https" {
            return Err(Error::Usage(format!(
                "server address '{address}' is not an http address: expected http://HOST:PORT or https://HOST:PORT"
            )));
        }
        let bearer = Bearer::from_environment()?;
        let mut endpoint = Endpoint::from_shared(address.to_owned())
            .map_err(|error| Error::Usage(format!("server address '{address}': {error}")))?
            .connect_timeout(Duration::from_secs(5))
            .tcp_nodelay(true)
            .http2_keep_alive_interval(Duration::from_secs(30))
            .keep_alive_timeout(Duration::from_secs(10))
            .initial_stream_window_size(1 << 20)
            .initial_connection_window_size(4 << 20);
        if scheme == "https" {
            endpoint = endpoint
                .tls_config(tls()?)
                .map_err(|error| Error::Usage(format!("certificates for '{address}': {}", cause(&error))))?;
        }
        let channel = endpoint.connect().await.map_err(|error| {
            let cause = cause(&error);
            Error::Connection(format!(
                "no server answers at {address} ({cause}): start one with `counterpointd`, or give its address with \
                 --server or in COUNTERPOINT_SERVER"
            ))
        })?;
        Ok(Self { channel: InterceptedService::new(channel, bearer), embedded: false, _data: None })
    }

    /// Starts a server in this process and connects to it over loopback; `allow_system`: macros may start commands.
    pub(crate) async fn embed(log: bool, allow_system: bool) -> Result<Self, Error> {
        let data = tempfile::Builder::new().prefix("counterpoint-").tempdir();
        let data = data.map_err(Error::file(std::env::temp_dir()))?;
        let own = Options::ephemeral(data.path().to_owned());
        let options = Options { log, system: System { allow_system, ..System::default() }, ..own };
        let service = service::build(options).await.map_err(|error| Error::Connection(error.to_string()))?;
        let address = format!("http://{}", service.handle().address());
        // Ends with the runtime, when the command ends.
        tokio::spawn(service.run(std::future::pending()));
        let client = Self::connect(&address).await?;
        Ok(Self { embedded: true, _data: Some(data), ..client })
    }

    /// A server at an address, or one in this process.
    pub(crate) async fn at(address: Option<&str>) -> Result<Self, Error> {
        match address {
            Some(address) => Self::connect(address).await,
            None => Self::embed(false, false).await,
        }
    }

    /// The server is in this process and knows the machines built in.
    pub(crate) fn is_embedded(&self) -> bool {
        self.embedded
    }

    pub(crate) fn jobs(&self) -> JobsClient<Through> {
        JobsClient::new(self.channel.clone()).max_decoding_message_size(service::MAX_MESSAGE)
    }

    pub(crate) fn machines(&self) -> MachinesClient<Through> {
        MachinesClient::new(self.channel.clone()).max_decoding_message_size(service::MAX_MESSAGE)
    }

    pub(crate) fn operator(&self) -> OperatorClient<Through> {
        OperatorClient::new(self.channel.clone()).max_decoding_message_size(service::MAX_MESSAGE)
    }

    pub(crate) fn results(&self) -> ResultsClient<Through> {
        ResultsClient::new(self.channel.clone()).max_decoding_message_size(service::MAX_MESSAGE)
    }

    fn blobs(&self) -> BlobsClient<Through> {
        BlobsClient::new(self.channel.clone())
    }

    /// Uploads the blobs that the server does not have.
    pub(crate) async fn upload(&self, blobs: &[&Blob]) -> Result<(), Error> {
        let mut missing: Vec<&&Blob> = Vec::new();
        for part in blobs.chunks(ASK) {
            if self.embedded {
                missing.extend(part);
                continue;
            }
            let digests = part.iter().map(|blob| blob.digest.clone()).collect();
            let answer = self.blobs().find_missing(v1::FindMissingRequest { digests }).await?.into_inner().digests;
            missing.extend(part.iter().filter(|blob| answer.contains(&blob.digest)));
        }
        missing.sort_by(|a, b| a.digest.cmp(&b.digest));
        missing.dedup_by(|a, b| a.digest == b.digest);
        for blob in missing {
            self.blobs().upload(tokio_stream::iter(chunks(blob))).await?;
        }
        Ok(())
    }
}

/// Splits a blob into chunks. The first chunk carries the digest; empty content is one chunk.
fn chunks(blob: &Blob) -> impl Iterator<Item = v1::UploadRequest> + Send + use<> {
    let mut rest = blob.content.clone();
    let mut digest = Some(blob.digest.clone());
    let size = rest.len() as u64;
    std::iter::from_fn(move || {
        if rest.is_empty() && digest.is_none() {
            return None;
        }
        let data: Bytes = rest.split_to(rest.len().min(CHUNK));
        let size = digest.is_some().then_some(size);
        Some(v1::UploadRequest { digest: digest.take().unwrap_or_default(), data, size })
    })
}
