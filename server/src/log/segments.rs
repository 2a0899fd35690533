//! The compressed form of a log that has ended.
//!
//! File: magic, then segments, then an entry for each segment, then their number and the magic again. A segment is a
//! part of the plain file, cut between records and compressed by LZ4 (or as it is where that would not make it
//! smaller); the first one is the head. An entry is 40 bytes, little-endian: where the segment begins in the plain file
//! and in this one, its first event, its length plain and here, its CRC-32, and the CRC-32 of the entry. Invariant:
//! read, it is the plain file, byte for byte; one segment and one entry are in memory.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::damage::damage;
use super::sums::FileChecksum;
use super::{BatchFrame, FRAME, MAGIC as LOG, RECORD_MAX};

const MAGIC: &[u8; 8] = b"CPSEG\0\0\x01";
/// Bytes after which a segment is closed.
const SEGMENT: usize = 128 * 1024;
const ENTRY: usize = 40;
/// Number of segments and magic.
const END: usize = 16;

/// Data of a segment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct SegmentEntry {
    /// Where it begins in the plain file.
    plain: u64,
    /// Where it begins in this file.
    at: u64,
    /// Number of its first event; 0 = head.
    first: u64,
    /// Bytes in the plain file.
    length: u32,
    /// Bytes in this file; as many as in the plain one = not compressed.
    packed: u32,
    crc: u32,
}

impl SegmentEntry {
    fn to_bytes(self) -> Vec<u8> {
        let mut bytes: Vec<u8> = [self.plain, self.at, self.first].into_iter().flat_map(u64::to_le_bytes).collect();
        bytes.extend([self.length, self.packed, self.crc].into_iter().flat_map(u32::to_le_bytes));
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    fn read(bytes: &[u8; ENTRY]) -> Option<Self> {
        let (fields, crc) = bytes.split_last_chunk::<4>()?;
        if crc32fast::hash(fields) != u32::from_le_bytes(*crc) {
            return None;
        }
        let long = |at: usize| fields.get(at..)?.first_chunk().map(|bytes| u64::from_le_bytes(*bytes));
        let short = |at: usize| fields.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
        Some(Self {
            plain: long(0)?,
            at: long(8)?,
            first: long(16)?,
            length: short(24)?,
            packed: short(28)?,
            crc: short(32)?,
        })
    }

    /// Behind its last byte in the plain file.
    fn end(&self) -> u64 {
        self.plain + u64::from(self.length)
    }
}

/// Writes segments.
struct Packer<'a> {
    out: &'a mut dyn Write,
    written: u64,
    entries: Vec<SegmentEntry>,
    /// The open segment, its first event, and where it begins in the plain file.
    segment: Vec<u8>,
    first: u64,
    plain: u64,
    packed: Vec<u8>,
}

impl Packer<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.written += bytes.len() as u64;
        Ok(())
    }

    fn close(&mut self) -> io::Result<()> {
        let (segment, mut packed) = (std::mem::take(&mut self.segment), std::mem::take(&mut self.packed));
        packed.resize(lz4_flex::block::get_maximum_output_size(segment.len()), 0);
        let length = lz4_flex::block::compress_into(&segment, &mut packed).map_err(io::Error::other)?;
        packed.truncate(length);
        let stored = if packed.len() < segment.len() { &packed } else { &segment };
        self.entries.push(SegmentEntry {
            plain: self.plain,
            at: self.written,
            first: self.first,
            length: segment.len() as u32,
            packed: stored.len() as u32,
            crc: crc32fast::hash(stored),
        });
        self.write(stored)?;
        self.plain += segment.len() as u64;
        (self.segment, self.packed) = (segment, packed);
        self.segment.clear();
        Ok(())
    }
}

/// Writes the compressed form of the plain log of a job that has ended; returns its size in bytes.
///
/// # Errors
/// When the log cannot be read to its end or is damaged, or when the other file cannot be written.
pub(crate) fn pack(job: &str, log: &mut dyn Read, out: &mut dyn Write) -> io::Result<u64> {
    let mut packer = Packer {
        out,
        written: 0,
        entries: Vec::new(),
        segment: Vec::with_capacity(2 * SEGMENT),
        first: 0,
        plain: 0,
        packed: Vec::new(),
    };
    packer.write(MAGIC)?;
    let mut magic = [0; LOG.len()];
    log.read_exact(&mut magic)?;
    let sums = FileChecksum::of_magic(job, &magic).ok_or_else(|| damage("its head is not valid"))?;
    packer.segment.extend_from_slice(&magic);
    // The head, then every record.
    let mut frame = [0; FRAME];
    while fill(log, &mut frame)? {
        let read = BatchFrame::read(&frame).filter(|read| read.length as usize <= RECORD_MAX);
        let Some(read) = read else { return Err(damage("a record is too long")) };
        if packer.segment.is_empty() {
            packer.first = read.first;
        }
        packer.segment.extend_from_slice(&frame);
        let body = packer.segment.len();
        packer.segment.resize(body + read.length as usize, 0);
        log.read_exact(packer.segment.get_mut(body..).unwrap_or_default())?;
        if sums.of_content(packer.segment.get(body..).unwrap_or_default()) != read.crc {
            return Err(damage("a checksum is wrong"));
        }
        if packer.entries.is_empty() || packer.segment.len() >= SEGMENT {
            packer.close()?;
        }
    }
    if !packer.segment.is_empty() {
        packer.close()?;
    }
    let count = packer.entries.len() as u64;
    for entry in std::mem::take(&mut packer.entries) {
        packer.write(&entry.to_bytes())?;
    }
    packer.write(&count.to_le_bytes())?;
    packer.write(MAGIC)?;
    Ok(packer.written)
}

/// Reads as many bytes as there is room for; `false` at the end of the file.
fn fill(log: &mut dyn Read, room: &mut [u8]) -> io::Result<bool> {
    let mut done = 0;
    while let Some(rest) = room.get_mut(done..).filter(|rest| !rest.is_empty()) {
        match log.read(rest) {
            Ok(0) if done == 0 => return Ok(false),
            Ok(0) => return Err(damage("it is cut short")),
            Ok(read) => done += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(true)
}

/// A log in its compressed form, read as the plain one.
#[derive(Debug)]
pub(crate) struct CompressedLog<F = File> {
    file: F,
    /// Number of segments, and where their entries begin.
    count: u64,
    entries: u64,
    length: u64,
    /// The segment in memory.
    number: u64,
    entry: SegmentEntry,
    segment: Vec<u8>,
    /// Position in the plain file.
    at: u64,
}

impl CompressedLog {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        Self::of(File::open(path)?)
    }
}

impl<F: Read + Seek> CompressedLog<F> {
    fn of(mut file: F) -> io::Result<Self> {
        let size = file.seek(SeekFrom::End(0))?;
        let mut end = [0; END];
        let begin = size.checked_sub(END as u64).ok_or_else(|| damage("it is cut short"))?;
        file.seek(SeekFrom::Start(begin))?;
        file.read_exact(&mut end)?;
        let (count, magic) = end.split_first_chunk::<8>().ok_or_else(|| damage("it is cut short"))?;
        let count = u64::from_le_bytes(*count);
        let entries = count.checked_mul(ENTRY as u64).and_then(|bytes| begin.checked_sub(bytes));
        let Some(entries) = entries.filter(|_| magic == MAGIC && count > 0) else {
            return Err(damage("the end of its segments is not one"));
        };
        let (number, segment) = (u64::MAX, Vec::new());
        let mut segments =
            Self { file, count, entries, length: 0, number, entry: SegmentEntry::default(), segment, at: 0 };
        segments.length = segments.entry(count - 1)?.end();
        Ok(segments)
    }

    /// Checks the beginning of the file, which no reader needs.
    ///
    /// # Errors
    /// When it is not that of a compressed log, or cannot be read.
    pub(crate) fn check_beginning(&mut self) -> io::Result<()> {
        let mut magic = [0; MAGIC.len()];
        self.file.seek(SeekFrom::Start(0))?;
        self.file.read_exact(&mut magic)?;
        if magic == *MAGIC { Ok(()) } else { Err(damage("its first 8 bytes are not those of a compressed log")) }
    }

    /// Bytes of the plain file.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    fn entry(&mut self, number: u64) -> io::Result<SegmentEntry> {
        let mut bytes = [0; ENTRY];
        self.file.seek(SeekFrom::Start(self.entries + number * ENTRY as u64))?;
        self.file.read_exact(&mut bytes)?;
        SegmentEntry::read(&bytes).ok_or_else(|| damage("an entry of its segments has a wrong checksum"))
    }

    /// Number of the last segment that `begins` at or before the target; segments ascend.
    fn last(&mut self, begins: impl Fn(&SegmentEntry) -> bool) -> io::Result<u64> {
        let (mut from, mut to) = (0, self.count - 1);
        while from < to {
            let middle = from + (to - from).div_ceil(2);
            match begins(&self.entry(middle)?) {
                true => from = middle,
                false => to = middle - 1,
            }
        }
        Ok(from)
    }

    /// Where the segment with the first event after `after` begins in the plain file.
    pub(crate) fn place(&mut self, after: u64) -> io::Result<u64> {
        let number = self.last(|entry| entry.first <= after.saturating_add(1))?;
        Ok(self.entry(number)?.plain)
    }

    /// Drops the segment in memory.
    pub(crate) fn rest(&mut self) {
        (self.number, self.segment) = (u64::MAX, Vec::new());
    }

    /// Has the segment with the position in memory.
    fn load(&mut self) -> io::Result<()> {
        let within = |entry: &SegmentEntry, at: u64| (entry.plain..entry.end()).contains(&at);
        if self.number < self.count && within(&self.entry, self.at) {
            return Ok(());
        }
        let at = self.at;
        let next = self.number.wrapping_add(1);
        let next = if next < self.count {
            Some(self.entry(next)?).filter(|entry| within(entry, at)).map(|_| next)
        } else {
            None
        };
        let number = match next {
            Some(next) => next,
            None => self.last(|entry| entry.plain <= at)?,
        };
        self.number = u64::MAX;
        let entry = self.entry(number)?;
        if entry.length as usize > 2 * RECORD_MAX || entry.packed > entry.length {
            return Err(damage("an entry of its segments is not one"));
        }
        let mut packed = vec![0; entry.packed as usize];
        self.file.seek(SeekFrom::Start(entry.at))?;
        self.file.read_exact(&mut packed)?;
        if crc32fast::hash(&packed) != entry.crc {
            return Err(damage("a segment has a wrong checksum"));
        }
        if entry.packed == entry.length {
            self.segment = packed;
        } else {
            self.segment.resize(entry.length as usize, 0);
            let length = lz4_flex::block::decompress_into(&packed, &mut self.segment);
            if length.ok() != Some(self.segment.len()) {
                return Err(damage("a segment cannot be read"));
            }
        }
        (self.number, self.entry) = (number, entry);
        Ok(())
    }
}

impl<F: Read + Seek> Read for CompressedLog<F> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.at >= self.length || out.is_empty() {
            return Ok(0);
        }
        self.load()?;
        let from = usize::try_from(self.at - self.entry.plain).unwrap_or(usize::MAX);
        let part = self.segment.get(from..).unwrap_or_default();
        let count = part.len().min(out.len());
        if let (Some(to), Some(part)) = (out.get_mut(..count), part.get(..count)) {
            to.copy_from_slice(part);
        }
        self.at += count as u64;
        Ok(count)
    }
}

impl<F: Read + Seek> Seek for CompressedLog<F> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
        };
        self.at = at.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests;
