//! The ledger's file as its database sees it: the file itself, or, while the file cannot be written, its last durable
//! state with changes kept in memory.
//!
//! Invariant: [`Frozen`] never writes the file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use redb::StorageBackend;
use redb::backends::FileBackend;

use crate::local::disk::{Disk, DiskOperation};
use crate::local::named::PathContext as _;

const PAGE: u64 = 4096;

/// The file, written through the seam.
#[derive(Debug)]
pub(crate) struct LedgerFile {
    inner: FileBackend,
    disk: Disk,
    path: PathBuf,
}

impl LedgerFile {
    /// Opens the file or creates an empty one. Its content and its name are made durable first: a previous server, a
    /// failed sync, or a compaction may have left changes that a loss of power would undo.
    pub(crate) fn open(disk: &Disk, path: &Path) -> io::Result<Self> {
        disk.step(DiskOperation::Create, path).at(path)?;
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path).at(path)?;
        disk.owner().give(&file).at(path)?;
        disk.step(DiskOperation::Sync, path).at(path)?;
        file.sync_data().at(path)?;
        if let Some(folder) = path.parent() {
            disk.sync_folder(folder).at(folder)?;
        }
        let inner = FileBackend::new(file).map_err(io::Error::other)?;
        Ok(Self { inner, disk: disk.clone(), path: path.to_owned() })
    }
}

impl StorageBackend for LedgerFile {
    fn len(&self) -> io::Result<u64> {
        self.inner.len()
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.inner.read(offset, out)
    }

    fn set_len(&self, len: u64) -> io::Result<()> {
        self.disk.step(DiskOperation::Resize(len), &self.path).and_then(|_| self.inner.set_len(len)).at(&self.path)
    }

    fn sync_data(&self) -> io::Result<()> {
        self.disk.step(DiskOperation::Sync, &self.path).and_then(|_| self.inner.sync_data()).at(&self.path)
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        let written =
            self.disk.step(DiskOperation::Write(data.len()), &self.path).and_then(|most| match data.get(..most) {
                Some(part) if part.len() < data.len() => {
                    self.inner.write(offset, part)?;
                    Err(io::ErrorKind::StorageFull.into())
                }
                _ => self.inner.write(offset, data),
            });
        written.at(&self.path)
    }

    fn close(&self) -> io::Result<()> {
        self.inner.close()
    }
}

/// The file unchanged, with changes in memory only: repairs by the database on opening stay there.
#[derive(Debug)]
pub(crate) struct Frozen(Mutex<Pages>);

#[derive(Debug)]
struct Pages {
    file: File,
    /// Bytes of the file that are still valid.
    kept: u64,
    length: u64,
    changed: BTreeMap<u64, Vec<u8>>,
}

impl Frozen {
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path).at(path)?;
        let length = file.metadata().at(path)?.len();
        Ok(Self(Mutex::new(Pages { file, kept: length, length, changed: BTreeMap::new() })))
    }

    /// Same with the length that its head tells, if that is not far from its own: the file was cut or has grown.
    pub(crate) fn of_its_length(path: &Path) -> io::Result<Self> {
        let (frozen, mut head) = (Self::open(path)?, [0; HEAD]);
        frozen.read(0, &mut head)?;
        let own = frozen.len()?;
        if let Some(told) =
            told_length(&head).filter(|told| *told != own && *told > PAGE && *told / 2 <= own.max(LEAST))
        {
            frozen.set_len(told)?;
        }
        Ok(frozen)
    }

    fn pages(&self) -> std::sync::MutexGuard<'_, Pages> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Pages {
    /// A page as it is now.
    fn page(&mut self, number: u64) -> io::Result<Vec<u8>> {
        if let Some(page) = self.changed.get(&number) {
            return Ok(page.clone());
        }
        let mut page = vec![0; PAGE as usize];
        let start = number * PAGE;
        let known = self.kept.saturating_sub(start).min(PAGE) as usize;
        if let (Some(part), true) = (page.get_mut(..known), known > 0) {
            self.file.seek(SeekFrom::Start(start))?;
            self.file.read_exact(part)?;
        }
        Ok(page)
    }
}

/// Bytes of the head of the database, and of its smallest file that is extended.
const HEAD: usize = 32;
const LEAST: u64 = 16 << 20;

/// The length of the file as its head tells it: bytes of a page, then pages of the head of a region, pages in a region,
/// whole regions, and pages in the last one.
fn told_length(head: &[u8; HEAD]) -> Option<u64> {
    let number = |at: usize| head.get(at..)?.first_chunk().map(|bytes| u64::from(u32::from_le_bytes(*bytes)));
    let [page, of_head, in_region, whole, in_last] = [number(12)?, number(16)?, number(20)?, number(24)?, number(28)?];
    let last = if in_last > 0 { of_head + in_last } else { 0 };
    let pages = whole.checked_mul(of_head + in_region)?.checked_add(1 + last)?;
    pages.checked_mul(page)
}

/// Pages that a range touches: number, offset in the page, offset in the range, bytes.
fn touched(offset: u64, length: usize) -> impl Iterator<Item = (u64, usize, usize, usize)> {
    let mut done = 0;
    std::iter::from_fn(move || {
        let at = offset + done as u64;
        let inside = (at % PAGE) as usize;
        let count = (PAGE as usize - inside).min(length - done);
        let item = (at / PAGE, inside, done, count);
        done += count;
        (count > 0).then_some(item)
    })
}

impl StorageBackend for Frozen {
    fn len(&self) -> io::Result<u64> {
        Ok(self.pages().length)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let mut pages = self.pages();
        if offset + out.len() as u64 > pages.length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        for (number, inside, at, count) in touched(offset, out.len()) {
            let page = pages.page(number)?;
            if let (Some(to), Some(from)) = (out.get_mut(at..at + count), page.get(inside..inside + count)) {
                to.copy_from_slice(from);
            }
        }
        Ok(())
    }

    fn set_len(&self, len: u64) -> io::Result<()> {
        let mut pages = self.pages();
        pages.kept = pages.kept.min(len);
        if len < pages.length {
            if !len.is_multiple_of(PAGE) {
                let mut page = pages.page(len / PAGE)?;
                page.iter_mut().skip((len % PAGE) as usize).for_each(|byte| *byte = 0);
                pages.changed.insert(len / PAGE, page);
            }
            let _ = pages.changed.split_off(&len.div_ceil(PAGE));
        }
        pages.length = len;
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        let mut pages = self.pages();
        for (number, inside, at, count) in touched(offset, data.len()) {
            let mut page = pages.page(number)?;
            if let (Some(to), Some(from)) = (page.get_mut(inside..inside + count), data.get(at..at + count)) {
                to.copy_from_slice(from);
            }
            pages.changed.insert(number, page);
        }
        pages.length = pages.length.max(offset + data.len() as u64);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_that_was_cut_or_has_grown_has_the_length_that_its_head_tells() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ledger");
        drop(redb::Database::create(&path).unwrap());
        let content = std::fs::read(&path).unwrap();
        let length = content.len() as u64;
        let told = || Frozen::of_its_length(&path).unwrap().len().unwrap();
        assert_eq!(told(), length);
        for more in [1, 4096, 100_000] {
            std::fs::write(&path, [&content[..], &vec![b'x'; more]].concat()).unwrap();
            assert_eq!(told(), length);
        }
        std::fs::write(&path, &content[..content.len() / 2]).unwrap();
        assert_eq!(told(), length);
    }

    #[test]
    fn a_frozen_file_reads_as_if_written_and_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let content: Vec<u8> = (0..10_000u32).map(|n| (n % 251) as u8).collect();
        std::fs::write(&path, &content).unwrap();
        let frozen = Frozen::open(&path).unwrap();
        let mut twin = content.clone();
        frozen.write(4000, &[1; 5000]).unwrap();
        twin[4000..9000].fill(1);
        frozen.set_len(6000).unwrap();
        twin.truncate(6000);
        frozen.set_len(12_000).unwrap();
        twin.resize(12_000, 0);
        frozen.write(11_990, &[7; 10]).unwrap();
        twin[11_990..].fill(7);
        let mut back = vec![0; 12_000];
        frozen.read(0, &mut back).unwrap();
        assert!(back == twin && frozen.len().unwrap() == 12_000);
        assert!(frozen.read(11_999, &mut [0; 2]).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), content);
    }
}
