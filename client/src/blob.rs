//! Contents of files, named by their digest.

use bytes::Bytes;
use sha2::{Digest as _, Sha256};

use crate::v1;

/// Bytes of an upload chunk.
const CHUNK: usize = 64 * 1024;

/// A content and its digest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blob {
    digest: String,
    content: Bytes,
}

impl Blob {
    /// Computes the digest of a content.
    #[must_use]
    pub fn new(content: impl Into<Bytes>) -> Self {
        let content = content.into();
        let digest = Sha256::digest(&content).iter().map(|byte| format!("{byte:02x}")).collect();
        Self { digest, content }
    }

    /// SHA-256 of the content, 64 lower-case hexadecimal digits.
    #[must_use]
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The content.
    #[must_use]
    pub fn content(&self) -> &Bytes {
        &self.content
    }

    /// The content as an upload: the first chunk carries digest and size; an empty content is one chunk.
    pub(crate) fn chunks(&self) -> impl Iterator<Item = v1::UploadRequest> + Send + use<> {
        let mut rest = self.content.clone();
        let mut digest = Some(self.digest.clone());
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_chunk_carries_digest_and_size() {
        let empty = Blob::new(Vec::new());
        assert_eq!(empty.digest(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
        let chunks: Vec<_> = empty.chunks().collect();
        assert_eq!((chunks.len(), chunks[0].size, chunks[0].digest.as_str()), (1, Some(0), empty.digest()));
        let long = Blob::new(vec![7; CHUNK + 1]);
        let chunks: Vec<_> = long.chunks().collect();
        assert_eq!(chunks.iter().map(|chunk| chunk.data.len()).collect::<Vec<_>>(), [CHUNK, 1]);
        assert_eq!((chunks[0].size, chunks[1].size), (Some(CHUNK as u64 + 1), None));
        assert!(chunks[1].digest.is_empty());
    }
}
