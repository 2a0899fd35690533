//! Event logs: one append-only file per job, in wire encoding. The file of a small log is a row of the ledger; that of
//! a large one is compressed when its run is over (`segments`).
//!
//! File: a head (magic, then the job's description), then records. A record is 24 bytes of frame (length, CRC-32, first
//! and last sequence number, little-endian) and one encoded `EventBatch`. Every CRC-32 also covers the id of the job.
//! Batches end at 256 events or 32 KiB: never a bare event per message (HTTP/2 flood guards), never one too large for a
//! small reader. Invariant: the bytes in the file are the bytes a watcher gets; committed bytes never change while the
//! job lives. A second run of the same job writes the same events, though batches may be cut elsewhere.

use std::fmt::Debug;
use std::io;

use sums::FileChecksum;
use wanted::ResultGate;

#[cfg(test)]
mod codec_tests;
#[cfg(test)]
mod contract_tests;
pub(crate) mod damage;
pub(crate) mod decode;
pub mod encode;
pub(crate) mod filter;
pub(crate) mod kept;
pub(crate) mod reader;
pub(crate) mod segments;
pub(crate) mod sums;
pub(crate) mod tail;
pub(crate) mod wanted;
pub(crate) mod writer;

/// Keeps the logs of jobs, and the other output of runs. All calls may block.
pub(crate) trait Logs: Send + Sync + Debug {
    /// A place for the log of a run that begins; removes log and results of the previous run.
    fn begin(&self, id: &str) -> io::Result<Box<dyn writer::LogDestination>>;

    /// The log of a job, unless it is small and in the ledger.
    fn kept(&self, id: &str) -> Option<kept::StoredLog>;

    /// Stores a result beside the log, whole or not at all.
    fn write(&self, id: &str, name: &str, content: &[u8]) -> io::Result<()>;

    /// Same for a result that can be made again, if it is still wanted. A power failure may lose the result.
    fn write_spare(&self, id: &str, name: &str, content: &[u8], wanted: &ResultGate) -> io::Result<()>;

    /// A stored result. A damaged result that can be made again counts as missing.
    fn open(&self, id: &str, name: &str) -> io::Result<Box<dyn io::Read + Send>>;

    /// Makes durable that log and results of a job are there.
    fn sync(&self, id: &str) -> io::Result<()>;

    /// Removes log and results of a job; not being there is fine.
    fn remove(&self, id: &str) -> io::Result<()>;

    /// Identities of all jobs of which anything is kept here.
    fn jobs(&self) -> io::Result<Vec<String>>;
}

/// First bytes of a log file; the last byte is the version of the format. Checksums of the earlier version do not cover
/// the id of the job.
pub(crate) const MAGIC: &[u8; 8] = b"CPLOG\0\0\x02";
pub(crate) const EARLIER_MAGIC: &[u8; 8] = b"CPLOG\0\0\x01";

/// Whether the content is a log of this version or the earlier one.
pub(crate) fn is_log(content: &[u8]) -> bool {
    content.starts_with(MAGIC) || content.starts_with(EARLIER_MAGIC)
}

/// Bytes of a record's frame.
pub(crate) const FRAME: usize = 24;
/// Most events of a batch.
pub(crate) const BATCH_EVENTS: u64 = 256;
/// Bytes after which a batch is closed.
pub(crate) const BATCH_BYTES: usize = 32 * 1024;
/// Largest record that is believed when reading; larger ones are damage.
pub(crate) const RECORD_MAX: usize = 64 << 20;

/// The frame in front of an encoded batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BatchFrame {
    pub(crate) length: u32,
    pub(crate) crc: u32,
    pub(crate) first: u64,
    pub(crate) last: u64,
}

impl BatchFrame {
    pub(crate) fn of(sums: FileChecksum, body: &[u8], first: u64, last: u64) -> Self {
        Self { length: body.len() as u32, crc: sums.of_content(body), first, last }
    }

    pub(crate) fn to_bytes(self) -> [u8; FRAME] {
        let mut bytes = [0; FRAME];
        let parts = [&self.length.to_le_bytes()[..], &self.crc.to_le_bytes(), &self.first.to_le_bytes()];
        let values = parts.into_iter().flatten().copied().chain(self.last.to_le_bytes());
        for (slot, value) in bytes.iter_mut().zip(values) {
            *slot = value;
        }
        bytes
    }

    /// Reads a frame; `None` when there are not enough bytes.
    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let (length, rest) = bytes.split_first_chunk::<4>()?;
        let (crc, rest) = rest.split_first_chunk::<4>()?;
        let (first, rest) = rest.split_first_chunk::<8>()?;
        let (last, _) = rest.split_first_chunk::<8>()?;
        Some(Self {
            length: u32::from_le_bytes(*length),
            crc: u32::from_le_bytes(*crc),
            first: u64::from_le_bytes(*first),
            last: u64::from_le_bytes(*last),
        })
    }
}
