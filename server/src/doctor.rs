//! Examines a data folder without a server: every damage with its place and remedy.
//!
//! Invariant: without `repair` nothing in the folder changes; a repair removes only unreadable or unusable data. When
//! rows of jobs may have been lost, folders without a job are set aside instead.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{fmt, fs, io};

use crate::blobs::{Blobs as _, is_digest};
use crate::ledger::record::JobRecord;
use crate::local::blobs::LocalBlobs;
use crate::local::claim::{CLAIM, REMEDY, UNFINISHED, is_claimed};
use crate::local::contained::contained;
use crate::local::disk::Disk;
use crate::local::folder_lock::LockHolder;
use crate::local::ledger::checkup::{Checkup, LedgerContent};
use crate::local::ledger::salvage::Saved;
use crate::local::ledger::{lost, lost_for_good, not_lost, unopened_by};
use crate::local::named::{PathContext as _, is_of_host};
use crate::local::store::DataFolder;
use crate::log::kept::StoredLog;
use crate::log::reader::{Events, LogReader};
use crate::output::step;
use crate::reason::Refusal;
use crate::results::StoredResult;

/// A damage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DoctorFinding {
    /// File or folder.
    pub path: PathBuf,
    /// The error.
    pub what: String,
    /// The remedy, or the completed repair.
    pub remedy: String,
    /// It is there no longer.
    pub repaired: bool,
    /// Whether the line is information for the operator instead of damage.
    pub note: bool,
}

impl fmt::Display for DoctorFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = match self.repaired {
            _ if self.note => "note",
            true => "repaired",
            false => "damaged",
        };
        write!(f, "{state}: {}: {}; {}", self.path.display(), self.what, self.remedy)
    }
}

/// Examines the folder of a stopped server and repairs it if asked to. Returns every damage.
///
/// # Errors
/// When the folder cannot be examined: it does not exist, is not a data folder, is in use by a server, or cannot be
/// read. For a repair, also when it cannot be written.
pub fn examine(folder: &Path, repair: bool) -> Result<Vec<DoctorFinding>, String> {
    examine_on(folder, repair, Disk::default())
}

/// Does the same on a disk that may fail.
///
/// # Errors
/// As above.
pub fn examine_on(folder: &Path, repair: bool, disk: Disk) -> Result<Vec<DoctorFinding>, String> {
    examine_as(folder, repair, disk, LockHolder::Doctor)
}

/// Does the same for another command.
pub(crate) fn examine_as(
    folder: &Path,
    repair: bool,
    disk: Disk,
    holder: LockHolder,
) -> Result<Vec<DoctorFinding>, String> {
    let store =
        DataFolder::examine(folder.to_owned(), repair, disk, holder).map_err(|error| match is_of_host(&error) {
            true => error.to_string(),
            false => format!("'{}': {error}", folder.display()),
        })?;
    let claimed = is_claimed(folder);
    let damage = || DoctorFinding {
        path: folder.join(CLAIM),
        what: UNFINISHED.to_owned(),
        remedy: REMEDY.to_owned(),
        repaired: false,
        note: false,
    };
    if claimed && (repair || matches!(store.ledger().try_exists(), Ok(false))) {
        // A repair cannot complete the content.
        return Ok(vec![damage()]);
    }
    if !store.in_use() && matches!(store.ledger().try_exists(), Ok(false)) {
        let folder = folder.display();
        return Err(format!("'{folder}' is not a data folder: it has no ledger, jobs or blobs; check the path"));
    }
    let blobs = LocalBlobs::new(store.clone(), u64::MAX);
    let mut doctor = Doctor { blobs, store, repair, lost: false, found: Vec::new() };
    doctor.found.extend(claimed.then(damage));
    contained(|| doctor.folder()).and_then(|done| done).map_err(|refusal| refusal.to_string())?;
    Ok(doctor.found)
}

struct Doctor {
    store: DataFolder,
    blobs: LocalBlobs,
    repair: bool,
    /// Rows of the ledger have been lost.
    lost: bool,
    found: Vec<DoctorFinding>,
}

impl Doctor {
    /// Notes damage that a repair cannot remove.
    fn lasting(&mut self, path: PathBuf, what: impl Into<String>, remedy: impl Into<String>) {
        self.found.push(DoctorFinding { path, what: what.into(), remedy: remedy.into(), repaired: false, note: false });
    }

    /// Notes a damage that a repair mends by `done`.
    fn mendable(&mut self, path: PathBuf, what: impl Into<String>, done: &str, then: &str) {
        let remedy = match self.repair {
            true => format!("{done}{then}"),
            false => format!("run again with --repair: {done}{then}"),
        };
        self.found.push(DoctorFinding { path, what: what.into(), remedy, repaired: self.repair, note: false });
    }

    fn folder(&mut self) -> Result<(), Refusal> {
        let ledger = self.store.ledger();
        step(format_args!("reading '{}'", ledger.display()));
        let opened = not_lost(&self.store).and_then(|()| {
            self.pages()?;
            let opened = Checkup::open(&self.store, self.repair);
            opened.map_err(|why| unopened_by(&self.store, why))
        });
        let checkup = match opened {
            Ok(checkup) => checkup,
            // A problem of the host, not damage.
            Err(trouble @ Refusal::Storage(_)) => return Err(trouble),
            Err(refusal) => {
                if !self.found.iter().any(|damage| damage.path == ledger) {
                    self.lasting(ledger, "the ledger cannot be used", refusal.to_string());
                }
                return Ok(());
            }
        };
        let rows = checkup.rows()?;
        self.rows(&rows);
        if self.repair {
            checkup.repair(&rows, &self.store)?;
        }
        for (number, record) in rows.jobs.iter().enumerate() {
            step(format_args!("reading the log of job {} of {}", number + 1, rows.jobs.len()));
            self.job(&checkup, record)?;
        }
        self.folders(&rows)?;
        self.blobs(&rows)
    }

    /// Saves what is whole in a ledger with damaged pages.
    fn pages(&mut self) -> Result<(), Refusal> {
        let why = match Checkup::sound(&self.store) {
            Ok(()) => return Ok(()),
            Err(Refusal::DataLoss(why)) => why,
            Err(trouble) => return Err(trouble),
        };
        let damaged = lost(&self.store, &format!("is damaged ({why})"));
        let nothing = || lost_for_good(&self.store, &format!("is damaged ({why})"));
        let saved = Saved::read(&self.store).map_err(|_| nothing())?;
        let (jobs, machines) = saved.counts();
        let kept = Saved::kept(&self.store);
        let without = match saved.unreadable() {
            0 => String::new(),
            count => format!(" without {count} rows that cannot be read"),
        };
        let done = format!(
            "{jobs} jobs and {machines} rows of machines are saved into a new ledger{without}, the damaged one is kept \
             as '{}'",
            kept.display()
        );
        if self.repair {
            saved.replace(&self.store)?;
        }
        self.mendable(self.store.ledger(), format!("pages of the ledger are damaged ({why})"), &done, "");
        if self.repair && !saved.is_whole() {
            self.lost = true;
            let what = "rows of jobs and machines may be lost with its damaged pages";
            self.lasting(kept.clone(), what, "submit jobs that are missing again, and put machines that are missing");
            for (id, request) in saved.lost_jobs() {
                let request = request.map_or(String::new(), |request| format!(" (request id '{request}')"));
                let what = format!("job '{id}'{request} is lost, or was deleted before");
                self.lasting(kept.clone(), what, "submit it again if it is missing");
            }
            self.doubtful(kept, saved.doubtful_jobs());
        }
        if self.repair { Ok(()) } else { Err(damaged) }
    }

    /// Names the saved jobs that may have been deleted before, in one line.
    fn doubtful<'a>(&mut self, path: PathBuf, jobs: impl Iterator<Item = &'a str>) {
        let ids: Vec<&str> = jobs.collect();
        let what = match ids.len() {
            0 => return,
            1 => format!("1 saved job was found without its table and may have been deleted before ({})", ids.join("")),
            count => {
                let ids = ids.join(" ");
                format!("{count} saved jobs were found without their table and may have been deleted before ({ids})")
            }
        };
        let remedy = "delete again those that were".to_owned();
        self.found.push(DoctorFinding { path, what, remedy, repaired: false, note: true });
    }

    fn rows(&mut self, rows: &LedgerContent) {
        let ledger = self.store.ledger();
        for row in &rows.unreadable {
            let (text, then) = match row.machine {
                true => (format!("the row of machine '{}' cannot be read", row.key), "put the machine again"),
                false => (format!("the row of job '{}' or its work cannot be read", row.key), "submit the job again"),
            };
            self.mendable(ledger.clone(), text, "the row is removed, ", then);
        }
        for request in &rows.requests {
            self.mendable(ledger.clone(), format!("request id '{request}' has no job"), "it is removed", "");
        }
        for id in &rows.logs {
            self.mendable(ledger.clone(), format!("the log of job '{id}' has no job"), "it is removed", "");
        }
        if rows.wrong_counts {
            let what = "the counts of blobs or the list of ended jobs do not agree with the rows";
            self.mendable(ledger, what, "they are made again", "");
        }
    }

    /// Reads the log of a job that has ended, and the files that its macros have written.
    fn job(&mut self, checkup: &Checkup, record: &JobRecord) -> Result<(), Refusal> {
        let again = "delete the job and submit it again: the same job gives the same log";
        // The text of a damaged log already says that the same job gives the same log.
        let remedy = |text: &str| if text.contains("submit the job again") { "delete the damaged job" } else { again };
        if record.state.ended() && !record.log_digest.is_empty() {
            let files = self.store.logs(&record.id);
            let path = if files.segments.is_file() { files.segments.clone() } else { files.plain.clone() };
            let kept = match files.there() {
                true => Ok(Some(StoredLog::in_files(&record.id, files))),
                false => checkup.log(&record.id).map(|log| log.map(|log| StoredLog::in_ledger(&record.id, log))),
            };
            match kept {
                Err(Refusal::DataLoss(text)) => {
                    let remedy = remedy(&text);
                    self.lasting(self.store.ledger(), text, remedy);
                }
                Err(refusal) => return Err(refusal),
                Ok(None) => self.lasting(path, "the log of an ended job is gone", again),
                Ok(Some(kept)) => {
                    if let Some(error) = damage_of_log(&kept, record.events).at(&path)? {
                        let path = if kept.is_in_files() { path } else { self.store.ledger() };
                        let text = error.to_string();
                        let remedy = remedy(&text);
                        self.lasting(path, text, remedy);
                    }
                }
            }
        }
        if record.runs.has_files {
            let path = self.store.job(&record.id).join(StoredResult::Files.file());
            let read = self.store.read(&record.id, StoredResult::Files.file()).ok().or_else(|| {
                // As an earlier version wrote it.
                fs::read(&path).ok().filter(|_| checkup.earlier)
            });
            if read.is_none_or(|text| serde_json::from_slice::<serde::de::IgnoredAny>(&text).is_err()) {
                self.lasting(path, "the files that macros have written cannot be read", again);
            }
        }
        Ok(())
    }

    fn folders(&mut self, rows: &LedgerContent) -> Result<(), Refusal> {
        let jobs = rows.jobs.iter().map(|record| &record.id);
        let unreadable = rows.unreadable.iter().filter(|row| !row.machine && !self.repair).map(|row| &row.key);
        let known: BTreeSet<&String> = jobs.chain(unreadable).collect();
        for id in self.store.jobs()? {
            if known.contains(&id) {
                continue;
            }
            let folder = self.store.job(&id);
            if self.lost {
                let aside = self.store.set_aside(&id)?;
                let remedy = format!("it is kept as '{}': submit the job again", aside.display());
                self.lasting(folder, "the row of the job of this folder is lost", remedy);
                continue;
            }
            if self.repair {
                self.store.remove_job(&id)?;
            }
            self.mendable(folder, "the folder belongs to no job", "it is removed", "");
        }
        Ok(())
    }

    fn blobs(&mut self, rows: &LedgerContent) -> Result<(), Refusal> {
        let mut damaged = BTreeSet::new();
        for tenant in self.store.tenants()? {
            self.blobs_of(&tenant, &mut damaged)?;
        }
        for (tenant, digest) in &rows.blobs {
            // A blob that this repair has removed is gone.
            let known = !self.repair && damaged.contains(&(tenant.to_owned(), digest.to_owned()));
            if !known && !self.blobs.of(tenant).has(digest) {
                let path = self.store.blob(tenant, digest);
                self.lasting(path, "a blob that jobs or machines need is gone", "upload the file again");
            }
        }
        Ok(())
    }

    /// Reads all blobs of a tenant.
    fn blobs_of(&mut self, tenant: &str, damaged: &mut BTreeSet<(String, String)>) -> Result<(), Refusal> {
        let blobs = self.blobs.of_tenant(tenant);
        for first in 0..=255u8 {
            step(format_args!("reading the blobs of tenant '{tenant}': {} %", u32::from(first) * 100 / 256));
            for name in self.store.blobs(tenant, &format!("{first:02x}"))? {
                let path = self.store.blob(tenant, &name);
                let what = if is_digest(&name) {
                    match blobs.has_its_digest(&name)? {
                        true => continue,
                        false => "the content of the blob has changed",
                    }
                } else if name.ends_with(".damaged") {
                    "the server has found that the content of the blob has changed"
                } else {
                    self.lasting(path, "the file is not a blob", "move it elsewhere");
                    continue;
                };
                if self.repair {
                    fs::remove_file(&path).at(&path)?;
                }
                self.mendable(path, what, "it is removed, ", "upload the file again");
                damaged.insert((tenant.to_owned(), name));
            }
        }
        Ok(())
    }
}

/// Why a log cannot be read to its last event; `None` if it can.
fn damage_of_log(log: &StoredLog, events: u64) -> io::Result<Option<io::Error>> {
    let whole = || {
        log.check_beginning()?;
        let mut read = Events::new(LogReader::open_ended(log, 0)?, events);
        (&mut read).for_each(drop);
        read.error().map_or(Ok(()), Err)
    };
    match whole() {
        Ok(()) => Ok(None),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Ok(Some(error)),
        Err(error) => Err(error),
    }
}
