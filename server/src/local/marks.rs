//! Marks of running jobs, in one file that is written in place: a run makes and removes no file.
//!
//! A mark lies in a slot of its own, `<attempt> <id> <CRC-32 of both>`, followed by zeros; marks of earlier versions
//! have no checksum. *Invariant:* a slot is written by one write
//! within a page, so a process that is killed leaves each slot in its old or its new state. Nothing is made durable:
//! the marks are for the server after one that died, not for one after a power loss, which no job has caused.

use std::collections::HashMap;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::disk::{Disk, Written};
use super::named::Named as _;

/// Bytes of a slot; a page holds a whole number of them.
const SLOT: usize = 128;

/// The marks of a data folder.
#[derive(Debug)]
pub(crate) struct Marks {
    disk: Disk,
    path: PathBuf,
    slots: Mutex<Slots>,
}

#[derive(Debug, Default)]
struct Slots {
    file: Option<Written>,
    /// Slot and number of the run by job.
    taken: HashMap<String, (usize, u32)>,
    free: Vec<usize>,
    /// Slots that the file has.
    all: usize,
}

impl Marks {
    /// The marks in a file, which is made when the first mark is.
    pub(crate) fn of(path: &Path, disk: Disk) -> io::Result<Self> {
        let mut slots = Slots::default();
        let content = match disk.read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            other => other.at(path)?,
        };
        for slot in content.chunks(SLOT) {
            match read(slot) {
                Some((id, attempt)) => drop(slots.taken.insert(id, (slots.all, attempt))),
                None => slots.free.push(slots.all),
            }
            slots.all += 1;
        }
        Ok(Self { disk, path: path.to_owned(), slots: Mutex::new(slots) })
    }

    /// Marks a job as running, with the number of its run.
    pub(crate) fn mark(&self, id: &str, attempt: u32) -> io::Result<()> {
        let text = format!("{attempt} {id}");
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
        slots.taken.insert(id.to_owned(), (slot, attempt));
        let written = self.write(&mut slots, slot, text.as_bytes());
        if written.is_err() {
            slots.taken.remove(id);
            slots.free.push(slot);
        }
        written
    }

    /// Removes the mark of a job. One that stays makes the next server run the job alone.
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

    /// Jobs that are marked, with the numbers of their runs.
    pub(crate) fn all(&self) -> Vec<(String, u32)> {
        let slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        slots.taken.iter().map(|(id, (_, attempt))| (id.clone(), *attempt)).collect()
    }
}

/// Job and number of its run, if a slot holds a mark.
fn read(slot: &[u8]) -> Option<(String, u32)> {
    let text = slot.split(|byte| *byte == 0).next().and_then(|text| std::str::from_utf8(text).ok())?;
    let text = match text.rsplit_once(' ') {
        Some((mark, crc)) if mark.contains(' ') => {
            Some(mark).filter(|mark| format!("{:08x}", crc32fast::hash(mark.as_bytes())) == crc)?
        }
        _ => text,
    };
    let (attempt, id) = text.split_once(' ')?;
    Some((id.to_owned(), attempt.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorted(marks: &Marks) -> Vec<(String, u32)> {
        let mut all = marks.all();
        all.sort();
        all
    }

    #[test]
    fn the_next_server_finds_what_was_marked_and_not_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("marks");
        let open = || Marks::of(&path, Disk::default()).unwrap();
        let marks = open();
        assert!(marks.all().is_empty() && !path.exists());
        for (id, attempt) in [("a", 1), ("b", 2), ("c", 30)] {
            marks.mark(id, attempt).unwrap();
        }
        marks.mark("a", 4).unwrap();
        marks.unmark("b");
        marks.unmark("not there");
        let expected = [("a".to_owned(), 4), ("c".to_owned(), 30)];
        assert_eq!((sorted(&marks), sorted(&open())), (expected.to_vec(), expected.to_vec()));
        // The place of a mark that was removed is used again.
        let next = open();
        next.unmark("c");
        (0..2).for_each(|n| next.mark(&format!("job-{n}"), 1).unwrap());
        assert_eq!(path.metadata().unwrap().len(), 3 * SLOT as u64);
        next.unmark("a");
        assert_eq!(sorted(&open()), [("job-0".to_owned(), 1), ("job-1".to_owned(), 1)]);
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
        let marks = Marks::of(&path, Disk::default()).unwrap();
        assert_eq!(marks.all(), [("x".to_owned(), 7)]);
        marks.mark("y", 1).unwrap();
        marks.mark("z", 1).unwrap();
        assert_eq!(sorted(&Marks::of(&path, Disk::default()).unwrap()).len(), 3);
        assert!(marks.mark(&"long".repeat(50), 1).is_err());
    }
}
