//! Contents of files, named by their SHA-256.
//!
//! [`Blobs`] is the seam; those in the data folder or in memory are in `local`. Invariant: a blob under its name has
//! that digest and is complete; it is never changed.

use std::fmt::Debug;
use std::io::{self, Read};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use sha2::{Digest, Sha256};

use crate::reason::Refusal;

/// Digest of a content as 64 lower-case hexadecimal digits.
pub(crate) fn digest(content: &[u8]) -> String {
    hex(&Sha256::digest(content))
}

/// Bytes as lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(2 * bytes.len());
    text.extend(bytes.iter().flat_map(|b| [b >> 4, b & 15]).filter_map(|d| char::from_digit(u32::from(d), 16)));
    text
}

/// Whether a text can be a digest.
pub(crate) fn is_digest(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// Keeps the blobs of a tenant: uploads of other tenants are not visible. All calls may block.
pub(crate) trait Blobs: Send + Sync + Debug {
    /// Those of a tenant.
    fn of(&self, tenant: &str) -> Arc<dyn Blobs>;

    /// Tenants that have blobs.
    fn tenants(&self) -> io::Result<Vec<String>>;

    fn has(&self, digest: &str) -> bool;

    /// Refuses when one of these is not there.
    fn require(&self, digests: &mut dyn Iterator<Item = &String>) -> Result<(), Refusal> {
        let missing: Vec<String> = digests.filter(|digest| !self.has(digest)).cloned().collect();
        if missing.is_empty() { Ok(()) } else { Err(Refusal::MissingBlobs(missing)) }
    }

    /// Same as [`has`](Self::has) for a caller who relies on it: the blob counts as uploaded now.
    fn offers(&self, digest: &str) -> bool;

    /// Bytes of all blobs of the tenant.
    fn bytes(&self) -> io::Result<u64>;

    /// Bytes of a blob, 0 if there is none.
    fn size(&self, digest: &str) -> u64;

    /// The content; damage and loss are errors of kind `InvalidData`.
    fn read(&self, digest: &str) -> io::Result<Bytes>;

    /// A stream of the content, which fails at its end when it has another digest.
    fn open(&self, digest: &str) -> Result<Box<dyn Read + Send>, Refusal>;

    /// Begins to receive a blob announced as `digest`, and perhaps with its size.
    fn receive(&self, digest: &str, size: Option<u64>) -> Result<Box<dyn BlobReceiver>, Refusal>;

    /// Puts a content of this process, whose digest its owner has made, in its place: where blobs are in memory nothing
    /// is copied.
    fn put(&self, digest: &str, content: Bytes) -> Result<(), Refusal>;

    /// Blobs that have been neither uploaded nor offered for a while, in small groups; none where they go with the
    /// server.
    fn older_than(&self, grace: Duration) -> Box<dyn Iterator<Item = Vec<String>> + '_>;

    /// Removes a blob if it is still that old.
    fn remove_older(&self, digest: &str, grace: Duration) -> bool;
}

/// A blob on its way in. Dropping it leaves nothing behind.
pub(crate) trait BlobReceiver: Send {
    /// Whether a chunk is only copied, so it needs no thread that may wait.
    fn in_memory(&self) -> bool;

    fn chunk(&mut self, data: &[u8]) -> Result<(), Refusal>;

    /// Puts the blob in its place; returns its size.
    fn finish(self: Box<Self>) -> Result<u64, Refusal>;
}
