//! Webhooks about the ends of jobs, at targets over TLS.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use counterpoint_server::options::{ServerOptions, Webhook};
use rcgen::ExtendedKeyUsagePurpose;
use rustls::ServerConfig;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpListener;
use tokio::sync::mpsc;
use tokio_rustls::TlsAcceptor;

use crate::support::*;
use crate::tls::Authority;

const PATIENCE: Duration = Duration::from_secs(60);

/// Whether a request has as many bytes as its head says.
fn is_whole(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let Some((head, body)) = text.split_once("\r\n\r\n") else { return false };
    let length = head.lines().find_map(|line| line.strip_prefix("content-length: ")).unwrap();
    body.len() >= length.parse::<usize>().unwrap()
}

/// A target whose certificate comes from the authority; it hands on each request that it can read.
async fn target(authority: &Authority) -> (u16, mpsc::UnboundedReceiver<String>) {
    let (certificate, key) = authority.certify("localhost", ExtendedKeyUsagePurpose::ServerAuth);
    let chain = vec![CertificateDer::from_pem_slice(certificate.as_bytes()).unwrap()];
    let key = PrivateKeyDer::from_pem_slice(key.as_bytes()).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let builder = ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let acceptor = TlsAcceptor::from(Arc::new(builder.with_no_client_auth().with_single_cert(chain, key).unwrap()));
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let (send, receive) = mpsc::unbounded_channel();
    tokio::spawn(async move {
        loop {
            let (stream, _) = listener.accept().await.unwrap();
            let Ok(mut stream) = acceptor.accept(stream).await else { continue };
            let (mut bytes, mut part) = (Vec::new(), [0; 4096]);
            while !is_whole(&bytes) {
                match stream.read(&mut part).await {
                    Ok(count @ 1..) => bytes.extend_from_slice(&part[..count]),
                    _ => break,
                }
            }
            let _ = stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n").await;
            let _ = stream.shutdown().await;
            if send.send(String::from_utf8(bytes).unwrap()).is_err() {
                return;
            }
        }
    });
    (port, receive)
}

fn informing(folder: &Path, port: u16, authority: &Authority) -> ServerOptions {
    let data = folder.join("data");
    std::fs::create_dir_all(&data).unwrap();
    let (secret_file, ca_file) = (folder.join("secret"), folder.join("ca.pem"));
    std::fs::write(&secret_file, "a secret of 20 bytes").unwrap();
    std::fs::write(&ca_file, &authority.pem).unwrap();
    let webhook = Webhook {
        url: format!("https://localhost:{port}/ends"),
        secret_file,
        tenants: vec!["default".to_owned()],
        states: Vec::new(),
        ca_file: Some(ca_file),
    };
    let mut options = options(&data);
    options.tables.webhooks.insert("mes".to_owned(), webhook);
    options
}

#[tokio::test]
async fn a_target_hears_of_the_ends_of_jobs_and_of_none_that_waits() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new();
    let (port, mut received) = target(&authority).await;
    let server = Server::start(informing(folder.path(), port, &authority)).await;
    let job = server.submit("r1", "events 5").await;
    let status = server.wait(&job).await;
    let message = tokio::time::timeout(PATIENCE, received.recv()).await.unwrap().unwrap();
    assert!(message.starts_with("POST /ends HTTP/1.1\r\n"), "{message}");
    let body: serde_json::Value = serde_json::from_str(message.split_once("\r\n\r\n").unwrap().1).unwrap();
    assert_eq!((&body["data"]["job_id"], &body["data"]["state"]), (&job.into(), &"SUCCEEDED".into()));
    assert_eq!(body["data"]["ended_ms"], status.ended_ms);
    server.stop().await;
    assert!(received.try_recv().is_err(), "one job has ended once");
}

#[tokio::test]
async fn a_target_with_a_certificate_of_an_unknown_authority_hears_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (authority, other) = (Authority::new(), Authority::new());
    let (port, mut received) = target(&authority).await;
    let server = Server::start(informing(folder.path(), port, &other)).await;
    let job = server.submit("r1", "events 5").await;
    server.wait(&job).await;
    server.stop().await;
    assert!(received.try_recv().is_err());
}

#[tokio::test]
async fn a_target_without_its_secret_stops_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new();
    let options = informing(folder.path(), 1, &authority);
    std::fs::remove_file(folder.path().join("secret")).unwrap();
    match counterpoint_server::service::build_with(options, Script::default()).await {
        Ok(_) => panic!("the server must not start"),
        Err(error) => {
            let text = error.to_string();
            assert!(text.starts_with("webhooks.mes: '") && text.contains("(option secret_file): "), "{text}");
        }
    }
}
