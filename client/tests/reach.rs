//! Connections that fail: the error names the address and the setting that does not fit.

#![allow(missing_docs, clippy::unwrap_used, clippy::indexing_slicing, clippy::panic)]

mod guarded;

use std::path::Path;

use counterpoint_client::{Client, ClientSettings, Error, Misfit, v1};
use counterpoint_server::options::ServerOptions;
use counterpoint_server::service::{self, Handle};

/// A server whose data folder is in this folder.
async fn start(folder: &Path, options: ServerOptions) -> Handle {
    let listen = "127.0.0.1:0".parse().unwrap();
    let service = service::build(ServerOptions { listen, data: folder.join("data"), ..options }).await.unwrap();
    let handle = service.handle();
    tokio::spawn(service.run(std::future::pending()));
    handle
}

/// Connects and makes a call.
async fn call(settings: &ClientSettings) -> Error {
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
    let error = call(&ClientSettings::new(&address)).await;
    assert_eq!(error.misfit(), Some(Misfit::Encrypted), "{error}");
    let text = error.to_string();
    assert!(text.contains(&address) && text.contains("it expects https://"), "{text}");
    server.stop();
}

#[tokio::test]
async fn a_client_with_encryption_is_told_that_the_server_has_none() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(folder.path(), ServerOptions::default()).await;
    let address = format!("https://{}", server.address());
    let error = call(&ClientSettings::new(&address)).await;
    assert_eq!(error.misfit(), Some(Misfit::Unencrypted), "{error}");
    assert!(error.to_string().contains("it expects http://"), "{error}");
    assert!(!error.is_passing(), "a repetition does not help");
    server.stop();
}

/// `openssl req -x509` makes such a certificate.
#[tokio::test]
async fn the_certificate_of_an_authority_as_that_of_a_server_is_named_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded::options(folder.path());
    let key = rcgen::KeyPair::generate().unwrap();
    let mut params = rcgen::CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
    params.is_ca = rcgen::IsCa::Ca(rcgen::BasicConstraints::Unconstrained);
    let own = params.self_signed(&key).unwrap().pem();
    options.guard.tls_cert = folder.path().join("own.pem");
    options.guard.tls_key = folder.path().join("own.key");
    std::fs::write(&options.guard.tls_cert, &own).unwrap();
    std::fs::write(&options.guard.tls_key, key.serialize_pem()).unwrap();
    let server = start(folder.path(), options).await;
    let address = format!("https://localhost:{}", server.address().port());
    let error = call(&ClientSettings::new(&address).with_authorities(own.as_bytes())).await;
    assert_eq!(error.misfit(), Some(Misfit::Authority), "{error}");
    let text = error.to_string();
    assert!(text.contains(&address) && text.contains("basicConstraints=CA:FALSE"), "{text}");
    assert!(!text.contains("no server answers") && !error.is_passing(), "{text}");
    server.stop();
}

/// The Python client accepts the same addresses.
#[tokio::test]
async fn an_address_without_a_scheme_is_encrypted_if_authorities_are_given() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(folder.path(), guarded::options(folder.path())).await;
    let address = format!("localhost:{}", server.address().port());
    let error = call(&ClientSettings::new(&address)).await;
    assert_eq!(error.misfit(), Some(Misfit::Encrypted), "{error}");
    let authorities = std::fs::read(folder.path().join("ca.pem")).unwrap();
    let settings = ClientSettings::new(&address).with_authorities(&authorities);
    assert_eq!(settings.address(), format!("https://{address}"));
    assert_eq!(call(&settings).await.reason().as_deref(), Some("UNAUTHENTICATED"));
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
    let error = call(&ClientSettings::new(&address).with_authorities(&authorities)).await;
    assert_eq!(error.misfit(), Some(Misfit::Certificate), "{error}");
    let text = error.to_string();
    assert!(text.contains(&address) && text.contains("CertificateRequired"), "{text}");
    server.stop();
}
