//! One process per data folder: an exclusive lock, taken before anything in the folder is touched. The file of the lock
//! names its holder.
//!
//! Invariant: the lock ends with the process, however it ends, and with its holder, even while the process starts a
//! command that has not yet closed the descriptors it inherits.

use std::fmt;
use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use super::named::PathContext as _;
use super::owner::Owner;

/// Longest time for which a process waits for a backup or a restore that uses the folder.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time after which the lock counts as held. Before that, the other process may only be testing whether the lock is
/// free, or may not have written its name yet.
const MOMENT: Duration = Duration::from_millis(300);
/// Time between two attempts to take the lock.
const LOOK: Duration = Duration::from_millis(20);

/// The holder of a lock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LockHolder {
    Server,
    Backup,
    Restore,
    Doctor,
}

impl LockHolder {
    const ALL: [Self; 4] = [Self::Server, Self::Backup, Self::Restore, Self::Doctor];

    /// Whether this holder needs the folder only for a short time.
    fn is_brief(self) -> bool {
        matches!(self, Self::Backup | Self::Restore)
    }
}

impl fmt::Display for LockHolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Server => "server",
            Self::Backup => "backup",
            Self::Restore => "restore",
            Self::Doctor => "doctor",
        })
    }
}

/// The holder that the file of a lock names, and its process. A holder that may not write the file is not named.
fn named_in(mut file: &File) -> Option<(LockHolder, u32)> {
    let mut text = String::new();
    file.rewind().and_then(|()| file.take(64).read_to_string(&mut text)).ok()?;
    let mut words = text.split_whitespace();
    let process = words.next()?.parse().ok()?;
    let holder = match words.next() {
        // Only servers of earlier versions name no holder.
        None => LockHolder::Server,
        Some(word) => LockHolder::ALL.into_iter().find(|holder| holder.to_string() == word)?,
    };
    // A process that has ended holds no lock.
    let lives = !cfg!(target_os = "linux") || Path::new("/proc").join(format!("{process}")).exists();
    lives.then_some((holder, process))
}

/// Replaces the content of a lock file. Only people need it, so errors are ignored: a full disk prevents no start.
fn write(mut file: &File, text: &[u8]) {
    let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(text));
}

fn busy(holder: Option<(LockHolder, u32)>) -> io::Error {
    let text = match holder {
        None => "it is in use by another process; end that process first or choose another folder (--data)".to_owned(),
        Some((LockHolder::Server, process)) => {
            format!("it is in use by process {process}; stop that server first or choose another folder (--data)")
        }
        Some((holder, process)) => {
            format!("it is in use by process {process} ({holder}); wait until it has ended, then try again")
        }
    };
    io::Error::new(io::ErrorKind::ResourceBusy, text)
}

/// Takes the lock. If a backup or restore holds it, waits for that command to end.
fn locked(file: File) -> io::Result<File> {
    let (begin, mut waits) = (Instant::now(), false);
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(file),
            Err(TryLockError::Error(error)) => return Err(error),
            Err(TryLockError::WouldBlock) => {}
        }
        let holder = named_in(&file);
        let brief = holder.filter(|(holder, _)| holder.is_brief());
        if begin.elapsed() >= if brief.is_some() { PATIENCE } else { MOMENT } {
            return Err(busy(holder));
        }
        if let (Some((holder, process)), false) = (brief, waits) {
            waits = true;
            tracing::info!(
                process,
                "the data folder is in use by a {holder}: waiting at most {} s",
                PATIENCE.as_secs()
            );
        }
        std::thread::sleep(LOOK);
    }
}

/// The lock of a data folder.
#[derive(Debug)]
pub(crate) struct FolderLock {
    file: Option<File>,
    /// Content of the file before, for a holder that leaves the folder unchanged.
    before: Option<Vec<u8>>,
}

impl FolderLock {
    /// Takes the lock and leaves the name of its holder in the file.
    pub(crate) fn take(folder: &Path, holder: LockHolder) -> io::Result<Self> {
        let path = folder.join("lock");
        let file = File::options().read(true).write(true).create(true).truncate(false).open(&path).at(&path)?;
        let file = locked(file)?;
        write(&file, format!("{} {holder}\n", std::process::id()).as_bytes());
        Ok(Self { file: Some(file), before: None })
    }

    /// Takes the lock of a folder to read it, without creating a file. Without a lock file no server uses the folder.
    pub(crate) fn of_a_reader(folder: &Path, holder: LockHolder) -> io::Result<Self> {
        let path = folder.join("lock");
        let file = match File::options().read(true).write(true).open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self { file: None, before: None }),
            // A folder that may only be read.
            Err(_) => return locked(File::open(&path).at(&path)?).map(|file| Self { file: Some(file), before: None }),
        };
        let file = locked(file)?;
        let mut before = Vec::new();
        (&file).rewind().and_then(|()| (&file).read_to_end(&mut before)).at(&path)?;
        write(&file, format!("{} {holder}\n", std::process::id()).as_bytes());
        Ok(Self { file: Some(file), before: Some(before) })
    }

    /// Takes the lock of a folder and gives its file to an owner.
    pub(crate) fn take_for(owner: Owner, folder: &Path, holder: LockHolder) -> io::Result<Self> {
        let lock = Self::take(folder, holder)?;
        lock.file.as_ref().map_or(Ok(()), |file| owner.give(file))?;
        Ok(lock)
    }

    /// Whether no process uses a folder.
    pub(crate) fn is_free(folder: &Path) -> bool {
        match File::open(folder.join("lock")) {
            Ok(file) => file.try_lock().is_ok(),
            Err(error) => error.kind() == io::ErrorKind::NotFound,
        }
    }

    /// The holder of the lock of a folder that is in use, if it is named.
    pub(crate) fn holder(folder: &Path) -> Option<LockHolder> {
        named_in(&File::open(folder.join("lock")).ok()?).map(|(holder, _)| holder)
    }

    /// Releases the folder although this lock may still be held.
    pub(crate) fn release(&self) {
        if let Some(file) = &self.file {
            self.before.iter().for_each(|before| write(file, before));
            let _ = file.unlock();
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        self.release();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_names_its_holder_and_a_reader_leaves_the_file_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        drop(FolderLock::take(folder.path(), LockHolder::Server).unwrap());
        let file = folder.path().join("lock");
        let before = std::fs::read(&file).unwrap();
        let process = std::process::id();
        for (holder, remedy) in [
            (LockHolder::Doctor, format!("process {process} (doctor); wait until it has ended")),
            (LockHolder::Server, format!("process {process}; stop that server first")),
        ] {
            let lock = match holder {
                LockHolder::Server => FolderLock::take(folder.path(), holder).unwrap(),
                reader => FolderLock::of_a_reader(folder.path(), reader).unwrap(),
            };
            let error = FolderLock::take(folder.path(), LockHolder::Server).unwrap_err();
            assert!(error.kind() == io::ErrorKind::ResourceBusy && error.to_string().contains(&remedy), "{error}");
            assert_eq!(FolderLock::holder(folder.path()), Some(holder));
            drop(lock);
            assert_eq!(std::fs::read(&file).unwrap(), before, "{holder}");
        }
        // The process that the file names has ended, and its holder could not write the file.
        let lock = File::open(&file).unwrap();
        std::fs::write(&file, "4194305 server\n").unwrap();
        lock.lock().unwrap();
        let error = FolderLock::take(folder.path(), LockHolder::Server).unwrap_err().to_string();
        assert!(!cfg!(target_os = "linux") || error.contains("in use by another process;"), "{error}");
    }

    #[test]
    fn a_server_waits_for_a_backup_that_copies_the_ledger() {
        let folder = tempfile::tempdir().unwrap();
        drop(FolderLock::take(folder.path(), LockHolder::Server).unwrap());
        let backup = FolderLock::of_a_reader(folder.path(), LockHolder::Backup).unwrap();
        let copying = std::thread::spawn(move || {
            std::thread::sleep(3 * MOMENT);
            drop(backup);
        });
        let server = FolderLock::take(folder.path(), LockHolder::Server);
        assert!(server.is_ok(), "{server:?}");
        copying.join().unwrap();
    }
}
