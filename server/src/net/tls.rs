//! Encrypted connections: certificates from files, which can be changed while the server runs.
//!
//! Invariant: a connection whose handshake is not done by the deadline holds no descriptor any longer, and one that
//! does not speak HTTP/2 after that neither.

use std::io;
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::{Arc, PoisonError, RwLock};
use std::task::{Context, Poll};

use rustls::pki_types::pem::{self, PemObject as _};
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::{RootCertStore, ServerConfig};
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;

use super::PREFACE;
use crate::access::CertificateNames;
use crate::certificates;
use crate::option_file::OptionFile;
use crate::options::Guard;

/// Certificates of the server.
#[derive(Debug)]
pub(crate) struct Tls {
    options: Guard,
    config: RwLock<Arc<ServerConfig>>,
}

impl Tls {
    /// Reads the certificates, if the options name any.
    pub(crate) fn open(options: &Guard) -> Result<Option<Self>, String> {
        let set = |path: &PathBuf| !path.as_os_str().is_empty();
        if !set(&options.tls_cert) {
            let stray = set(&options.tls_key) || set(&options.tls_client_ca);
            return if stray { Err("tls_key and tls_client_ca need tls_cert".to_owned()) } else { Ok(None) };
        }
        if !set(&options.tls_key) {
            return Err("tls_key is missing: tls_cert needs the file with the key of the certificate, PEM".to_owned());
        }
        Ok(Some(Self { config: RwLock::new(Arc::new(config(options)?)), options: options.clone() }))
    }

    /// Reads the files again; the certificates stay as they are when that fails.
    pub(crate) fn reload(&self) -> Result<(), String> {
        let new = Arc::new(config(&self.options)?);
        *self.config.write().unwrap_or_else(PoisonError::into_inner) = new;
        Ok(())
    }

    /// Shakes hands, and waits for the first bytes of HTTP/2.
    pub(super) async fn accept(
        &self,
        stream: TcpStream,
    ) -> io::Result<(Begun<TlsStream<TcpStream>>, CertificateNames)> {
        let config = self.config.read().unwrap_or_else(PoisonError::into_inner).clone();
        let mut stream = TlsAcceptor::from(config).accept(stream).await?;
        let names = stream.get_ref().1.peer_certificates().and_then(<[_]>::first).map(names).unwrap_or_default();
        let mut first = [0; PREFACE];
        stream.read_exact(&mut first).await?;
        Ok((Begun { first, taken: 0, stream }, CertificateNames(names.into())))
    }
}

fn config(options: &Guard) -> Result<ServerConfig, String> {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let builder = ServerConfig::builder_with_provider(provider.clone());
    let builder = builder.with_safe_default_protocol_versions().map_err(|error| error.to_string())?;
    let builder = if options.tls_client_ca.as_os_str().is_empty() {
        builder.with_no_client_auth()
    } else {
        let file = OptionFile::new("tls_client_ca", &options.tls_client_ca);
        let mut roots = RootCertStore::empty();
        for certificate in certificates::parse(&file.read()?).map_err(|error| file.wrong(error))? {
            roots.add(certificate).map_err(|error| file.wrong(error))?;
        }
        let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider).build();
        builder.with_client_cert_verifier(verifier.map_err(|error| file.wrong(error))?)
    };
    let file = OptionFile::new("tls_key", &options.tls_key);
    let key = PrivateKeyDer::from_pem_slice(&file.read()?).map_err(|error| match error {
        pem::Error::NoItemsFound => file.wrong("there is no key in it"),
        error => file.wrong(error),
    })?;
    let file = OptionFile::new("tls_cert", &options.tls_cert);
    let chain = certificates::parse(&file.read()?).map_err(|error| file.wrong(error))?;
    let mut config = builder.with_single_cert(chain, key).map_err(|error| match error {
        rustls::Error::InconsistentKeys(_) => {
            let key = options.tls_key.display();
            file.wrong(format_args!("'{key}' (option tls_key) is not the key of this certificate"))
        }
        error => file.wrong(error),
    })?;
    config.alpn_protocols = vec![b"h2".to_vec()];
    if options.grpc_web {
        config.alpn_protocols.push(b"http/1.1".to_vec());
    }
    Ok(config)
}

/// DNS names of a certificate that has been verified.
fn names(certificate: &CertificateDer<'_>) -> Vec<String> {
    let certificate = webpki::EndEntityCert::try_from(certificate);
    certificate.map(|certificate| certificate.valid_dns_names().map(str::to_owned).collect()).unwrap_or_default()
}

/// A connection of which the first bytes have been read.
pub(super) struct Begun<S> {
    first: [u8; PREFACE],
    taken: usize,
    stream: S,
}

impl<S> Begun<S> {
    /// Its first bytes.
    pub(super) fn first(&self) -> &[u8; PREFACE] {
        &self.first
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Begun<S> {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, out: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let taken = self.taken;
        match self.first.get(taken..) {
            Some(left) if !left.is_empty() => {
                let count = left.len().min(out.remaining());
                out.put_slice(left.get(..count).unwrap_or_default());
                self.taken += count;
                Poll::Ready(Ok(()))
            }
            _ => Pin::new(&mut self.stream).poll_read(cx, out),
        }
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Begun<S> {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, data: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(cx, data)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(cx, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}
