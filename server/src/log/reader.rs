//! Reads a log, live or ended, by cursor.
//!
//! Invariant: a reader holds no lock and no more than one piece of the file; a slow one costs nothing but that.

use std::io::{self, Read, Seek, SeekFrom};
use std::sync::Arc;

use bytes::{Buf, Bytes, BytesMut};
use counterpoint_kernel::log::event::Event;
use counterpoint_proto::v1::JobDescription;
use prost::Message as _;

use super::damage::{cut_short, damage, of_job};
use super::kept::{Input, StoredLog};
use super::sums::FileChecksum;
use super::{BatchFrame, FRAME, MAGIC, RECORD_MAX, decode, encode};

/// Bytes read at once. A client that does not read holds the piece of its last batch.
const PIECE: usize = 24 * 1024;

/// An encoded batch with the numbers it covers.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    pub(crate) first: u64,
    pub(crate) last: u64,
    pub(crate) body: Bytes,
    /// Its record in the file.
    pub(crate) spot: ResumePoint,
}

/// A record of a log, from which reading can continue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ResumePoint {
    at: u64,
    sums: FileChecksum,
}

/// A place in a log.
#[derive(Debug)]
pub(crate) struct LogReader {
    job: Arc<str>,
    sums: FileChecksum,
    file: Box<dyn Input>,
    description: JobDescription,
    /// Bytes read and not yet handed out.
    piece: BytesMut,
    /// Offset in the file behind `piece`.
    read: u64,
    /// The file's content ends here as far as known.
    limit: u64,
    after: u64,
}

impl LogReader {
    /// Opens a log whose head has been written; batches up to number `after` are skipped.
    pub(crate) fn open(log: &StoredLog, after: u64) -> io::Result<Self> {
        Self::at_head(log, after).map_err(|error| of_job(error, &log.job))
    }

    fn at_head(log: &StoredLog, after: u64) -> io::Result<Self> {
        let mut file = log.open()?;
        let mut head = [0; MAGIC.len() + FRAME];
        let cut = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => damage("its head is cut short"),
            _ => error,
        };
        file.read_exact(&mut head).map_err(cut)?;
        let (magic, frame) = head.split_at(MAGIC.len());
        let known = FileChecksum::of_magic(&log.job, magic).zip(BatchFrame::read(frame));
        let (sums, frame) = known.ok_or_else(|| damage("its head is not valid"))?;
        let mut description = vec![0; (frame.length as usize).min(RECORD_MAX)];
        file.read_exact(&mut description).map_err(cut)?;
        if sums.of_content(&description) != frame.crc || description.len() != frame.length as usize {
            return Err(damage("its description has a wrong checksum"));
        }
        let description =
            JobDescription::decode(description.as_slice()).map_err(|_| damage("its description cannot be read"))?;
        let mut read = (head.len() + frame.length as usize) as u64;
        if after > 0
            && let Some(place) = file.place(after)?.filter(|place| *place > read)
        {
            read = file.seek(SeekFrom::Start(place))?;
        }
        Ok(Self { job: log.job.clone(), sums, file, description, piece: BytesMut::new(), read, limit: read, after })
    }

    /// Opens a log again at a record; its description is not read.
    pub(crate) fn resume(log: &StoredLog, ResumePoint { at, sums }: ResumePoint, after: u64) -> io::Result<Self> {
        let mut file = log.open().map_err(|error| of_job(error, &log.job))?;
        file.seek(SeekFrom::Start(at))?;
        let (job, description) = (log.job.clone(), JobDescription::default());
        Ok(Self { job, sums, file, description, piece: BytesMut::new(), read: at, limit: at, after })
    }

    /// Opens an ended log, to be read to the end of the file.
    pub(crate) fn open_ended(log: &StoredLog, after: u64) -> io::Result<Self> {
        let mut reader = Self::open(log, after)?;
        reader.limit = log.length().map_err(|error| of_job(error, &log.job))?;
        Ok(reader)
    }

    pub(crate) fn description(&self) -> &JobDescription {
        &self.description
    }

    /// Reading takes no time.
    pub(crate) fn in_memory(&self) -> bool {
        self.file.in_memory()
    }

    /// Allows reading up to a committed position.
    pub(crate) fn extend(&mut self, limit: u64) {
        self.limit = self.limit.max(limit);
    }

    /// Keeps nothing in memory but its place and the part of the next record that has been read.
    pub(crate) fn rest(&mut self) {
        self.file.rest();
        self.piece = BytesMut::from(self.piece.as_ref());
    }

    /// Next batch after the cursor; `None` at the end of the readable part.
    pub(crate) fn next_batch(&mut self) -> io::Result<Option<Batch>> {
        self.batch().map_err(|error| of_job(error, &self.job))
    }

    fn batch(&mut self) -> io::Result<Option<Batch>> {
        loop {
            if !self.fill(FRAME)? {
                return Ok(None);
            }
            let frame = BatchFrame::read(&self.piece).ok_or_else(|| damage("a frame cannot be read"))?;
            let length = frame.length as usize;
            if length > RECORD_MAX {
                return Err(damage("a record is too long"));
            }
            if frame.last <= self.after {
                self.skip(FRAME + length)?;
                continue;
            }
            if !self.fill(FRAME + length)? {
                return Ok(None);
            }
            let spot = ResumePoint { at: self.read - self.piece.len() as u64, sums: self.sums };
            self.piece.advance(FRAME);
            let body = self.piece.split_to(length).freeze();
            if self.sums.of_content(&body) != frame.crc || !decode::spans(&body, frame.first, frame.last) {
                return Err(damage("a checksum is wrong"));
            }
            if frame.first > self.after.saturating_add(1) {
                return Err(damage(&format!("events {} to {} are missing", self.after + 1, frame.first - 1)));
            }
            let after = std::mem::replace(&mut self.after, frame.last);
            let batch = Batch { first: frame.first, last: frame.last, body, spot };
            return Ok(Some(if frame.first <= after { behind(batch, after) } else { batch }));
        }
    }

    /// Makes at least `need` bytes available; `false` when the readable part ends before.
    fn fill(&mut self, need: usize) -> io::Result<bool> {
        while self.piece.len() < need {
            let left = usize::try_from(self.limit.saturating_sub(self.read)).unwrap_or(usize::MAX);
            let want = left.min(PIECE.max(need - self.piece.len()));
            if want == 0 {
                if self.piece.is_empty() {
                    // Nothing is held for a reader that waits.
                    self.piece = BytesMut::new();
                }
                return Ok(false);
            }
            let old = self.piece.len();
            self.piece.resize(old + want, 0);
            let got = self.file.read(self.piece.get_mut(old..).unwrap_or_default())?;
            self.piece.truncate(old + got);
            self.read += got as u64;
            if got == 0 {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn skip(&mut self, count: usize) -> io::Result<()> {
        if let Some(beyond) = count.checked_sub(self.piece.len()) {
            self.piece.clear();
            self.read += beyond as u64;
            self.file.seek(SeekFrom::Start(self.read))?;
        } else {
            self.piece.advance(count);
        }
        Ok(())
    }
}

/// The part of a batch behind a cursor that lies inside it.
fn behind(batch: Batch, after: u64) -> Batch {
    let mut body = Vec::with_capacity(batch.body.len());
    encode::varint_field(&mut body, 1, after + 1);
    encode::varint_field(&mut body, 2, batch.last);
    decode::events(&batch.body).filter(|event| decode::seq(event) > after).for_each(|e| encode::encoded(&mut body, e));
    Batch { first: after + 1, last: batch.last, body: Bytes::from(body), spot: batch.spot }
}

/// Whether the client that waits for a read has disconnected.
pub(crate) type Gone = Arc<dyn Fn() -> bool + Send + Sync>;

/// All events of an ended log, decoded. Ends early on damage, which [`Events::error`] then tells.
pub(crate) struct Events {
    reader: LogReader,
    batch: std::vec::IntoIter<(u64, Event)>,
    last: u64,
    expected: u64,
    gone: Option<Gone>,
    error: Option<io::Error>,
}

impl Events {
    /// Of a log whose last event has the number `expected`.
    pub(crate) fn new(reader: LogReader, expected: u64) -> Self {
        Self { reader, batch: Vec::new().into_iter(), last: 0, expected, gone: None, error: None }
    }

    /// The same events, up to the batch after which the client has disconnected.
    pub(crate) fn until(self, gone: Gone) -> Self {
        Self { gone: Some(gone), ..self }
    }

    /// The error that ended the iteration before the end of the log.
    pub(crate) fn error(self) -> Option<io::Error> {
        self.error
    }

    fn load(&mut self) -> io::Result<bool> {
        if self.gone.as_ref().is_some_and(|gone| gone()) {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let Some(batch) = self.reader.next_batch()? else {
            let job = &self.reader.job;
            return if self.last < self.expected { Err(cut_short(job, self.last, self.expected)) } else { Ok(false) };
        };
        self.last = batch.last;
        let events: Option<Vec<_>> = decode::events(&batch.body).map(decode::event).collect();
        let unreadable = || of_job(damage("an event cannot be read"), &self.reader.job);
        self.batch = events.ok_or_else(unreadable)?.into_iter();
        Ok(true)
    }
}

impl Iterator for Events {
    type Item = (u64, Event);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(item) = self.batch.next() {
                return Some(item);
            }
            match self.load() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error) => {
                    self.error = Some(error);
                    return None;
                }
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::log::codec_tests;
    use crate::log::{BATCH_EVENTS, EARLIER_MAGIC, encode};

    /// The plain log of a job with this number of events.
    pub(crate) fn plain(job: &str, events: u64) -> Vec<u8> {
        of_form(MAGIC, FileChecksum::of_log(job), events)
    }

    /// The same log as an earlier version wrote it.
    pub(crate) fn earlier(events: u64) -> Vec<u8> {
        of_form(EARLIER_MAGIC, FileChecksum::EARLIER, events)
    }

    fn of_form(magic: &[u8], sums: FileChecksum, events: u64) -> Vec<u8> {
        let description = JobDescription::default().encode_to_vec();
        let mut log = magic.to_vec();
        log.extend(BatchFrame::of(sums, &description, 0, 0).to_bytes());
        log.extend(&description);
        let kinds = codec_tests::events();
        let mut first = 1;
        while first <= events {
            let last = events.min(first + BATCH_EVENTS - 1);
            let mut body = Vec::new();
            encode::varint_field(&mut body, 1, first);
            (first..=last).zip(kinds.iter().cycle()).for_each(|(seq, event)| encode::event(&mut body, seq, event, 4));
            encode::varint_field(&mut body, 2, last);
            log.extend(BatchFrame::of(sums, &body, first, last).to_bytes());
            log.extend(&body);
            first = last + 1;
        }
        log
    }
}
