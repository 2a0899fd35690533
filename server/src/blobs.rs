//! Contents of files, named by their SHA-256.
//!
//! Invariant: a blob under its name has that digest and is complete; it is never changed.

use std::fs;
use std::io::{self, Write};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::reason::Refusal;
use crate::store::Store;

/// Digest of a content as 64 lower-case hexadecimal digits.
pub(crate) fn digest(content: &[u8]) -> String {
    hex(&Sha256::digest(content))
}

/// Bytes as lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().flat_map(|b| [b >> 4, b & 15]).filter_map(|d| char::from_digit(u32::from(d), 16)).collect()
}

/// Whether a text can be a digest.
pub(crate) fn is_digest(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// The blobs of a server.
#[derive(Debug, Clone)]
pub(crate) struct Blobs {
    store: Store,
    max: u64,
}

impl Blobs {
    pub(crate) fn new(store: Store, max: u64) -> Self {
        Self { store, max }
    }

    pub(crate) fn has(&self, digest: &str) -> bool {
        is_digest(digest) && self.store.blob(digest).is_file()
    }

    pub(crate) fn read(&self, digest: &str) -> io::Result<Arc<[u8]>> {
        fs::read(self.store.blob(digest)).map(Arc::from)
    }

    pub(crate) fn open(&self, digest: &str) -> Result<fs::File, Refusal> {
        if !self.has(digest) {
            return Err(Refusal::UnknownBlob(digest.to_owned()));
        }
        Ok(fs::File::open(self.store.blob(digest))?)
    }

    /// Begins to receive a blob announced as `digest`.
    pub(crate) fn receive(&self, digest: &str) -> Result<Receiver, Refusal> {
        if !is_digest(digest) {
            return Err(Refusal::field("digest", "must be 64 lower-case hexadecimal digits"));
        }
        let file = tempfile::NamedTempFile::new_in(self.store.tmp())?;
        Ok(Receiver { blobs: self.clone(), announced: digest.to_owned(), file, hash: Sha256::new(), size: 0 })
    }
}

/// A blob on its way in. Dropping it leaves nothing behind.
pub(crate) struct Receiver {
    blobs: Blobs,
    announced: String,
    file: tempfile::NamedTempFile,
    hash: Sha256,
    size: u64,
}

impl Receiver {
    pub(crate) fn chunk(&mut self, data: &[u8]) -> Result<(), Refusal> {
        self.size += data.len() as u64;
        if self.size > self.blobs.max {
            return Err(Refusal::BlobTooLarge(self.blobs.max));
        }
        self.hash.update(data);
        Ok(self.file.write_all(data)?)
    }

    /// Puts the blob in its place; gives its size.
    pub(crate) fn finish(self) -> Result<u64, Refusal> {
        let actual = hex(&self.hash.finalize());
        if actual != self.announced {
            return Err(Refusal::DigestMismatch { announced: self.announced, actual });
        }
        if !self.blobs.has(&actual) {
            self.blobs.store.keep(self.file, &self.blobs.store.blob(&actual))?;
        }
        Ok(self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blobs(max: u64) -> (tempfile::TempDir, Blobs) {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path().to_owned(), false).unwrap();
        (folder, Blobs::new(store, max))
    }

    #[test]
    fn what_comes_in_goes_out() {
        let (_folder, blobs) = blobs(100);
        let name = digest(b"G0X1\nM30\n");
        assert!(!blobs.has(&name));
        let mut receiver = blobs.receive(&name).unwrap();
        receiver.chunk(b"G0X1\n").unwrap();
        receiver.chunk(b"M30\n").unwrap();
        assert_eq!(receiver.finish().unwrap(), 9);
        assert_eq!(&*blobs.read(&name).unwrap(), b"G0X1\nM30\n");
    }

    #[test]
    fn a_wrong_digest_or_too_much_is_refused_and_leaves_nothing() {
        let (folder, blobs) = blobs(4);
        let mut receiver = blobs.receive(&digest(b"x")).unwrap();
        receiver.chunk(b"y").unwrap();
        assert!(matches!(receiver.finish(), Err(Refusal::DigestMismatch { .. })));
        let mut receiver = blobs.receive(&digest(b"12345")).unwrap();
        assert_eq!(receiver.chunk(b"12345"), Err(Refusal::BlobTooLarge(4)));
        drop(receiver);
        assert!(matches!(blobs.receive("../../x"), Err(Refusal::InvalidField { .. })));
        assert_eq!(fs::read_dir(folder.path().join("tmp")).unwrap().count(), 0);
    }
}
