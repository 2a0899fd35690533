//! Writes the log of a running job.
//!
//! Records are gathered and written together: after 256 KiB, with the first call later than 10 ms after the last write
//! (unless the log is small and unwatched), or a few ms after they arrived if a client watches. Invariant: readers
//! learn of bytes only after they are in the file.

use std::fmt::Debug;
use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use counterpoint_kernel::log::event::{Event, MAX_AXES};
use counterpoint_kernel::log::info::Info;

use super::sums::FileChecksum;
use super::tail::Tail;
use super::{BATCH_BYTES, BATCH_EVENTS, BatchFrame, FRAME, MAGIC, encode};

const WRITE_BYTES: usize = 256 * 1024;
const WRITE_EVERY: Duration = Duration::from_millis(10);

/// Largest log that becomes a row of the ledger instead of a file, bytes.
const SMALL: usize = 16 * 1024;

/// Where a log goes.
pub(crate) trait LogDestination: Send + Debug {
    /// Appends bytes.
    fn write(&mut self, content: &[u8]) -> io::Result<()>;

    /// Whether anything has been written.
    fn used(&self) -> bool;

    /// Brings a log that has ended into the form in which it stays; returns its bytes.
    fn pack(&mut self) -> io::Result<u64>;

    /// Makes it durable except for the names of its files.
    fn seal(self: Box<Self>) -> io::Result<()>;
}

/// A log that has ended.
#[derive(Debug)]
pub(crate) enum FinishedLog {
    /// It has no file.
    Small(Small),
    /// It is to be sealed.
    Placed(Box<dyn LogDestination>),
}

/// A log that has no file.
#[derive(Debug)]
pub(crate) struct Small {
    pub(crate) bytes: Bytes,
    pub(crate) last_seq: u64,
}

/// The one writer of a log.
#[derive(Debug)]
pub(crate) struct Writer {
    place: Box<dyn LogDestination>,
    sums: FileChecksum,
    tail: Arc<Tail>,
    /// Axes by channel number.
    axes: Vec<usize>,
    /// Closed records and the open one, not yet written.
    buffer: Vec<u8>,
    /// Where the open record begins in `buffer`, and its first event.
    open: Option<(usize, u64)>,
    bytes: u64,
    last_seq: u64,
    written: Instant,
}

impl Writer {
    /// Starts the log of a job at a place. The head contains the encoded description of the job.
    pub(crate) fn new(
        job: &str,
        place: Box<dyn LogDestination>,
        tail: Arc<Tail>,
        info: &Info,
        description: &[u8],
    ) -> Self {
        let mut axes = Vec::new();
        for channel in &info.channels {
            let number = usize::from(channel.number);
            if axes.len() <= number {
                axes.resize(number + 1, MAX_AXES);
            }
            if let Some(slot) = axes.get_mut(number) {
                *slot = channel.axes.len();
            }
        }
        Self { axes, ..Self::of_copy(job, place, tail, description) }
    }

    /// Starts the log of a job that receives unchanged copies of another job's events.
    pub(crate) fn of_copy(job: &str, place: Box<dyn LogDestination>, tail: Arc<Tail>, description: &[u8]) -> Self {
        let sums = FileChecksum::of_log(job);
        let axes = Vec::new();
        // It grows with its log: most are small.
        let mut buffer = Vec::with_capacity(SMALL / 2);
        buffer.extend_from_slice(MAGIC);
        buffer.extend_from_slice(&BatchFrame::of(sums, description, 0, 0).to_bytes());
        buffer.extend_from_slice(description);
        Self { place, sums, tail, axes, buffer, open: None, bytes: 0, last_seq: 0, written: Instant::now() }
    }

    /// Appends events in log order.
    pub(crate) fn append(&mut self, first_seq: u64, batch: &[Event]) -> io::Result<()> {
        for (seq, event) in (first_seq..).zip(batch) {
            let (start, first) = match self.open {
                Some(open) => open,
                None => self.open_record(seq),
            };
            let axes = self.axes.get(usize::from(event.channel)).copied().unwrap_or(MAX_AXES);
            encode::event(&mut self.buffer, seq, event, axes);
            self.last_seq = seq;
            if seq - first + 1 >= BATCH_EVENTS || self.buffer.len() - start >= BATCH_BYTES {
                self.close_record();
                if self.buffer.len() >= WRITE_BYTES {
                    self.write()?;
                }
            }
        }
        self.flush_old()
    }

    /// Appends an encoded batch after the existing events.
    pub(crate) fn copy(&mut self, first: u64, last: u64, body: &[u8]) -> io::Result<()> {
        self.close_record();
        self.buffer.extend_from_slice(&BatchFrame::of(self.sums, body, first, last).to_bytes());
        self.buffer.extend_from_slice(body);
        self.last_seq = last;
        if self.buffer.len() >= WRITE_BYTES { self.write() } else { self.flush_old() }
    }

    /// Bytes of the log, written or not.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes + self.buffer.len() as u64
    }

    /// Writes events that have been gathered for long enough. A small log without followers may not need a file.
    fn flush_old(&mut self) -> io::Result<()> {
        let small = self.buffer.len() <= SMALL && !self.place.used() && !self.tail.followed();
        if !small && self.written.elapsed() >= WRITE_EVERY && !self.buffer.is_empty() { self.flush() } else { Ok(()) }
    }

    /// Writes everything, unless the log is small and nothing of it has been written.
    pub(crate) fn finish(mut self) -> io::Result<FinishedLog> {
        self.close_record();
        if !self.place.used() && self.buffer.len() <= SMALL {
            return Ok(FinishedLog::Small(Small { bytes: self.buffer.into(), last_seq: self.last_seq }));
        }
        self.write()?;
        Ok(FinishedLog::Placed(self.place))
    }

    /// Whether events have not been written yet.
    pub(crate) fn unwritten(&self) -> bool {
        self.open.is_some() || !self.buffer.is_empty()
    }

    /// Writes everything.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.close_record();
        if self.buffer.is_empty() { Ok(()) } else { self.write() }
    }

    fn open_record(&mut self, seq: u64) -> (usize, u64) {
        let start = self.buffer.len();
        self.buffer.extend_from_slice(&[0; FRAME]);
        encode::varint_field(&mut self.buffer, 1, seq);
        self.open = Some((start, seq));
        (start, seq)
    }

    fn close_record(&mut self) {
        let Some((start, first)) = self.open.take() else { return };
        encode::varint_field(&mut self.buffer, 2, self.last_seq);
        let frame =
            BatchFrame::of(self.sums, self.buffer.get(start + FRAME..).unwrap_or_default(), first, self.last_seq);
        if let Some(slot) = self.buffer.get_mut(start..start + FRAME) {
            slot.copy_from_slice(&frame.to_bytes());
        }
    }

    fn write(&mut self) -> io::Result<()> {
        self.place.write(&self.buffer)?;
        self.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        self.tail.set(self.bytes, self.last_seq);
        self.written = Instant::now();
        Ok(())
    }
}
