//! Marks of running jobs, in one file that is written in place: a run makes and removes no file.
//!
//! Each mark has its own slot, `<attempt> <id> <CRC-32 of both>`, followed by zeros. A `-` before the attempt means
//! that the run uses no processor time. Marks of earlier versions have no `-`, or no checksum. *Invariant:* a slot is
//! written by one write within a page, so a process that is killed leaves each slot in its old or its new state. Marks
//! are not made durable: they are needed after a crash, but not after a power loss, which no job has caused.

use std::collections::HashMap;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::disk::{Disk, DiskFile};
use super::named::PathContext as _;
use crate::host::RunMark;

/// Prefix of the attempt if the run uses no processor time.
const IDLE: &str = "-";
/// Bytes of a slot; a page holds a whole number of them.
const SLOT: usize = 128;

/// The marks of a data folder.
#[derive(Debug)]
pub(crate) struct MarkFile {
    disk: Disk,
    path: PathBuf,
    slots: Mutex<Slots>,
}

#[derive(Debug, Default)]
struct Slots {
    file: Option<DiskFile>,
    /// Slots and marks by job.
    taken: HashMap<String, (usize, RunMark)>,
    free: Vec<usize>,
    /// Slots that the file has.
    all: usize,
}

impl MarkFile {
    /// The marks in a file, which is made when the first mark is.
    pub(crate) fn of(path: &Path, disk: Disk) -> io::Result<Self> {
        let mut slots = Slots::default();
        let content = match disk.read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            other => other.at(path)?,
        };
        for slot in content.chunks(SLOT) {
            match read(slot) {
                Some(mark) => drop(slots.taken.insert(mark.id.clone(), (slots.all, mark))),
                None => slots.free.push(slots.all),
            }
            slots.all += 1;
        }
        Ok(Self { disk, path: path.to_owned(), slots: Mutex::new(slots) })
    }

    /// Marks a job as running.
    pub(crate) fn mark(&self, mark: &RunMark) -> io::Result<()> {
        let id = mark.id.as_str();
        let text = format!("{}{} {id}", if mark.works { "" } else { IDLE }, mark.attempt);
        let text = format!("{text} {:08x}", crc32fast::hash(text.as_bytes()));
        if text.len() >= SLOT || id.contains(['\0', ' ']) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("'{id}' cannot be the name of a job")));
        }
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = match slots.taken.get(id) {
            Some((slot, _)) => *slot,
            None => slots.free.pop().unwrap_or_else(|| {
                slots.all += 1;
                slots.all - 1
            }),
        };
        slots.taken.insert(id.to_owned(), (slot, mark.clone()));
        let written = self.write(&mut slots, slot, text.as_bytes());
        if written.is_err() {
            slots.taken.remove(id);
            slots.free.push(slot);
        }
        written
    }

    /// Removes the mark of a job. If the removal fails, the next server may run the job alone.
    pub(crate) fn unmark(&self, id: &str) {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((slot, _)) = slots.taken.remove(id) {
            let _ = self.write(&mut slots, slot, b"");
            slots.free.push(slot);
        }
    }

    fn write(&self, slots: &mut Slots, slot: usize, text: &[u8]) -> io::Result<()> {
        let file = match &mut slots.file {
            Some(file) => file,
            none => none.insert(self.disk.create_or_open(&self.path)?),
        };
        let mut content = [0; SLOT];
        content.iter_mut().zip(text).for_each(|(to, byte)| *to = *byte);
        file.seek(SeekFrom::Start((slot * SLOT) as u64))?;
        file.write_all(&content)
    }

    /// All marks.
    pub(crate) fn all(&self) -> Vec<RunMark> {
        let slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        slots.taken.values().map(|(_, mark)| mark.clone()).collect()
    }
}

/// The mark in a slot, if the slot has a valid mark.
fn read(slot: &[u8]) -> Option<RunMark> {
    let text = slot.split(|byte| *byte == 0).next().and_then(|text| std::str::from_utf8(text).ok())?;
    let text = match text.rsplit_once(' ') {
        Some((mark, crc)) if mark.contains(' ') => {
            Some(mark).filter(|mark| format!("{:08x}", crc32fast::hash(mark.as_bytes())) == crc)?
        }
        _ => text,
    };
    let (attempt, id) = text.split_once(' ')?;
    let idle = attempt.strip_prefix(IDLE);
    let attempt = idle.unwrap_or(attempt).parse().ok()?;
    Some(RunMark { id: id.to_owned(), attempt, works: idle.is_none() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(id: &str, attempt: u32) -> RunMark {
        RunMark { id: id.to_owned(), attempt, works: true }
    }

    fn sorted(marks: &MarkFile) -> Vec<RunMark> {
        let mut all = marks.all();
        all.sort();
        all
    }

    #[test]
    fn the_next_server_finds_what_was_marked_and_not_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("marks");
        let open = || MarkFile::of(&path, Disk::default()).unwrap();
        let marks = open();
        assert!(marks.all().is_empty() && !path.exists());
        for (id, attempt) in [("a", 1), ("b", 2), ("c", 30)] {
            marks.mark(&mark(id, attempt)).unwrap();
        }
        marks.mark(&mark("a", 4)).unwrap();
        marks.mark(&RunMark { works: false, ..mark("c", 30) }).unwrap();
        marks.unmark("b");
        marks.unmark("not there");
        let expected = [mark("a", 4), RunMark { works: false, ..mark("c", 30) }];
        assert_eq!((sorted(&marks), sorted(&open())), (expected.to_vec(), expected.to_vec()));
        // The place of a mark that was removed is used again.
        let next = open();
        next.unmark("c");
        (0..2).for_each(|n| next.mark(&mark(&format!("job-{n}"), 1)).unwrap());
        assert_eq!(path.metadata().unwrap().len(), 3 * SLOT as u64);
        next.unmark("a");
        assert_eq!(sorted(&open()), [mark("job-0", 1), mark("job-1", 1)]);
    }

    #[test]
    fn what_is_no_mark_is_a_free_slot() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("marks");
        let mut content = vec![0xff; SLOT];
        content.extend(b"7 x");
        content.resize(2 * SLOT, 0);
        content.extend(b"cut");
        std::fs::write(&path, content).unwrap();
        let marks = MarkFile::of(&path, Disk::default()).unwrap();
        assert_eq!(marks.all(), [mark("x", 7)]);
        marks.mark(&mark("y", 1)).unwrap();
        marks.mark(&mark("z", 1)).unwrap();
        assert_eq!(sorted(&MarkFile::of(&path, Disk::default()).unwrap()).len(), 3);
        assert!(marks.mark(&mark(&"long".repeat(50), 1)).is_err());
    }
}
