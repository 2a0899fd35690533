//! The owner of files that a command run by root creates in the folder of another user.
//!
//! *Invariant:* a file is given to the owner of the data folder through its open descriptor, so no link is followed.

use std::fs::File;
use std::io;
use std::path::Path;

/// User and group of new files; none = those of the process.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Owner(Option<(u32, u32)>);

impl Owner {
    /// The owner of a folder, if the process runs as root and the folder belongs to another user.
    #[cfg(unix)]
    pub(crate) fn of(folder: &Path) -> Self {
        use std::os::unix::fs::MetadataExt as _;
        let owner = folder.metadata().ok().map(|meta| (meta.uid(), meta.gid()));
        Self(owner.filter(|(user, _)| *user != 0 && rustix::process::geteuid().is_root()))
    }

    /// The owner of a folder: none on this system.
    #[cfg(not(unix))]
    pub(crate) fn of(_folder: &Path) -> Self {
        Self(None)
    }

    /// Gives an open file or folder to the owner.
    pub(crate) fn give(self, file: &File) -> io::Result<()> {
        #[cfg(unix)]
        if let Some((user, group)) = self.0 {
            return std::os::unix::fs::fchown(file, Some(user), Some(group));
        }
        let _ = file;
        Ok(())
    }

    /// Gives a new folder to the owner.
    pub(crate) fn give_folder(self, path: &Path) -> io::Result<()> {
        if self == Self::default() { Ok(()) } else { self.give(&File::open(path)?) }
    }
}
