//! Copies of a data folder: made while a server runs or not, and put back.
//!
//! A file in the folder of a running server requests a copy of its ledger; every user with write access to the folder
//! may request it. Files that the rows of that copy need never change once they exist, so they are copied without the
//! server. Invariants: a backup is an independent data folder, which is complete when the call ends successfully and
//! otherwise not usable; only one command at a time writes to a folder.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use uuid::Uuid;

use crate::doctor::examine_as;
use crate::local::claim::{self, CLAIM, is_claimed};
use crate::local::contained::contained;
use crate::local::disk::Disk;
use crate::local::folder_lock::{FolderLock, LockHolder};
use crate::local::ledger::backups::HELD;
use crate::local::ledger::checkup::{Checkup, copy_ledger};
use crate::local::owner::Owner;
use crate::local::store::{DataFolder, keep_private};
use crate::output::step;
use crate::reason::Refusal;
use crate::results::StoredResult;

/// Time that a server gets to begin with the copy of its ledger.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time that it gets beyond that to end it.
const COPYING: Duration = Duration::from_secs(600);
/// Between two looks for the copy.
const LOOK: Duration = Duration::from_millis(50);
/// Time between two checks that a server still uses the folder.
const LOOK_FOR_SERVER: Duration = Duration::from_secs(1);

/// The content of a backup.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contents {
    /// Jobs.
    pub jobs: usize,
    /// Copied blobs.
    pub blobs: usize,
    /// Blobs that jobs or machines need, but the folder lacks.
    pub missing: usize,
    /// Ended jobs that were left out: deleted while the backup was made, or their log is lost.
    pub left_out: usize,
}

/// Copies the data folder `from`, which a server may use, to the new folder `to`.
///
/// # Errors
/// When `to` is not empty, when `from` is incomplete itself, when a file cannot be read or written, or when the server
/// does not answer.
pub fn backup(from: &Path, to: &Path) -> Result<Contents, String> {
    has_ledger(from)?;
    claim::check(from).map_err(|error| error.to_string())?;
    lies_outside(to, from)?;
    let _claim = Claim::of(to)?;
    contained(|| copy_with_ledger(from, to))
        .and_then(|copied| copied)
        .map_err(|refusal| format!("the backup is incomplete; remove '{}': {refusal}", to.display()))
}

/// Refuses a target inside the source: a server would count the backup as its own data, and both would be lost
/// together.
fn lies_outside(to: &Path, from: &Path) -> Result<(), String> {
    let (Ok(from), Ok(target)) = (fs::canonicalize(from), std::path::absolute(to)) else { return Ok(()) };
    // A folder that does not exist yet cannot be a link.
    let existing = target.ancestors().find_map(|folder| fs::canonicalize(folder).ok());
    if existing.is_some_and(|existing| existing.starts_with(&from)) {
        return Err(format!("'{}' is inside '{}': choose a folder outside of it", to.display(), from.display()));
    }
    Ok(())
}

/// Refuses a source that is not the data folder of a server.
fn has_ledger(folder: &Path) -> Result<(), String> {
    let shown = folder.display();
    fs::metadata(folder).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => format!("'{shown}': there is no such folder; check --data"),
        _ => format!("'{shown}': {error}"),
    })?;
    match folder.join("ledger.redb").try_exists() {
        Ok(false) => Err(format!("'{shown}' is not a data folder: it has no ledger (ledger.redb); check --data")),
        // The copy itself reports any other error.
        _ => Ok(()),
    }
}

fn copy_with_ledger(from: &Path, to: &Path) -> Result<Contents, Refusal> {
    match DataFolder::examine(from.to_owned(), false, Disk::default(), LockHolder::Backup) {
        Ok(store) => copy_ledger(&store, &to.join("ledger.redb"))?,
        Err(error) if error.kind() == io::ErrorKind::ResourceBusy && may_be_of_server(from) => {
            ask(from, &to.join("ledger.redb"))?
        }
        Err(error) => return Err(error.into()),
    }
    let target = DataFolder::examine(to.to_owned(), true, Disk::default(), LockHolder::Backup)?;
    let checkup = Checkup::open(&target, true)?;
    let rows = checkup.rows()?;
    let mut gone = Vec::new();
    for record in rows.jobs.iter().filter(|record| record.state.ended()) {
        match copy_folder(&from.join("jobs").join(&record.id), &target.job(&record.id), Owner::default()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
        let has = |file: &str| target.job(&record.id).join(file).is_file();
        let log = record.log_digest.is_empty() || target.logs(&record.id).there() || checkup.log(&record.id)?.is_some();
        if !log || record.runs.has_files && !has(StoredResult::Files.file()) {
            target.remove_job(&record.id)?;
            gone.push(record);
        }
    }
    checkup.remove(&gone)?;
    let left_out = gone.len();
    let rows = checkup.rows()?;
    let mut missing = 0;
    for (tenant, digest) in &rows.blobs {
        let new = target.blob(tenant, digest);
        let Ok(place) = new.strip_prefix(to) else { continue };
        let old = from.join(place);
        match new.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| copy_file(&old, &new, Owner::default())) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => missing += 1,
            other => other?,
        }
    }
    Ok(Contents { jobs: rows.jobs.len(), blobs: rows.blobs.len() - missing, missing, left_out })
}

/// Whether the process that uses a folder may be a server, which copies its ledger on request.
fn may_be_of_server(folder: &Path) -> bool {
    FolderLock::holder(folder).is_none_or(|holder| holder == LockHolder::Server)
}

/// Asks the server that uses a folder for a copy of its ledger.
fn ask(folder: &Path, to: &Path) -> Result<(), Refusal> {
    let request = folder.join("tmp").join(format!("backup-{}", Uuid::now_v7()));
    let (copy, ready) = (request.with_extension("copy"), request.with_extension("ready"));
    let asker = File::create_new(&request)?;
    // As long as this process lives, the server keeps the copy.
    asker.lock()?;
    (&asker).write_all(HELD)?;
    let (asked, mut looked) = (Instant::now(), Instant::now());
    let failure = loop {
        if ready.is_file() {
            let copied = copy_file(&ready, to, Owner::default());
            // The request is removed first: for a request without a copy the server makes another copy.
            [&request, &ready].iter().for_each(|file| drop(fs::remove_file(file)));
            return Ok(copied?);
        }
        // A server removes all three at its start. One of an earlier version removes each after the next one exists.
        if ![&request, &copy, &ready].into_iter().any(|file| file.exists()) {
            return Err(Refusal::Storage(
                "the server was restarted during the backup: run the backup again".to_owned(),
            ));
        }
        // A server that starts while this process holds the lock would wait.
        if looked.elapsed() >= LOOK_FOR_SERVER {
            looked = Instant::now();
            if FolderLock::is_free(folder) {
                break "the server exited during the backup: run the backup again";
            }
        }
        let patience = if copy.exists() { PATIENCE + COPYING } else { PATIENCE };
        if asked.elapsed() > patience {
            break "the server that uses the folder does not answer: check its log, then run the backup again";
        }
        step(format_args!("waiting for the copy of the ledger by the server that uses the folder"));
        std::thread::sleep(LOOK);
    };
    [request, copy, ready].iter().for_each(|file| drop(fs::remove_file(file)));
    Err(Refusal::Storage(failure.to_owned()))
}

/// Puts a backup back as the data folder `to`, which must be new or empty; one with damages only if `damaged` allows
/// it. If root restores to an empty folder of another user, the files belong to this user.
///
/// # Errors
/// When the backup is damaged, when `to` is not empty, or when a file cannot be read or written.
pub fn restore(from: &Path, to: &Path, damaged: bool) -> Result<(), String> {
    if !from.join("ledger.redb").is_file() {
        return Err(format!("'{}' is not a backup: it has no ledger.redb", from.display()));
    }
    if is_claimed(from) {
        return Err(format!(
            "'{}' is not a whole backup: the backup that writes to it has not ended, or was interrupted (file \
             '{CLAIM}'); wait for its end, or restore another backup",
            from.display()
        ));
    }
    if let (Some(damage), false) = (examine_as(from, false, Disk::default(), LockHolder::Restore)?.first(), damaged) {
        let all = format!("counterpointd doctor --data '{}'", from.display());
        return Err(format!(
            "the backup is damaged (all damages: {all}; restore it all the same: --damaged): {damage}"
        ));
    }
    lies_outside(to, from)?;
    let _claim = Claim::of(to)?;
    let owner = Owner::of(to);
    let unfinished = |error: io::Error| format!("the folder '{}' is incomplete; remove it: {error}", to.display());
    for part in ["blobs", "jobs"] {
        match copy_folder(&from.join(part), &to.join(part), owner) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(unfinished(error)),
            _ => {}
        }
    }
    // Last: a folder without it is not taken for a whole one.
    copy_file(&from.join("ledger.redb"), &to.join("ledger.redb"), owner).map_err(unfinished)
}

/// The claim of a command on the folder that it fills. Dropping the claim releases the folder.
#[derive(Debug)]
struct Claim(PathBuf);

impl Claim {
    /// Claims a new or empty folder and closes it to other users.
    fn of(folder: &Path) -> Result<Self, String> {
        let shown = folder.display();
        fs::create_dir_all(folder).map_err(|error| format!("'{shown}' cannot be created: {error}"))?;
        let not_empty = || format!("'{shown}' is not empty: choose a new folder");
        // A folder with other files gets no claim.
        if is_empty(folder).is_ok_and(|empty| !empty) && !is_claimed(folder) {
            return Err(not_empty());
        }
        let claim = folder.join(CLAIM);
        match File::options().write(true).create_new(true).open(&claim) {
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                return Err(format!(
                    "another backup or restore is writing to '{shown}', or was interrupted (file '{CLAIM}'): choose a new \
                     folder"
                ));
            }
            Err(error) => {
                let error = io::Error::from(error.kind());
                return Err(format!(
                    "'{shown}' cannot be written: {error}; choose another folder, or make this one writable for the \
                     user"
                ));
            }
        }
        let claim = Self(claim);
        match is_empty(folder) {
            Ok(true) => {
                keep_private(folder);
                Ok(claim)
            }
            Ok(false) => Err(not_empty()),
            Err(error) => Err(format!("'{shown}' cannot be read: {error}")),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// Whether a folder has no file except that of its claim.
fn is_empty(folder: &Path) -> io::Result<bool> {
    for entry in fs::read_dir(folder)? {
        if entry?.file_name() != CLAIM {
            return Ok(false);
        }
    }
    Ok(true)
}

fn copy_folder(from: &Path, to: &Path, owner: Owner) -> io::Result<()> {
    let entries = fs::read_dir(from)?;
    fs::create_dir_all(to)?;
    owner.give_folder(to)?;
    for entry in entries {
        let entry = entry?;
        let target = to.join(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => copy_folder(&entry.path(), &target, owner)?,
            false => copy_file(&entry.path(), &target, owner)?,
        }
    }
    sync_folder(to)
}

/// Copies a file and makes it durable.
fn copy_file(from: &Path, to: &Path, owner: Owner) -> io::Result<()> {
    let mut source = File::open(from)?;
    step(format_args!("copying '{}'", from.display()));
    let mut target = File::create(to)?;
    owner.give(&target)?;
    io::copy(&mut source, &mut target)?;
    target.sync_all()?;
    to.parent().map_or(Ok(()), sync_folder)
}

fn sync_folder(folder: &Path) -> io::Result<()> {
    // The folder of a name without one.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_backup_into_the_data_folder_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().join("data");
        fs::create_dir_all(data.join("tmp")).unwrap();
        fs::write(data.join("ledger.redb"), "").unwrap();
        for inside in ["data", "data/backup", "data/new/deep", "data/../data/backup"] {
            let error = backup(&data, &folder.path().join(inside)).unwrap_err();
            assert!(error.contains("choose a folder outside of it"), "{error}");
        }
        assert!(!data.join("backup").exists());
        for outside in ["data-backup", "backup/data"] {
            assert_eq!(lies_outside(&folder.path().join(outside), &data), Ok(()), "{outside}");
        }
    }
}
