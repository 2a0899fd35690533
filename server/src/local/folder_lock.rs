//! One server per data folder: an exclusive lock, taken before anything in the folder is touched.
//!
//! Invariant: the lock ends with the process, however it ends, and with its holder, even while the process starts a
//! command that has not yet closed the descriptors it inherits.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use super::named::Named as _;
use super::owner::Owner;

/// The lock of a data folder.
#[derive(Debug)]
pub(crate) struct FolderLock(Option<File>);

impl FolderLock {
    /// Takes the lock and leaves the process id of its holder in the file.
    pub(crate) fn take(folder: &Path) -> io::Result<Self> {
        let path = folder.join("lock");
        let file = File::options().read(true).write(true).create(true).truncate(false).open(&path).at(&path)?;
        let mut file = locked(file)?;
        // The process id serves people only: a full disk does not keep the server from starting.
        let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| writeln!(file, "{}", std::process::id()));
        Ok(Self(Some(file)))
    }

    /// Takes the lock of a folder to read it, without creating a file. Without a lock file no server uses the folder.
    pub(crate) fn of_a_reader(folder: &Path) -> io::Result<Self> {
        let path = folder.join("lock");
        match File::open(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self(None)),
            file => locked(file.at(&path)?).map(|file| Self(Some(file))),
        }
    }

    /// Takes the lock of a folder and gives its file to an owner.
    pub(crate) fn take_for(owner: Owner, folder: &Path) -> io::Result<Self> {
        let lock = Self::take(folder)?;
        lock.0.as_ref().map_or(Ok(()), |file| owner.give(file))?;
        Ok(lock)
    }

    /// Releases the folder although this lock may still be held.
    pub(crate) fn release(&self) {
        let _ = self.0.as_ref().map(File::unlock);
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        self.release();
    }
}

fn locked(file: File) -> io::Result<File> {
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::Error(error)) => Err(error),
        Err(TryLockError::WouldBlock) => {
            let mut holder = String::new();
            let _ = (&file).take(32).read_to_string(&mut holder);
            let holder = match holder.trim() {
                "" => "another process".to_owned(),
                id => format!("process {id}"),
            };
            let text = format!(
                "it is in use by {holder}, a server or another command; wait for its end or stop it, or choose another \
                 folder (--data)"
            );
            Err(io::Error::new(io::ErrorKind::ResourceBusy, text))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A restore and a repair hold the lock, too.
    #[test]
    fn a_folder_in_use_is_not_always_that_of_a_server() {
        let folder = tempfile::tempdir().unwrap();
        let held = FolderLock::take(folder.path()).unwrap();
        let text = FolderLock::take(folder.path()).unwrap_err().to_string();
        assert!(text.contains(&format!("process {}, a server or another command", std::process::id())), "{text}");
        drop(held);
        FolderLock::take(folder.path()).unwrap();
    }
}
