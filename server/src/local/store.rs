//! The data folder: the place of each file, and the way of writing a file so that a crash leaves the old or the new
//! content, never half of it.
//!
//! Layout: `lock`, `ledger.redb`, `blobs/<2 digits>/<digest>`, `blobs/@<tenant>/<2 digits>/<digest>`,
//! `jobs/<id>/{log or log.segments, summary.json, …}`, `marks`, `tmp/`.

use std::collections::HashSet;
use std::fs;
use std::io::{self, Read as _, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::claim;
use super::disk::{Disk, Temporary};
use super::folder_lock::{FolderLock, LockHolder};
use super::free_space::FreeSpace;
use super::marks::MarkFile;
use super::named::{PathContext as _, can_be_written, named};
use super::shared::CoalescedWork;
use super::spare;
use crate::host::RunMark;
use crate::log::kept::LogPaths;
use crate::log::wanted::ResultGate;
use crate::results::StoredResult;
use crate::tenant;

/// The data folder.
#[derive(Debug, Clone)]
pub(crate) struct DataFolder {
    root: PathBuf,
    durable: bool,
    disk: Disk,
    lock: Arc<FolderLock>,
    /// Folders that a loss of power leaves, with the names that were in them when this server first saw them.
    lasting: Arc<Mutex<HashSet<PathBuf>>>,
    /// Files that have got their names, which may not be durable yet.
    unsure: Arc<Mutex<HashSet<PathBuf>>>,
    /// Syncs of the folder of all jobs.
    jobs_synced: Arc<CoalescedWork>,
    /// Marks of running jobs.
    marks: Arc<MarkFile>,
    free: Arc<FreeSpace>,
}

/// Closes the folder, and files in it that a command has created with another mode, to all users except the server's.
pub(crate) fn keep_private(root: &Path) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        if let Err(error) = fs::set_permissions(root, fs::Permissions::from_mode(0o700)) {
            tracing::warn!(%error, folder = %root.display(), "other users may be able to read the data folder");
        }
        for file in ["ledger.redb", "lock"].map(|name| root.join(name)) {
            if file.metadata().is_ok_and(|meta| meta.is_file() && meta.permissions().mode() & 0o077 != 0) {
                // The folder is closed: a mode that cannot be changed lets no other user in.
                let _ = fs::set_permissions(&file, fs::Permissions::from_mode(0o600));
            }
        }
    }
    #[cfg(not(unix))]
    let _ = root;
}

impl DataFolder {
    /// Takes the folder for this server, creates missing parts and empties `tmp`.
    pub(crate) fn open(root: PathBuf, durable: bool, disk: Disk) -> io::Result<Self> {
        // The folder of a relative name such as `data` would be an empty path, which cannot be opened.
        let root = std::path::absolute(root)?;
        claim::check(&root)?;
        let new = !root.is_dir();
        fs::create_dir_all(&root).at(&root)?;
        keep_private(&root);
        let lock = Arc::new(FolderLock::take(&root, LockHolder::Server)?);
        let store = Self {
            marks: Arc::new(MarkFile::of(&root.join("marks"), disk.clone())?),
            root,
            durable,
            disk,
            lock,
            lasting: Arc::default(),
            unsure: Arc::default(),
            jobs_synced: Arc::default(),
            free: Arc::default(),
        };
        for folder in ["blobs", "jobs"] {
            let folder = store.root.join(folder);
            fs::create_dir_all(&folder).and_then(|()| can_be_written(&folder)).at(&folder)?;
        }
        store.take_earlier_marks()?;
        match fs::remove_dir_all(store.tmp()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(named(&store.tmp(), error)),
            _ => fs::create_dir_all(store.tmp()).at(&store.tmp())?,
        }
        if new {
            store.sync_folder_of(&store.root)?;
        }
        store.sync_root()?;
        Ok(store)
    }

    /// Opens an existing folder and changes nothing in it. For a repair the folder must be writable.
    pub(crate) fn examine(root: PathBuf, repair: bool, disk: Disk, holder: LockHolder) -> io::Result<Self> {
        if !root.is_dir() {
            return Err(io::Error::new(io::ErrorKind::NotFound, "there is no such folder"));
        }
        if repair {
            [root.clone(), root.join("ledger.redb"), root.join("jobs"), root.join("blobs")]
                .iter()
                .try_for_each(|path| can_be_written(path))?;
        }
        let disk = if repair { disk.for_owner_of(&root) } else { disk };
        let lock = match repair {
            true => FolderLock::take_for(disk.owner(), &root, holder),
            false => FolderLock::of_a_reader(&root, holder),
        };
        let lock = Arc::new(lock?);
        Ok(Self {
            marks: Arc::new(MarkFile::of(&root.join("marks"), disk.clone())?),
            root,
            durable: true,
            disk,
            lock,
            lasting: Arc::default(),
            unsure: Arc::default(),
            jobs_synced: Arc::default(),
            free: Arc::default(),
        })
    }

    pub(crate) fn durable(&self) -> bool {
        self.durable
    }

    pub(crate) fn disk(&self) -> &Disk {
        &self.disk
    }

    /// Gives the folder free for another server.
    pub(crate) fn release(&self) {
        self.lock.release();
    }

    /// Free bytes on the disk of the folder; `None` where the system does not say.
    pub(crate) fn free(&self) -> Option<u64> {
        self.disk.free(&self.root, &self.free)
    }

    /// Whether the folder holds anything that only a ledger explains.
    pub(crate) fn in_use(&self) -> bool {
        let filled = |name: &str| fs::read_dir(self.root.join(name)).is_ok_and(|mut entries| entries.next().is_some());
        filled("jobs") || filled("blobs")
    }

    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    pub(crate) fn ledger(&self) -> PathBuf {
        self.root.join("ledger.redb")
    }

    pub(crate) fn tmp(&self) -> PathBuf {
        self.root.join("tmp")
    }

    /// Folder of the blobs of a tenant.
    fn blobs_of(&self, tenant: &str) -> PathBuf {
        let blobs = self.root.join("blobs");
        if tenant::is_default(tenant) { blobs } else { blobs.join(format!("@{tenant}")) }
    }

    /// Place of a blob; the digest has been checked to be hexadecimal.
    pub(crate) fn blob(&self, tenant: &str, digest: &str) -> PathBuf {
        // One allocation: each submit asks for the places of its files twice.
        let mut path = PathBuf::with_capacity(self.root.as_os_str().len() + tenant.len() + digest.len() + 16);
        path.push(&self.root);
        path.push("blobs");
        if !tenant::is_default(tenant) {
            path.push(["@", tenant].concat());
        }
        path.push(digest.get(..2).unwrap_or("xx"));
        path.push(digest);
        path
    }

    /// Tenants that have blobs.
    pub(crate) fn tenants(&self) -> io::Result<Vec<String>> {
        let names = names(&self.root.join("blobs"))?;
        let named = names.iter().filter_map(|name| name.strip_prefix('@').map(str::to_owned));
        Ok(std::iter::once(tenant::default()).chain(named).collect())
    }

    /// Folder of a job.
    pub(crate) fn job(&self, id: &str) -> PathBuf {
        self.root.join("jobs").join(id)
    }

    /// Event log of a job while it runs.
    pub(crate) fn log(&self, id: &str) -> PathBuf {
        self.job(id).join("log")
    }

    /// Files of the log of a job.
    pub(crate) fn logs(&self, id: &str) -> LogPaths {
        LogPaths { plain: self.log(id), segments: self.job(id).join("log.segments") }
    }

    /// Writes a whole file with its checksum into the folder of a job: temporary file, fsync, rename. Its name is made
    /// durable by [`sync_job`](Self::sync_job).
    pub(crate) fn write(&self, id: &str, name: &str, content: &[u8]) -> io::Result<()> {
        let mut file = self.temporary()?;
        file.write_all(&spare::head(id, name, content))?;
        file.write_all(content)?;
        if self.durable {
            file.sync()?;
        }
        self.disk.create_folder(&self.job(id))?;
        file.place(&self.job(id).join(name))
    }

    /// Same without fsync, for files that can be made again, as long as they are wanted.
    pub(crate) fn write_spare(&self, id: &str, name: &str, content: &[u8], wanted: &ResultGate) -> io::Result<()> {
        let mut file = self.temporary()?;
        file.write_all(&spare::head(id, name, content))?;
        file.write_all(content)?;
        wanted.store(|| {
            self.disk.create_folder(&self.job(id))?;
            file.place(&self.job(id).join(name))
        })
    }

    /// The content of a file in the folder of a job.
    ///
    /// # Errors
    /// Of kind `InvalidData` when it is not whole.
    pub(crate) fn read(&self, id: &str, name: &str) -> io::Result<Vec<u8>> {
        let (mut content, path) = (Vec::new(), self.job(id).join(name));
        spare::whole(self.disk.open(&path)?, id, name)?.read_to_end(&mut content)?;
        Ok(content)
    }

    /// Gives the files of macros that an earlier version has written their checksums. One that is not whole stays as it
    /// is, and is reported when it is read.
    pub(crate) fn seal_files(&self) -> io::Result<()> {
        let name = StoredResult::Files.file();
        for id in self.jobs()? {
            match fs::read(self.job(&id).join(name)) {
                Ok(content) if spare::is_plain_json(&content) => {
                    self.write(&id, name, &content)?;
                    self.sync_job(&id)?;
                }
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }

    /// A temporary file.
    pub(crate) fn temporary(&self) -> io::Result<Temporary> {
        self.disk.temporary(&self.tmp())
    }

    /// Moves a finished temporary file to its place.
    pub(crate) fn keep(&self, file: Temporary, path: &Path) -> io::Result<()> {
        if self.durable {
            file.sync()?;
        }
        if let Some(folder) = path.parent() {
            self.create_lasting(folder)?;
        }
        held(&self.unsure).insert(path.to_owned());
        let kept = file.place(path).and_then(|()| self.sync_folder_of(path));
        if kept.is_ok() || !path.exists() {
            held(&self.unsure).remove(path);
        }
        kept
    }

    /// Whether a file is there and will be after a loss of power. One whose name could not be made durable is as if it
    /// were not there.
    pub(crate) fn has(&self, path: &Path) -> bool {
        let Some(folder) = path.parent().filter(|_| path.is_file()) else { return false };
        let lasting = self.create_lasting(folder).is_ok();
        let names_are_sure = {
            let unsure = held(&self.unsure);
            // Hashing a path costs more than everything else here.
            unsure.is_empty() || !unsure.contains(path)
        };
        if names_are_sure {
            return lasting;
        }
        let sure = lasting && self.sync_folder_of(path).is_ok();
        if sure {
            held(&self.unsure).remove(path);
        }
        sure
    }

    /// Creates a folder inside the data folder and makes its name durable, with those of the folders that it is in.
    fn create_lasting(&self, folder: &Path) -> io::Result<()> {
        if !self.durable {
            return self.disk.create_folder(folder);
        }
        if held(&self.lasting).contains(folder) || folder == self.root {
            return Ok(());
        }
        if let Some(outer) = folder.parent() {
            self.create_lasting(outer)?;
        }
        self.disk.create_folder(folder)?;
        // Also for an existing file and its content: it may be from a server that came no further.
        self.sync_folder_of(folder)?;
        self.disk.sync_folder(folder)?;
        held(&self.lasting).insert(folder.to_owned());
        Ok(())
    }

    /// Makes the names in the data folder itself durable.
    pub(crate) fn sync_root(&self) -> io::Result<()> {
        if self.durable { self.disk.sync_folder(&self.root).at(&self.root) } else { Ok(()) }
    }

    /// Makes names in the folder of `path` durable where the system has the notion.
    pub(crate) fn sync_folder_of(&self, path: &Path) -> io::Result<()> {
        match path.parent() {
            Some(folder) if self.durable => self.disk.sync_folder(folder),
            _ => Ok(()),
        }
    }

    /// Marks of running jobs; a server that stores nothing has none.
    pub(crate) fn marks(&self) -> Option<&MarkFile> {
        self.durable.then_some(&*self.marks)
    }

    /// Takes over the jobs that an earlier version has marked with a file each.
    fn take_earlier_marks(&self) -> io::Result<()> {
        let folder = self.root.join("running");
        for id in names(&folder)? {
            let attempt = fs::read_to_string(folder.join(&id))?.parse().unwrap_or(1);
            self.marks.mark(&RunMark { id, attempt, works: true })?;
        }
        match fs::remove_dir_all(folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    /// Makes the names of a job's folder durable, and its own; the latter together with other jobs.
    pub(crate) fn sync_job(&self, id: &str) -> io::Result<()> {
        if !self.durable {
            return Ok(());
        }
        self.disk.sync_folder(&self.job(id))?;
        self.jobs_synced.sync(|| self.disk.sync_folder(&self.root.join("jobs")))
    }

    /// Files with which backups ask for a copy of the ledger.
    pub(crate) fn backups(&self) -> io::Result<Vec<PathBuf>> {
        let asks = |name: &String| name.starts_with("backup-") && !name.contains('.');
        Ok(names(&self.tmp())?.into_iter().filter(asks).map(|name| self.tmp().join(name)).collect())
    }

    /// Identities of all jobs that have a folder.
    pub(crate) fn jobs(&self) -> io::Result<Vec<String>> {
        names(&self.root.join("jobs"))
    }

    /// Bytes in a job's folder.
    pub(crate) fn job_bytes(&self, id: &str) -> u64 {
        let entries = fs::read_dir(self.job(id)).into_iter().flatten().flatten();
        entries.filter_map(|entry| entry.metadata().ok()).map(|meta| meta.len()).sum()
    }

    /// Digests of the blobs of a tenant whose folder has these two digits.
    pub(crate) fn blobs(&self, tenant: &str, digits: &str) -> io::Result<Vec<String>> {
        names(&self.blobs_of(tenant).join(digits))
    }

    /// Bytes of all blobs of a tenant.
    pub(crate) fn blob_bytes(&self, tenant: &str) -> io::Result<u64> {
        let folder = self.blobs_of(tenant);
        let mut bytes: u64 = 0;
        for digits in names(&folder)?.iter().filter(|name| !name.starts_with('@')) {
            let entries = fs::read_dir(folder.join(digits)).into_iter().flatten().flatten();
            bytes += entries.filter_map(|entry| entry.metadata().ok()).map(|meta| meta.len()).sum::<u64>();
        }
        Ok(bytes)
    }

    /// Moves the folder of a job whose row is lost to `lost`.
    pub(crate) fn set_aside(&self, id: &str) -> io::Result<PathBuf> {
        let aside = self.root.join("lost").join(id);
        self.disk.create_folder(&self.root.join("lost")).at(&aside)?;
        match fs::remove_dir_all(&aside) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(named(&aside, error)),
            _ => fs::rename(self.job(id), &aside).at(&aside)?,
        }
        self.sync_root()?;
        Ok(aside)
    }

    /// Removes a job's folder; not being there is fine.
    pub(crate) fn remove_job(&self, id: &str) -> io::Result<()> {
        match fs::remove_dir_all(self.job(id)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            other => other.at(&self.job(id)),
        }
    }
}

/// A set whose holder panicked is used as it is.
fn held(set: &Mutex<HashSet<PathBuf>>) -> MutexGuard<'_, HashSet<PathBuf>> {
    set.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Names in a folder; none if there is no such folder.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.at(folder)?,
    };
    let mut names = Vec::new();
    for entry in entries {
        names.extend(entry?.file_name().into_string());
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let store = DataFolder::open(folder.path().join("data"), true, Disk::default()).unwrap();
        store.write("j", "files.json", b"one").unwrap();
        store.write("j", "files.json", b"two").unwrap();
        assert_eq!(store.read("j", "files.json").unwrap(), b"two");
        assert_eq!(fs::read_dir(store.tmp()).unwrap().count(), 0);
    }

    #[test]
    fn marks_of_an_earlier_version_are_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let running = folder.path().join("running");
        fs::create_dir(&running).unwrap();
        fs::write(running.join("first"), "").unwrap();
        fs::write(running.join("third"), "3").unwrap();
        let store = DataFolder::open(folder.path().to_owned(), true, Disk::default()).unwrap();
        let mut marks = store.marks().unwrap().all();
        marks.sort();
        let mark = |id: &str, attempt| RunMark { id: id.to_owned(), attempt, works: true };
        assert_eq!(marks, [mark("first", 1), mark("third", 3)]);
        assert!(!running.exists());
    }
}
