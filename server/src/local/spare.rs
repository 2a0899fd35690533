//! Files in the folders of jobs: a head with length and checksum shows whether they are whole.
//!
//! Invariant: a file is read whole, under the job and the name under which it was stored, or not at all. Checksums of
//! files from earlier versions cover the content only.

use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom};

use crate::log::sums::FileChecksum;

const MAGIC: &[u8; 8] = b"CPRES\0\0\x02";
const EARLIER_MAGIC: &[u8; 8] = b"CPRES\0\0\x01";
/// Magic, length, CRC-32.
const HEAD: usize = 20;

/// The head of the content of a file of a job.
pub(super) fn head(job: &str, name: &str, content: &[u8]) -> [u8; HEAD] {
    let mut head = [0; HEAD];
    let length = (content.len() as u64).to_le_bytes();
    let parts = [&MAGIC[..], &length, &FileChecksum::of(job, name).of_content(content).to_le_bytes()].concat();
    head.iter_mut().zip(parts).for_each(|(slot, byte)| *slot = byte);
    head
}

/// The file of a job, positioned at the start of its content; an error unless the content is whole.
pub(super) fn whole(mut file: File, job: &str, name: &str) -> io::Result<File> {
    let mut head = Vec::new();
    (&mut file).take(HEAD as u64).read_to_end(&mut head)?;
    let Some((magic, rest)) = head.split_first_chunk::<8>() else { return Err(damaged()) };
    let sums = match magic {
        MAGIC => FileChecksum::of(job, name),
        EARLIER_MAGIC => FileChecksum::EARLIER,
        _ => return Err(damaged()),
    };
    let Some((length, crc)) = rest.split_first_chunk::<8>() else { return Err(damaged()) };
    let (mut hash, mut read, mut buffer) = (sums.hasher(), 0, vec![0; 64 * 1024]);
    loop {
        let got = file.read(&mut buffer)?;
        if got == 0 {
            break;
        }
        hash.update(buffer.get(..got).unwrap_or_default());
        read += got as u64;
    }
    if read != u64::from_le_bytes(*length) || hash.finalize().to_le_bytes() != crc {
        return Err(damaged());
    }
    file.seek(SeekFrom::Start(HEAD as u64))?;
    Ok(file)
}

/// Whether a content is that of a file without a head, as earlier versions wrote those of macros.
pub(super) fn is_plain_json(content: &[u8]) -> bool {
    serde_json::from_slice::<serde::de::IgnoredAny>(content).is_ok()
}

fn damaged() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "a stored file is not whole: its checksum is wrong")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_whole_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let read_as = |job: &str, name: &str, bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let mut text = Vec::new();
            let file = whole(File::open(&path).unwrap(), job, name);
            file.and_then(|mut file| file.read_to_end(&mut text)).ok().map(|_| text)
        };
        let read = |bytes: &[u8]| read_as("job", "summary.json", bytes);
        let content = b"{\"makespan\":7}\n";
        let stored = [&head("job", "summary.json", content)[..], content].concat();
        assert_eq!(read(&stored).unwrap(), content);
        assert_eq!(read_as("job-2", "summary.json", &stored), None, "of another job");
        assert_eq!(read_as("job", "timeline.json", &stored), None, "another file of the job");
        let parts =
            [&EARLIER_MAGIC[..], &(content.len() as u64).to_le_bytes(), &crc32fast::hash(content).to_le_bytes()];
        let earlier = [&parts.concat()[..], content].concat();
        assert_eq!(read(&earlier).unwrap(), content, "as an earlier version wrote it");
        assert_eq!(read(content), None, "without a head");
        for cut in 0..stored.len() {
            assert_eq!(read(&stored[..cut]), None, "{cut}");
        }
        for bit in 0..stored.len() * 8 {
            let mut bad = stored.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(read(&bad), None, "{bit}");
        }
        assert_eq!(read(b""), None);
        assert_eq!(read(&vec![0; stored.len()]), None);
        assert_eq!(read(&head("job", "summary.json", b"")).unwrap(), b"");
    }
}
