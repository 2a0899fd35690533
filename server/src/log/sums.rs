//! Checksums that also cover the job and the name of their file.
//!
//! *Invariant:* content is whole only under the job and the name under which it was stored. So files exchanged between
//! two jobs are damaged.

use super::{EARLIER_MAGIC, MAGIC};

/// CRC-32 over the job, the name of the file, and its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FileChecksum(u32);

impl FileChecksum {
    /// Checksums over the content alone, as in earlier versions.
    pub(crate) const EARLIER: Self = Self(0);

    /// Checksums of a file of a job.
    pub(crate) fn of(job: &str, file: &str) -> Self {
        let mut hash = Self::EARLIER.hasher();
        [job, "\0", file, "\0"].into_iter().for_each(|part| hash.update(part.as_bytes()));
        Self(hash.finalize())
    }

    /// Checksums of the log of a job.
    pub(crate) fn of_log(job: &str) -> Self {
        Self::of(job, "log")
    }

    /// Checksums of a log of a job that begins with these bytes; none if no log begins with them.
    pub(crate) fn of_magic(job: &str, magic: &[u8]) -> Option<Self> {
        if magic == MAGIC {
            return Some(Self::of_log(job));
        }
        (magic == EARLIER_MAGIC).then_some(Self::EARLIER)
    }

    /// Starts a checksum.
    pub(crate) fn hasher(self) -> crc32fast::Hasher {
        crc32fast::Hasher::new_with_initial(self.0)
    }

    /// The checksum of the content.
    pub(crate) fn of_content(self, content: &[u8]) -> u32 {
        let mut hash = self.hasher();
        hash.update(content);
        hash.finalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_content_has_another_checksum_under_another_job_or_name() {
        let of = |job: &str, file: &str| FileChecksum::of(job, file).of_content(b"content");
        let mut sums = vec![of("a", "log"), of("b", "log"), of("a", "files.json"), of("al", "og")];
        sums.push(FileChecksum::EARLIER.of_content(b"content"));
        sums.sort_unstable();
        sums.dedup();
        assert_eq!(sums.len(), 5);
        assert_eq!(FileChecksum::EARLIER.of_content(b"content"), crc32fast::hash(b"content"));
        assert_eq!(FileChecksum::of_magic("a", EARLIER_MAGIC), Some(FileChecksum::EARLIER));
        assert_eq!(FileChecksum::of_magic("a", MAGIC), Some(FileChecksum::of_log("a")));
        assert_eq!(FileChecksum::of_magic("a", b"CPLOG\0\0\x03"), None);
    }
}
