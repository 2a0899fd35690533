//! A server with TLS and identities, and the files of its clients: `ca.pem`, `other.pem` (an authority that has not
//! signed the server), `client.pem`, `client.key`, and `token`.

use std::path::Path;

use counterpoint_server::access::{Role, token};
use counterpoint_server::options::ServerOptions;
use rcgen::{BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair};

/// Writes a new authority; returns its issuer.
fn authority(file: &Path) -> Issuer<'static, KeyPair> {
    let key = KeyPair::generate().unwrap();
    let mut params = CertificateParams::new(vec![]).unwrap();
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    // OpenSSL treats a certificate with the same subject and issuer as self-signed.
    params.distinguished_name.push(DnType::CommonName, file.display().to_string());
    std::fs::write(file, params.self_signed(&key).unwrap().pem()).unwrap();
    Issuer::new(params, key)
}

/// Writes `NAME.pem` and `NAME.key`.
fn certify(folder: &Path, name: &str, host: &str, issuer: &Issuer<'_, KeyPair>, usage: ExtendedKeyUsagePurpose) {
    let key = KeyPair::generate().unwrap();
    let mut params = CertificateParams::new(vec![host.to_owned()]).unwrap();
    params.extended_key_usages = vec![usage];
    std::fs::write(folder.join(name).with_extension("pem"), params.signed_by(&key, issuer).unwrap().pem()).unwrap();
    std::fs::write(folder.join(name).with_extension("key"), key.serialize_pem()).unwrap();
}

/// Options of a server with TLS and identities and with one place in its queue.
pub(crate) fn options(folder: &Path) -> ServerOptions {
    let issuer = authority(&folder.join("ca.pem"));
    authority(&folder.join("other.pem"));
    certify(folder, "server", "localhost", &issuer, ExtendedKeyUsagePurpose::ServerAuth);
    certify(folder, "client", "cell-3.example", &issuer, ExtendedKeyUsagePurpose::ClientAuth);
    let (token, row) = token::create("ci", "milling", Role::Submit, None).unwrap();
    std::fs::write(folder.join("token"), token).unwrap();
    std::fs::write(folder.join("access.toml"), row).unwrap();
    let mut options = ServerOptions { workers: 1, queue: 1, ..ServerOptions::default() };
    options.guard.access = folder.join("access.toml");
    options.guard.tls_cert = folder.join("server.pem");
    options.guard.tls_key = folder.join("server.key");
    options
}
