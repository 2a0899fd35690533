//! Connections that fail: the error names the address and the setting that does not fit.

#![allow(missing_docs, clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]

mod guarded;

use std::path::Path;

use counterpoint_client::{Client, Error, Misfit, Settings, v1};
use counterpoint_server::options::Options;
use counterpoint_server::service::{self, Handle};

/// A server whose data folder is in this folder.
async fn start(folder: &Path, options: Options) -> Handle {
    let listen = "127.0.0.1:0".parse().unwrap();
    let service = service::build(Options { listen, data: folder.join("data"), ..options }).await.unwrap();
    let handle = service.handle();
    tokio::spawn(service.run(std::future::pending()));
    handle
}

/// Connects and makes a call.
async fn call(settings: &Settings) -> Error {
    let list = async || {
        let client = Client::connect(settings).await?;
        Ok(client.jobs().list_jobs(v1::ListJobsRequest::default()).await?)
    };
    let answer: Result<_, Error> = list().await;
    answer.unwrap_err()
}

#[tokio::test]
async fn a_client_without_encryption_is_told_that_the_server_expects_it() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(folder.path(), guarded::options(folder.path())).await;
    let address = format!("http://{}", server.address());
    let error = call(&Settings::new(&address)).await;
    assert_eq!(error.misfit(), Some(Misfit::Encrypted), "{error}");
    let text = error.to_string();
    assert!(text.contains(&address) && text.contains("it expects https://"), "{text}");
    server.stop();
}

#[tokio::test]
async fn a_client_with_encryption_is_told_that_the_server_has_none() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(folder.path(), Options::default()).await;
    let address = format!("https://{}", server.address());
    let error = call(&Settings::new(&address)).await;
    assert_eq!(error.misfit(), Some(Misfit::Unencrypted), "{error}");
    assert!(error.to_string().contains("it expects http://"), "{error}");
    assert!(!error.is_passing(), "a repetition does not help");
    server.stop();
}

#[tokio::test]
async fn a_client_without_the_certificate_that_the_server_asks_for_gets_that_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded::options(folder.path());
    options.guard.tls_client_ca = folder.path().join("ca.pem");
    let server = start(folder.path(), options).await;
    let authorities = std::fs::read(folder.path().join("ca.pem")).unwrap();
    let address = format!("https://localhost:{}", server.address().port());
    let error = call(&Settings::new(&address).with_authorities(&authorities)).await;
    assert_eq!(error.misfit(), Some(Misfit::Certificate), "{error}");
    let text = error.to_string();
    assert!(text.contains(&address) && text.contains("CertificateRequired"), "{text}");
    server.stop();
}
