//! Encrypted connections and client certificates.

use std::path::Path;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_server::access::Role;
use counterpoint_server::options::ServerOptions;
use counterpoint_server::service::{self, Handle};
use rcgen::{BasicConstraints, CertificateParams, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tonic::transport::{Certificate, Channel, ClientTlsConfig, Endpoint, Identity};

use crate::guarded::*;
use crate::support::*;

/// An authority.
pub struct Authority {
    pub pem: String,
    issuer: Issuer<'static, KeyPair>,
}

impl Authority {
    pub fn new() -> Self {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec![]).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let pem = params.self_signed(&key).unwrap().pem();
        Self { pem, issuer: Issuer::new(params, key) }
    }

    /// Certificate and key for a name.
    pub fn certify(&self, name: &str, usage: ExtendedKeyUsagePurpose) -> (String, String) {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec![name.to_owned()]).unwrap();
        params.extended_key_usages = vec![usage];
        (params.signed_by(&key, &self.issuer).unwrap().pem(), key.serialize_pem())
    }

    /// Writes a certificate for a server on this machine.
    pub fn serve(&self, folder: &Path) {
        let (certificate, key) = self.certify("localhost", ExtendedKeyUsagePurpose::ServerAuth);
        std::fs::write(folder.join("cert.pem"), certificate).unwrap();
        std::fs::write(folder.join("key.pem"), key).unwrap();
    }
}

async fn start(options: ServerOptions) -> (Handle, tokio::task::JoinHandle<()>) {
    let service = service::build_with(options, Script::default()).await.unwrap();
    let handle = service.handle();
    (handle, tokio::spawn(async { service.run(std::future::pending()).await.unwrap() }))
}

async fn stop(server: (Handle, tokio::task::JoinHandle<()>)) {
    server.0.stop();
    tokio::time::timeout(Duration::from_secs(10), server.1).await.expect("stops in time").unwrap();
}

async fn connect(handle: &Handle, config: ClientTlsConfig) -> Result<Channel, tonic::transport::Error> {
    let endpoint = Endpoint::from_shared(handle.url()).unwrap();
    endpoint.tls_config(config.domain_name("localhost")).unwrap().connect().await
}

fn trusting(authority: &Authority) -> ClientTlsConfig {
    ClientTlsConfig::new().ca_certificate(Certificate::from_pem(&authority.pem))
}

fn encrypted(folder: &Path, authority: &Authority) -> ServerOptions {
    authority.serve(folder);
    let mut options = guarded(folder);
    (options.guard.tls_cert, options.guard.tls_key) = (folder.join("cert.pem"), folder.join("key.pem"));
    options
}

#[tokio::test]
async fn calls_are_encrypted_and_certificates_are_changed_without_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new();
    let options = encrypted(folder.path(), &authority);
    let token = grant(&options, "t", "t", Role::Submit);
    let server = start(options).await;
    assert!(server.0.url().starts_with("https://"));
    let connection = connect(&server.0, trusting(&authority)).await.unwrap();
    let caller = As { connection, bearer: Bearer(Some(token)) };
    let job = caller.submit("r", "fanuc-2path-lathe", "EVENTS 30000").await.unwrap().job_id;
    assert_eq!(caller.wait(&job).await.events, 30_000);

    let plain = Endpoint::from_shared(format!("http://{}", server.0.address())).unwrap().connect().await;
    if let Ok(plain) = plain {
        JobsClient::new(plain).list_jobs(v1::ListJobsRequest::default()).await.unwrap_err();
    }
    let next = Authority::new();
    assert!(connect(&server.0, trusting(&next)).await.is_err());
    next.serve(folder.path());
    server.0.reload();
    assert!(connect(&server.0, trusting(&next)).await.is_ok());
    assert!(connect(&server.0, trusting(&authority)).await.is_err());
    assert_eq!(caller.list().await, [job], "connections from before go on");
    std::fs::write(folder.path().join("key.pem"), "no key").unwrap();
    server.0.reload();
    assert!(connect(&server.0, trusting(&next)).await.is_ok(), "what cannot be read changes nothing");
    stop(server).await;
}

#[tokio::test]
async fn a_client_certificate_is_an_identity_and_without_one_nobody_gets_in() {
    let folder = tempfile::tempdir().unwrap();
    let (authority, clients, strangers) = (Authority::new(), Authority::new(), Authority::new());
    let mut options = encrypted(folder.path(), &authority);
    options.guard.tls_client_ca = folder.path().join("clients.pem");
    std::fs::write(&options.guard.tls_client_ca, &clients.pem).unwrap();
    let row = "[[certificate]]\nname = \"cell-3.example\"\ntenant = \"cells\"\nrole = \"submit\"\n";
    std::fs::write(&options.guard.access, row).unwrap();
    let token = grant(&options, "t", "others", Role::Read);
    let server = start(options).await;
    let with = |of: &Authority, name: &str| {
        let (certificate, key) = of.certify(name, ExtendedKeyUsagePurpose::ClientAuth);
        trusting(&authority).identity(Identity::from_pem(certificate, key))
    };
    let cell =
        As { connection: connect(&server.0, with(&clients, "cell-3.example")).await.unwrap(), bearer: Bearer(None) };
    let job = cell.submit("r", "fanuc-2path-lathe", "EVENTS 3").await.unwrap().job_id;
    assert_eq!(cell.list().await, [job]);
    let other = As { bearer: Bearer(Some(token.clone())), ..cell.clone() };
    assert!(other.list().await.is_empty(), "a token says more than the certificate");
    let unknown = connect(&server.0, with(&clients, "cell-4.example")).await.unwrap();
    let refused = JobsClient::new(unknown).list_jobs(v1::ListJobsRequest::default()).await.unwrap_err();
    assert_eq!(reason(&refused), "UNAUTHENTICATED");
    for config in [trusting(&authority), with(&strangers, "cell-3.example")] {
        // The refusal may come after the client's part of the handshake.
        if let Ok(connection) = connect(&server.0, config).await {
            let caller = As { connection, bearer: Bearer(Some(token.clone())) };
            caller.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap_err();
        }
    }
    stop(server).await;
}

#[tokio::test]
async fn a_handshake_that_does_not_come_holds_no_connection() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = encrypted(folder.path(), &Authority::new());
    options.connections.preface_s = 1;
    let server = start(options).await;
    for begin in [&b""[..], b"\x16\x03\x01", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"] {
        let mut stream = TcpStream::connect(server.0.address()).await.unwrap();
        stream.write_all(begin).await.unwrap();
        let mut answer = Vec::new();
        let closed = tokio::time::timeout(Duration::from_secs(20), stream.read_to_end(&mut answer)).await;
        let _ = closed.expect("the server closes the connection");
    }
    stop(server).await;
}

/// Encryption alone gives no identities: the server does not open to the network, and on loopback each client that can
/// connect is the administrator of the tenant `default`.
#[tokio::test]
async fn encryption_without_identities_stays_on_this_computer() {
    let folder = tempfile::tempdir().unwrap();
    let (authority, clients) = (Authority::new(), Authority::new());
    let mut options = encrypted(folder.path(), &authority);
    options.guard.access = Default::default();
    options.guard.tls_client_ca = folder.path().join("clients.pem");
    std::fs::write(&options.guard.tls_client_ca, &clients.pem).unwrap();
    let open = ServerOptions { listen: "0.0.0.0:0".parse().unwrap(), ..options.clone() };
    let error = service::build(open).await.unwrap_err().to_string();
    assert!(error.contains("access") && error.contains("--insecure"), "{error}");
    assert!(!options.data.exists(), "nothing is touched before that");

    let server = start(options).await;
    if let Ok(connection) = connect(&server.0, trusting(&authority)).await {
        let caller = As { connection, bearer: Bearer(None) };
        caller.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap_err();
    }
    let (certificate, key) = clients.certify("anything.example", ExtendedKeyUsagePurpose::ClientAuth);
    let config = trusting(&authority).identity(Identity::from_pem(certificate, key));
    let caller = As { connection: connect(&server.0, config).await.unwrap(), bearer: Bearer(None) };
    let job = caller.submit("r", "fanuc-2path-lathe", "EVENTS 3").await.unwrap();
    assert_eq!(job.tenant, "default");
    let listed = caller.admin().list_connections(v1::ListConnectionsRequest::default()).await.unwrap().into_inner();
    assert_eq!(listed.connections.len(), 1, "the call needs the role admin");
    assert_eq!(listed.connections[0].identity, "anonymous");
    stop(server).await;
}

/// A key and a certificate that were renewed at different times.
#[tokio::test]
async fn a_key_of_another_certificate_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new();
    let (certificate, _) = authority.certify("localhost", ExtendedKeyUsagePurpose::ServerAuth);
    let (_, key) = authority.certify("localhost", ExtendedKeyUsagePurpose::ServerAuth);
    let (cert_file, key_file) = (folder.path().join("cert.pem"), folder.path().join("key.pem"));
    std::fs::write(&cert_file, certificate).unwrap();
    std::fs::write(&key_file, key).unwrap();
    let mut options = options(&folder.path().join("data"));
    (options.guard.tls_cert, options.guard.tls_key) = (cert_file, key_file.clone());
    let error = counterpoint_server::service::build_with(options, Script::default()).await.map(drop).unwrap_err();
    let expected = format!("'{}' (option tls_key) is not the key of this certificate", key_file.display());
    assert!(error.to_string().contains(&expected), "{error}");
}
