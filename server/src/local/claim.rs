//! The file in a folder to which a backup or a restore writes. A command that is killed leaves it there.
//!
//! *Invariant:* no server uses a folder with this file, because the folder may contain only some of the jobs.

use std::io;
use std::path::Path;

/// Name of the file.
pub(crate) const CLAIM: &str = "copy-in-progress";

/// The problem of a folder with the file.
pub(crate) const UNFINISHED: &str = "a backup or a restore is writing to this folder, or was killed";
/// The remedy for [`UNFINISHED`].
pub(crate) const REMEDY: &str =
    "if none is running, the content is incomplete: remove the folder, and run the backup or restore again";

/// Whether a backup or restore into the folder has not ended.
pub(crate) fn is_claimed(folder: &Path) -> bool {
    folder.join(CLAIM).symlink_metadata().is_ok()
}

/// Refuses a folder with the file.
pub(crate) fn check(folder: &Path) -> io::Result<()> {
    if is_claimed(folder) {
        let file = folder.join(CLAIM);
        return Err(io::Error::other(format!("'{}': {UNFINISHED}; {REMEDY}", file.display())));
    }
    Ok(())
}
