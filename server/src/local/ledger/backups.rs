//! Copies of the ledger for the backups that request them.
//!
//! A file in `tmp` is the request; its process locks it, and removes it with the copy at its end. *Invariant:* a copy
//! whose process has ended is removed within two checks of the requests.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::Path;

use crate::local::store::DataFolder;
use crate::reason::Refusal;

/// Content of a request that its process has locked. Backups of earlier versions lock nothing.
pub(crate) const HELD: &[u8] = b"held\n";

/// A request for a copy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Request {
    /// Its process lives.
    Held,
    /// Its process has ended.
    Abandoned,
    /// Of an earlier version, whose process is not known.
    Loose,
}

impl Request {
    fn of(path: &Path) -> io::Result<Self> {
        match fs::read(path) {
            Ok(content) if content != HELD => return Ok(Self::Loose),
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(error),
            // Of another user, or locked on a system where a lock prevents reading.
            Err(_) => return Ok(Self::Held),
        }
        match File::open(path)?.try_lock() {
            Ok(()) => Ok(Self::Abandoned),
            Err(TryLockError::WouldBlock) => Ok(Self::Held),
            Err(TryLockError::Error(error)) => Err(error),
        }
    }
}

/// Makes the requested copies with `copy`, and removes those whose process has ended.
pub(super) fn serve(store: &DataFolder, copy: impl Fn(&Path) -> Result<(), Refusal>) {
    for path in store.backups().unwrap_or_default() {
        let (part, ready) = (path.with_extension("copy"), path.with_extension("ready"));
        let Ok(request) = Request::of(&path) else { continue };
        if request == Request::Abandoned {
            tracing::info!("a backup has ended without taking its copy of the ledger: the copy is removed");
            [&part, &ready, &path].iter().for_each(|file| drop(fs::remove_file(file)));
            continue;
        }
        if ready.exists() {
            continue;
        }
        let copied = copy(&part).and_then(|()| {
            if request == Request::Loose {
                fs::remove_file(&path)?;
            } else {
                // The backup may have ended in the meantime; then no process would take the copy.
                fs::metadata(&path)?;
            }
            Ok(fs::rename(&part, &ready)?)
        });
        match copied {
            Ok(()) => tracing::info!("the ledger has been copied for a backup"),
            Err(error) => {
                tracing::warn!(%error, "the ledger cannot be copied for a backup");
                let _ = fs::remove_file(part);
            }
        }
    }
}
