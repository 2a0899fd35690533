//! Logs and results in the folders of their jobs, and the data folder's record of its machine.

use std::fs::File;
use std::io::{self, BufReader, Read, Write as _};
use std::path::{Path, PathBuf};

use super::disk::{Disk, DiskFile};
use super::marks::MarkFile;
use super::spare;
use super::store::DataFolder;
use crate::host::{RunMark, ServerHost};
use crate::log::kept::{LogPaths, StoredLog};
use crate::log::wanted::ResultGate;
use crate::log::writer::LogDestination;
use crate::log::{Logs, segments};

/// Bytes from which on a log that has ended is compressed.
const PACKED_FROM: u64 = 64 * 1024;
/// Bytes read at once of a log that is compressed.
const READ: usize = 256 * 1024;

impl Logs for DataFolder {
    fn begin(&self, id: &str) -> io::Result<Box<dyn LogDestination>> {
        // Readers of the log of a run before this one keep that file.
        self.remove_job(id)?;
        let place = LogFile {
            disk: self.disk().clone(),
            job: id.to_owned(),
            files: self.logs(id),
            durable: self.durable(),
            file: None,
            packed: None,
        };
        Ok(Box::new(place))
    }

    fn kept(&self, id: &str) -> Option<StoredLog> {
        Some(self.logs(id)).filter(LogPaths::there).map(|files| StoredLog::in_files(id, files))
    }

    fn write(&self, id: &str, name: &str, content: &[u8]) -> io::Result<()> {
        self.write(id, name, content)
    }

    fn write_spare(&self, id: &str, name: &str, content: &[u8], wanted: &ResultGate) -> io::Result<()> {
        self.write_spare(id, name, content, wanted)
    }

    fn open(&self, id: &str, name: &str) -> io::Result<Box<dyn Read + Send>> {
        Ok(Box::new(spare::whole(File::open(self.job(id).join(name))?, id, name)?))
    }

    fn sync(&self, id: &str) -> io::Result<()> {
        self.sync_job(id)
    }

    fn remove(&self, id: &str) -> io::Result<()> {
        self.remove_job(id)
    }

    fn jobs(&self) -> io::Result<Vec<String>> {
        self.jobs()
    }
}

/// A log on its way to the disk; its file comes with the first write.
#[derive(Debug)]
struct LogFile {
    disk: Disk,
    job: String,
    files: LogPaths,
    durable: bool,
    file: Option<DiskFile>,
    /// Its compressed form.
    packed: Option<DiskFile>,
}

impl LogFile {
    fn pack_to(&self, segments: &Path) -> io::Result<(DiskFile, u64)> {
        let mut packed = self.disk.create(segments)?;
        let mut plain = BufReader::with_capacity(READ, self.disk.open(&self.files.plain)?);
        let bytes = segments::pack(&self.job, &mut plain, &mut packed)?;
        Ok((packed, bytes))
    }

    /// The compressed form is not available. While the plain form exists, it is not read.
    fn stay_plain(&mut self, error: &io::Error) {
        tracing::warn!(%error, "the log stays as it is, without compression");
        self.packed = None;
        let _ = std::fs::remove_file(&self.files.segments);
    }
}

impl LogDestination for LogFile {
    fn write(&mut self, content: &[u8]) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                if let Some(folder) = self.files.plain.parent() {
                    self.disk.create_folder(folder)?;
                }
                none.insert(self.disk.create(&self.files.plain)?)
            }
        };
        file.write_all(content)
    }

    fn used(&self) -> bool {
        self.file.is_some()
    }

    fn pack(&mut self) -> io::Result<u64> {
        let length = self.files.plain.metadata()?.len();
        if !self.durable || length < PACKED_FROM {
            return Ok(length);
        }
        match self.pack_to(&self.files.segments) {
            Ok((packed, bytes)) => {
                self.packed = Some(packed);
                Ok(bytes)
            }
            Err(error) => {
                self.stay_plain(&error);
                Ok(length)
            }
        }
    }

    fn seal(mut self: Box<Self>) -> io::Result<()> {
        match self.packed.as_ref().map(DiskFile::sync) {
            Some(Ok(())) => return std::fs::remove_file(&self.files.plain),
            Some(Err(error)) => self.stay_plain(&error),
            None => {}
        }
        match &self.file {
            Some(file) if self.durable => file.sync(),
            _ => Ok(()),
        }
    }
}

impl ServerHost for DataFolder {
    fn free(&self) -> Option<u64> {
        self.free()
    }

    fn mark(&self, mark: &RunMark) -> io::Result<()> {
        self.marks().map_or(Ok(()), |marks| marks.mark(mark))
    }

    fn unmark(&self, id: &str) {
        if let Some(marks) = self.marks() {
            marks.unmark(id);
        }
    }

    fn marks(&self) -> io::Result<Vec<RunMark>> {
        Ok(self.marks().map(MarkFile::all).unwrap_or_default())
    }

    fn scratch(&self) -> PathBuf {
        self.tmp()
    }

    fn release(&self) {
        self.release();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::reader::LogReader;
    use crate::log::reader::tests::{earlier, plain};

    /// Numbers of the events after a cursor, up to the end.
    fn events(kept: &StoredLog, after: u64) -> Vec<u64> {
        let mut reader = LogReader::open_ended(kept, after).unwrap();
        let mut all = Vec::new();
        while let Some(batch) = reader.next_batch().unwrap() {
            all.extend(batch.first..=batch.last);
        }
        all
    }

    #[test]
    fn a_log_reads_the_same_plain_sealed_and_while_both_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let store = DataFolder::open(folder.path().to_owned(), true, Disk::default()).unwrap();
        let (log, files) = (plain("j", 30_000), store.logs("j"));
        let mut place = Logs::begin(&store, "j").unwrap();
        place.write(&log).unwrap();
        // As a server that did not compress has left it.
        let kept = store.kept("j").unwrap();
        let cursors = [0, 1, 255, 256, 12_345, 29_999, 30_000];
        let expected: Vec<_> = cursors.iter().map(|after| (after + 1..=30_000).collect::<Vec<_>>()).collect();
        let read = || cursors.iter().map(|after| events(&kept, *after)).collect::<Vec<_>>();
        assert_eq!((read(), kept.length().unwrap()), (expected.clone(), log.len() as u64));
        let bytes = place.pack().unwrap();
        assert_eq!(read(), expected, "both are there");
        place.seal().unwrap();
        assert!(!files.plain.exists() && bytes == files.segments.metadata().unwrap().len() && bytes < log.len() as u64);
        assert_eq!((read(), kept.length().unwrap()), (expected.clone(), log.len() as u64));
        std::fs::write(&files.plain, &log).unwrap();
        std::fs::write(&files.segments, "half").unwrap();
        assert_eq!((read(), kept.length().unwrap()), (expected, log.len() as u64));
        store.write("j", "files.json", b"[]").unwrap();
        let place = Logs::begin(&store, "j").unwrap();
        assert!(store.kept("j").is_none() && !place.used(), "a run begins without the log of the run before it");
        assert!(Logs::open(&store, "j", "files.json").is_err(), "and without its files");
    }

    #[test]
    fn results_that_are_not_wanted_any_more_do_not_bring_a_folder_back() {
        let folder = tempfile::tempdir().unwrap();
        let store = DataFolder::open(folder.path().to_owned(), true, Disk::default()).unwrap();
        let wanted = ResultGate::default();
        store.write_spare("j", "summary.json", b"{}", &wanted).unwrap();
        wanted.end();
        store.remove_job("j").unwrap();
        let late = store.write_spare("j", "timeline.json", b"{}", &wanted);
        assert_eq!(late.unwrap_err().kind(), io::ErrorKind::Interrupted);
        assert!(!store.job("j").exists() && std::fs::read_dir(store.tmp()).unwrap().next().is_none());
    }

    #[test]
    fn a_log_is_read_as_that_of_its_own_job_only() {
        let folder = tempfile::tempdir().unwrap();
        let store = DataFolder::open(folder.path().to_owned(), true, Disk::default()).unwrap();
        let read = |job: &str| {
            let mut reader = LogReader::open_ended(&store.kept(job).unwrap(), 0)?;
            while reader.next_batch()?.is_some() {}
            Ok::<(), io::Error>(())
        };
        for (form, log, found_by_others) in [("new", plain("a", 3000), false), ("earlier", earlier(3000), true)] {
            for packed in [false, true] {
                let mut place = Logs::begin(&store, "a").unwrap();
                place.write(&log).unwrap();
                if packed {
                    place.pack().unwrap();
                    place.seal().unwrap();
                }
                read("a").unwrap();
                let _ = std::fs::remove_dir_all(store.job("b"));
                std::fs::rename(store.job("a"), store.job("b")).unwrap();
                let read = read("b");
                assert_eq!(read.is_ok(), found_by_others, "{form}, packed: {packed}");
                assert!(read.is_ok() || read.unwrap_err().to_string().contains("job 'b'"));
            }
        }
    }
}
