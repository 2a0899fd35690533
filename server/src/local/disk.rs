//! The seam for file writes.
//!
//! Invariant: without [`Faults`] a step has the effect of the system call and no other.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use prometheus_client::metrics::counter::Counter;

use super::free_space::FreeSpace;
use super::owner::Owner;

/// The next operation on a file or folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DiskOperation {
    /// It is created.
    Create,
    /// This many bytes are written.
    Write(usize),
    /// Its length is set to this many bytes.
    Resize(u64),
    /// It is made durable.
    Sync,
    /// A finished file gets its name.
    Place,
    /// It is opened to be read.
    Read,
}

/// Troubles of a disk, for tests.
pub trait Faults: Send + Sync {
    /// Called before each step. Of a write it returns the number of bytes that are written at most (a short write);
    /// otherwise the number does not matter.
    ///
    /// # Errors
    /// The error of the step.
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize>;

    /// Free bytes to be reported; `None` = those of the disk.
    fn free(&self) -> Option<u64> {
        None
    }
}

/// The disk.
#[derive(Clone, Default)]
pub struct Disk {
    faults: Option<Arc<dyn Faults>>,
    /// Counts durable writes.
    syncs: Counter,
    /// Owner of new files.
    owner: Owner,
}

impl std::fmt::Debug for Disk {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Disk")
    }
}

impl Disk {
    /// A disk with troubles.
    #[must_use]
    pub fn faulty(faults: Arc<dyn Faults>) -> Self {
        Self { faults: Some(faults), ..Self::default() }
    }

    /// The disk with a counter of durable writes.
    pub(crate) fn counting(self, syncs: &Counter) -> Self {
        Self { syncs: syncs.clone(), ..self }
    }

    /// The disk for a command on a data folder: files that root creates belong to the owner of the folder.
    pub(crate) fn for_owner_of(self, folder: &Path) -> Self {
        Self { owner: Owner::of(folder), ..self }
    }

    /// The owner of new files.
    pub(crate) fn owner(&self) -> Owner {
        self.owner
    }

    /// Asks whether a step may be done; of a write, how many bytes.
    pub(crate) fn step(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        if step == DiskOperation::Sync {
            self.syncs.inc();
        }
        self.faults.as_ref().map_or(Ok(usize::MAX), |faults| faults.before(step, path))
    }

    pub(crate) fn create(&self, path: &Path) -> io::Result<DiskFile> {
        self.step(DiskOperation::Create, path)?;
        let file = File::create(path)?;
        self.owner.give(&file)?;
        Ok(DiskFile { file, path: path.to_owned(), disk: self.clone() })
    }

    /// Opens a file that is written in place, and makes it if it is not there.
    pub(crate) fn create_or_open(&self, path: &Path) -> io::Result<DiskFile> {
        self.step(DiskOperation::Create, path)?;
        let file = File::options().create(true).truncate(false).write(true).open(path)?;
        self.owner.give(&file)?;
        Ok(DiskFile { file, path: path.to_owned(), disk: self.clone() })
    }

    /// A temporary file in `folder`; dropping it removes it.
    pub(crate) fn temporary(&self, folder: &Path) -> io::Result<Temporary> {
        self.step(DiskOperation::Create, folder)?;
        let file = tempfile::NamedTempFile::new_in(folder)?;
        self.owner.give(file.as_file())?;
        Ok(Temporary { file, disk: self.clone() })
    }

    pub(crate) fn create_folder(&self, path: &Path) -> io::Result<()> {
        if path.is_dir() {
            return Ok(());
        }
        self.step(DiskOperation::Create, path)?;
        fs::create_dir_all(path)?;
        self.owner.give_folder(path)
    }

    /// Makes the names in a folder durable where the system has the notion.
    pub(crate) fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.step(DiskOperation::Sync, path)?;
        if cfg!(unix) { File::open(path)?.sync_all() } else { Ok(()) }
    }

    /// A whole file.
    pub(crate) fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.step(DiskOperation::Read, path)?;
        fs::read(path)
    }

    /// Opens a file to be read.
    pub(crate) fn open(&self, path: &Path) -> io::Result<File> {
        self.step(DiskOperation::Read, path)?;
        File::open(path)
    }

    /// Free bytes for the server on the disk of a folder; `None` if the system does not report them. The caller keeps
    /// the last reading.
    pub(crate) fn free(&self, folder: &Path, last: &FreeSpace) -> Option<u64> {
        let injected = self.faults.as_ref().and_then(|faults| faults.free());
        injected.or_else(|| last.at(Instant::now(), || free(folder)))
    }
}

#[cfg(unix)]
fn free(folder: &Path) -> Option<u64> {
    let stat = rustix::fs::statvfs(folder).ok()?;
    Some(stat.f_bavail.saturating_mul(stat.f_frsize))
}

#[cfg(not(unix))]
fn free(_folder: &Path) -> Option<u64> {
    None
}

fn write(disk: &Disk, path: &Path, file: &mut File, data: &[u8]) -> io::Result<usize> {
    let most = disk.step(DiskOperation::Write(data.len()), path)?;
    file.write(data.get(..most).unwrap_or(data))
}

/// A file being written.
#[derive(Debug)]
pub(crate) struct DiskFile {
    file: File,
    path: PathBuf,
    disk: Disk,
}

impl DiskFile {
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.disk.step(DiskOperation::Sync, &self.path)?;
        self.file.sync_all()
    }
}

impl Seek for DiskFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Write for DiskFile {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        write(&self.disk, &self.path, &mut self.file, data)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A temporary file being written.
#[derive(Debug)]
pub(crate) struct Temporary {
    file: tempfile::NamedTempFile,
    disk: Disk,
}

impl Temporary {
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.disk.step(DiskOperation::Sync, self.file.path())?;
        self.file.as_file().sync_all()
    }

    /// Gives it its name.
    pub(crate) fn place(self, path: &Path) -> io::Result<()> {
        self.disk.step(DiskOperation::Place, path)?;
        self.file.persist(path).map(drop).map_err(|error| error.error)
    }
}

impl Write for Temporary {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let path = self.file.path().to_owned();
        write(&self.disk, &path, self.file.as_file_mut(), data)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
