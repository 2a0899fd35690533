//! One server per data folder: an exclusive lock, taken before anything in the folder is touched.
//!
//! Invariant: the lock ends with the process, however it ends, and with its holder, even while the process starts a
//! command that has not yet closed the descriptors it inherits.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

/// The lock of a data folder.
#[derive(Debug)]
pub(crate) struct FolderLock(File);

impl FolderLock {
    /// Takes the lock and leaves the process id of its holder in the file.
    pub(crate) fn take(folder: &Path) -> io::Result<Self> {
        let mut file = File::options().read(true).write(true).create(true).truncate(false).open(folder.join("lock"))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::Error(error)) => return Err(error),
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                let _ = (&file).take(32).read_to_string(&mut holder);
                let holder = match holder.trim() {
                    "" => "another process".to_owned(),
                    id => format!("process {id}"),
                };
                let text =
                    format!("it is in use by {holder}; stop that server first or choose another folder (--data)");
                return Err(io::Error::new(io::ErrorKind::ResourceBusy, text));
            }
        }
        // The process id serves people only: a full disk does not keep the server from starting.
        let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| writeln!(file, "{}", std::process::id()));
        Ok(Self(file))
    }

    /// Releases the folder although this lock may still be held.
    pub(crate) fn release(&self) {
        let _ = self.0.unlock();
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        self.release();
    }
}
