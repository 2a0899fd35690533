//! Checksums that begin with the file they belong to.
//!
//! *Invariant:* a content is whole only under the job and the name under which it was stored: files that two jobs have
//! exchanged are damaged.

use super::{EARLIER_MAGIC, MAGIC};

/// CRC-32 over the job, the kind of file, and a content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sums(u32);

impl Sums {
    /// Over the content alone, as earlier versions made them.
    pub(crate) const EARLIER: Self = Self(0);

    /// Those of a file of a job.
    pub(crate) fn of(job: &str, file: &str) -> Self {
        let mut hash = Self::EARLIER.hasher();
        [job, "\0", file, "\0"].into_iter().for_each(|part| hash.update(part.as_bytes()));
        Self(hash.finalize())
    }

    /// Those of the log of a job.
    pub(crate) fn of_log(job: &str) -> Self {
        Self::of(job, "log")
    }

    /// Those of a log of a job that begins with these bytes; none if no log does.
    pub(crate) fn of_magic(job: &str, magic: &[u8]) -> Option<Self> {
        if magic == MAGIC {
            return Some(Self::of_log(job));
        }
        (magic == EARLIER_MAGIC).then_some(Self::EARLIER)
    }

    /// A checksum under way.
    pub(crate) fn hasher(self) -> crc32fast::Hasher {
        crc32fast::Hasher::new_with_initial(self.0)
    }

    /// The checksum of a content.
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
        let of = |job: &str, file: &str| Sums::of(job, file).of_content(b"content");
        let mut sums = vec![of("a", "log"), of("b", "log"), of("a", "files.json"), of("al", "og")];
        sums.push(Sums::EARLIER.of_content(b"content"));
        sums.sort_unstable();
        sums.dedup();
        assert_eq!(sums.len(), 5);
        assert_eq!(Sums::EARLIER.of_content(b"content"), crc32fast::hash(b"content"));
        assert_eq!(Sums::of_magic("a", EARLIER_MAGIC), Some(Sums::EARLIER));
        assert_eq!(Sums::of_magic("a", MAGIC), Some(Sums::of_log("a")));
        assert_eq!(Sums::of_magic("a", b"CPLOG\0\0\x03"), None);
    }
}
