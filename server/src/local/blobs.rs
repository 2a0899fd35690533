//! Blobs in files of the data folder; a server that keeps nothing (an ephemeral one) holds them in memory.
//!
//! Invariant: a file gets the name of a blob only when it is complete, durable and has that digest.

use std::fs;
use std::io::{self, Read, Write};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::Bytes;
use dashmap::DashMap;
use sha2::{Digest, Sha256};

use super::disk::Temporary;
use super::named::PathContext as _;
use super::sizes::Sizes;
use super::store::DataFolder;
use crate::blobs::{self, Blobs, hex, is_digest};
use crate::reason::Refusal;
use crate::tenant;

/// Most bytes that are set aside for an announced size before they come.
const RESERVE: usize = 64 << 20;

/// A blob offered again within this time keeps its time.
const FRESH: Duration = Duration::from_secs(1);
/// Most blobs that are looked at in one step of a collection.
const GROUP: usize = 64;

/// The blobs of a server.
#[derive(Debug, Clone)]
pub(crate) struct LocalBlobs {
    place: BlobStorage,
    tenant: String,
    max: u64,
    sizes: Arc<Sizes>,
}

/// Where blobs are.
#[derive(Debug, Clone)]
enum BlobStorage {
    Files(DataFolder),
    Memory(Arc<DashMap<String, Bytes>>),
}

impl LocalBlobs {
    pub(crate) fn new(store: DataFolder, max: u64) -> Self {
        Self { place: BlobStorage::Files(store), tenant: tenant::default(), max, sizes: Arc::default() }
    }

    /// Blobs that go with the server.
    pub(crate) fn in_memory(max: u64) -> Self {
        Self { place: BlobStorage::Memory(Arc::default()), tenant: tenant::default(), max, sizes: Arc::default() }
    }

    /// Those of a tenant.
    pub(crate) fn of_tenant(&self, tenant: &str) -> Self {
        Self { tenant: tenant.to_owned(), ..self.clone() }
    }

    /// Name of a blob in memory.
    fn key(&self, digest: &str) -> String {
        tenant::key(&self.tenant, digest)
    }

    /// Whether the content of a blob matches its digest; has no other effect.
    pub(crate) fn has_its_digest(&self, digest: &str) -> io::Result<bool> {
        let BlobStorage::Files(store) = &self.place else { return Ok(true) };
        let mut hash = Sha256::new();
        let path = store.blob(&self.tenant, digest);
        let mut file = store.disk().open(&path).at(&path)?;
        io::copy(&mut file, &mut hash).at(&path)?;
        Ok(hex(&hash.finalize()) == digest)
    }

    /// Time since a blob was uploaded or offered; `None` if there is none, or if the clock has been set back since.
    fn age(&self, digest: &str) -> Option<Duration> {
        match &self.place {
            BlobStorage::Files(store) if is_digest(digest) => {
                fs::metadata(store.blob(&self.tenant, digest)).ok()?.modified().ok()?.elapsed().ok()
            }
            _ => None,
        }
    }

    /// Puts a blob with other content than its name says out of the way, so that it can be uploaded again.
    fn damaged(&self, digest: &str) -> io::Error {
        if let BlobStorage::Files(store) = &self.place {
            let path = store.blob(&self.tenant, digest);
            let moved = fs::rename(&path, path.with_extension("damaged"));
            tracing::error!(digest, ?moved, "the content of a blob has changed on the disk");
        }
        let text =
            format!("the stored content of blob {digest} has changed; upload it again, then submit the job again");
        io::Error::new(io::ErrorKind::InvalidData, text)
    }
}

impl Blobs for LocalBlobs {
    fn of(&self, tenant: &str) -> Arc<dyn Blobs> {
        Arc::new(self.of_tenant(tenant))
    }

    fn tenants(&self) -> io::Result<Vec<String>> {
        match &self.place {
            BlobStorage::Files(store) => store.tenants(),
            BlobStorage::Memory(_) => Ok(vec![tenant::default()]),
        }
    }

    fn has(&self, digest: &str) -> bool {
        match &self.place {
            BlobStorage::Files(store) => is_digest(digest) && store.has(&store.blob(&self.tenant, digest)),
            BlobStorage::Memory(blobs) => blobs.contains_key(&self.key(digest)),
        }
    }

    fn offers(&self, digest: &str) -> bool {
        if let BlobStorage::Files(store) = &self.place
            && self.age(digest).is_some_and(|age| age > FRESH)
        {
            // Not being able to is fine: then the blob may be collected, and the client is asked for it again.
            let file = fs::File::options().append(true).open(store.blob(&self.tenant, digest));
            let _ = file.and_then(|file| file.set_modified(SystemTime::now()));
        }
        self.has(digest)
    }

    fn older_than(&self, grace: Duration) -> Box<dyn Iterator<Item = Vec<String>> + '_> {
        Box::new((0..=255u8).flat_map(move |first| {
            let names = match &self.place {
                BlobStorage::Files(store) => store.blobs(&self.tenant, &hex(&[first])).unwrap_or_default(),
                BlobStorage::Memory(_) => Vec::new(),
            };
            let old: Vec<_> = names.into_iter().filter(|name| self.age(name).is_some_and(|age| age >= grace)).collect();
            old.chunks(GROUP).map(<[String]>::to_vec).collect::<Vec<_>>()
        }))
    }

    fn remove_older(&self, digest: &str, grace: Duration) -> bool {
        let BlobStorage::Files(store) = &self.place else { return false };
        self.sizes.take(&self.tenant, digest, || {
            let size = self.size(digest);
            let old = self.age(digest).is_some_and(|age| age >= grace);
            (old && fs::remove_file(store.blob(&self.tenant, digest)).is_ok()).then_some(size)
        })
    }

    fn read(&self, digest: &str) -> io::Result<Bytes> {
        match &self.place {
            BlobStorage::Files(store) => match store.disk().read(&store.blob(&self.tenant, digest)) {
                Ok(content) if blobs::digest(&content) == digest => Ok(content.into()),
                Ok(_) => Err(self.damaged(digest)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => Err(gone(digest)),
                other => other.map(Bytes::from),
            },
            BlobStorage::Memory(blobs) => {
                blobs.get(&self.key(digest)).map(|blob| blob.clone()).ok_or_else(|| io::ErrorKind::NotFound.into())
            }
        }
    }

    fn bytes(&self) -> io::Result<u64> {
        match &self.place {
            BlobStorage::Files(store) => self.sizes.of(&self.tenant, || store.blob_bytes(&self.tenant)),
            BlobStorage::Memory(_) => Ok(0),
        }
    }

    fn size(&self, digest: &str) -> u64 {
        match &self.place {
            BlobStorage::Files(store) => fs::metadata(store.blob(&self.tenant, digest)).map_or(0, |meta| meta.len()),
            BlobStorage::Memory(blobs) => blobs.get(&self.key(digest)).map_or(0, |blob| blob.len() as u64),
        }
    }

    fn open(&self, digest: &str) -> Result<Box<dyn Read + Send>, Refusal> {
        if !self.has(digest) {
            return Err(Refusal::UnknownBlob(digest.to_owned()));
        }
        Ok(match &self.place {
            BlobStorage::Files(store) => {
                let file = store.disk().open(&store.blob(&self.tenant, digest))?;
                Box::new(BlobReader { blobs: self.clone(), name: digest.to_owned(), file, hash: Sha256::new() })
            }
            BlobStorage::Memory(_) => Box::new(io::Cursor::new(self.read(digest)?)),
        })
    }

    fn receive(&self, digest: &str, size: Option<u64>) -> Result<Box<dyn blobs::BlobReceiver>, Refusal> {
        if !is_digest(digest) {
            return Err(Refusal::field("digest", "must be 64 lower-case hexadecimal digits"));
        }
        if size.is_some_and(|size| size > self.max) {
            return Err(Refusal::BlobTooLarge(self.max));
        }
        let room = usize::try_from(size.unwrap_or(0)).unwrap_or(0).min(RESERVE);
        let content = match &self.place {
            BlobStorage::Files(store) => ReceivedContent::File(store.temporary()?),
            BlobStorage::Memory(_) => ReceivedContent::Memory(Vec::with_capacity(room)),
        };
        Ok(Box::new(LocalBlobReceiver {
            blobs: self.clone(),
            announced: digest.to_owned(),
            bytes: size,
            content,
            hash: Sha256::new(),
            size: 0,
        }))
    }

    fn put(&self, digest: &str, content: Bytes) -> Result<(), Refusal> {
        match &self.place {
            BlobStorage::Memory(_) if content.len() as u64 > self.max => Err(Refusal::BlobTooLarge(self.max)),
            BlobStorage::Memory(blobs) => {
                blobs.insert(self.key(digest), content);
                Ok(())
            }
            BlobStorage::Files(_) => {
                let mut receiver = self.receive(digest, Some(content.len() as u64))?;
                receiver.chunk(&content)?;
                receiver.finish().map(drop)
            }
        }
    }
}

fn wrong_size(announced: Option<u64>, got: u64) -> Refusal {
    Refusal::field(
        "size",
        format!("{} bytes were announced, the content has another size ({got} so far)", announced.unwrap_or(0)),
    )
}

fn gone(digest: &str) -> io::Error {
    let text = format!("the stored content of blob {digest} is gone; upload it again, then submit the job again");
    io::Error::new(io::ErrorKind::InvalidData, text)
}

/// A blob on its way out.
struct BlobReader {
    blobs: LocalBlobs,
    name: String,
    file: fs::File,
    hash: Sha256,
}

impl Read for BlobReader {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let got = self.file.read(out)?;
        self.hash.update(out.get(..got).unwrap_or_default());
        if got == 0 && !out.is_empty() && hex(&self.hash.clone().finalize()) != self.name {
            return Err(self.blobs.damaged(&self.name));
        }
        Ok(got)
    }
}

/// A blob on its way in.
struct LocalBlobReceiver {
    blobs: LocalBlobs,
    announced: String,
    /// Bytes that were announced.
    bytes: Option<u64>,
    content: ReceivedContent,
    hash: Sha256,
    size: u64,
}

/// The received part.
enum ReceivedContent {
    File(Temporary),
    Memory(Vec<u8>),
}

impl blobs::BlobReceiver for LocalBlobReceiver {
    fn in_memory(&self) -> bool {
        matches!(self.content, ReceivedContent::Memory(_))
    }

    fn chunk(&mut self, data: &[u8]) -> Result<(), Refusal> {
        self.size += data.len() as u64;
        if self.bytes.is_some_and(|bytes| self.size > bytes) {
            return Err(wrong_size(self.bytes, self.size));
        }
        if self.size > self.blobs.max {
            return Err(Refusal::BlobTooLarge(self.blobs.max));
        }
        self.hash.update(data);
        match &mut self.content {
            ReceivedContent::File(file) => file.write_all(data)?,
            ReceivedContent::Memory(content) => content.extend_from_slice(data),
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<u64, Refusal> {
        if self.bytes.is_some_and(|bytes| self.size != bytes) {
            return Err(wrong_size(self.bytes, self.size));
        }
        let actual = hex(&self.hash.finalize());
        if actual != self.announced {
            return Err(Refusal::DigestMismatch { announced: self.announced, actual });
        }
        match (self.content, &self.blobs.place) {
            (ReceivedContent::File(file), BlobStorage::Files(store)) => {
                let (tenant, path) = (&self.blobs.tenant, store.blob(&self.blobs.tenant, &actual));
                self.blobs.sizes.place(tenant, &actual, || {
                    // Another upload of the same content may have been faster.
                    if self.blobs.offers(&actual) {
                        return Ok(None);
                    }
                    let new = !path.is_file();
                    store.keep(file, &path)?;
                    Ok::<_, io::Error>(new.then_some(self.size))
                })?;
            }
            (ReceivedContent::Memory(content), BlobStorage::Memory(blobs)) => {
                drop(blobs.insert(self.blobs.key(&actual), content.into()))
            }
            (ReceivedContent::File(_), BlobStorage::Memory(_))
            | (ReceivedContent::Memory(_), BlobStorage::Files(_)) => {}
        }
        Ok(self.size)
    }
}

#[cfg(test)]
mod tests;
