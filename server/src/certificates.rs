//! Certificates in files.

use std::fmt::Display;
use std::path::Path;

use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject as _;

/// The certificates of a PEM file, at least one. The error names the file.
pub(crate) fn read(path: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let text = std::fs::read(path).map_err(|error| wrong(path, error))?;
    parse(&text).map_err(|error| wrong(path, error))
}

/// The certificates of a PEM text, at least one.
pub(crate) fn parse(text: &[u8]) -> Result<Vec<CertificateDer<'static>>, String> {
    let found: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(text).collect();
    match found {
        Ok(found) if found.is_empty() => Err("there is no certificate in it".to_owned()),
        found => found.map_err(|error| error.to_string()),
    }
}

/// An error about a file.
pub(crate) fn wrong(path: &Path, error: impl Display) -> String {
    format!("'{}': {error}", path.display())
}
