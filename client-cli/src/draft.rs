//! Result files: each is written under a temporary name in its final folder, and renamed when it is complete.
//!
//! *Invariant:* a regular file has its final name only with its whole content; an interrupted or failed command leaves
//! an earlier file of that name unchanged.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use tempfile::{Builder, TempPath};

use crate::error::Error;

/// Suffix of incomplete files.
const INCOMPLETE: &str = ".incomplete";

/// A file that is being written; dropping it without [`Draft::finish`] removes it.
pub(crate) struct Draft {
    place: PathBuf,
    file: File,
    /// The file until it is complete; none for devices and pipes, which are written directly.
    draft: Option<TempPath>,
}

impl Draft {
    /// Creates the temporary file.
    pub(crate) fn new(path: &Path) -> Result<Self, Error> {
        // A symbolic link stays, and its target is replaced.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let existing = fs::metadata(&place).ok();
        if existing.as_ref().is_some_and(|meta| !meta.is_file()) {
            let file = File::options().write(true).open(&place).map_err(Error::file(path))?;
            return Ok(Self { place, file, draft: None });
        }
        let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            let (path, folder) = (path.display(), folder.display());
            return Err(Error::Usage(format!("'{path}' cannot be written: the folder '{folder}' does not exist")));
        }
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        let (file, draft) = new_file(folder, &format!(".{name}.")).map_err(Error::file(path))?;
        if let Some(meta) = existing {
            file.set_permissions(meta.permissions()).map_err(Error::file(path))?;
        }
        Ok(Self { place, file, draft: Some(draft) })
    }

    pub(crate) fn write(&mut self, data: &[u8]) -> Result<(), Error> {
        self.file.write_all(data).map_err(Error::file(&self.place))
    }

    /// Renames the complete file to its final name.
    pub(crate) fn finish(self) -> Result<(), Error> {
        let Some(draft) = self.draft else { return Ok(()) };
        draft.persist(&self.place).map_err(|error| Error::file(&self.place)(error.error))
    }
}

/// A new file with the usual permissions of new files.
fn new_file(folder: &Path, prefix: &str) -> std::io::Result<(File, TempPath)> {
    let mut builder = Builder::new();
    builder.prefix(prefix).suffix(INCOMPLETE);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    Ok(builder.tempfile_in(folder)?.into_parts())
}

/// Writes a whole file.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<(), Error> {
    let mut draft = Draft::new(path)?;
    draft.write(content)?;
    draft.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_only_by_a_complete_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("upper.lce");
        fs::write(&path, "earlier").unwrap();
        let mut draft = Draft::new(&path).unwrap();
        draft.write(b"la").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
        drop(draft);
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "the incomplete file is removed");
        write(&path, b"later").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"later");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_and_new_files_have_the_usual_permissions() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        fs::write(at("usual"), "").unwrap();
        write(&at("new"), b"").unwrap();
        assert_eq!(mode(&at("new")), mode(&at("usual")));
        fs::set_permissions(at("usual"), fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink("usual", at("link")).unwrap();
        write(&at("link"), b"text").unwrap();
        assert!(at("link").is_symlink());
        assert_eq!((fs::read(at("usual")).unwrap(), mode(&at("usual"))), (b"text".to_vec(), 0o640));
        write(Path::new("/dev/null"), b"text").unwrap();
        let error = write(&at("absent/x"), b"").unwrap_err().to_string();
        assert!(error.contains("the folder") && error.contains("absent' does not exist"), "{error}");
    }
}
