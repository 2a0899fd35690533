//! Logs and results in the folders of their jobs, and what the data folder says about its machine.

use std::fs::File;
use std::io::{self, Read, Write as _};
use std::path::PathBuf;

use super::disk::{Disk, Written};
use super::store::Store;
use crate::host::Host;
use crate::log::Logs;
use crate::log::kept::Kept;
use crate::log::writer::Place;

impl Logs for Store {
    fn begin(&self, id: &str) -> io::Result<Box<dyn Place>> {
        // Readers of the log of a run before this one keep that file.
        self.remove_log(id)?;
        let place = LogFile { disk: self.disk().clone(), path: self.log(id), durable: self.durable(), file: None };
        Ok(Box::new(place))
    }

    fn kept(&self, id: &str) -> Option<Kept> {
        Some(Kept::File(self.log(id))).filter(|_| self.log(id).is_file())
    }

    fn remove_log(&self, id: &str) -> io::Result<()> {
        self.remove_log(id)
    }

    fn write(&self, id: &str, name: &str, content: &[u8]) -> io::Result<()> {
        self.write(&self.job(id).join(name), content)
    }

    fn open(&self, id: &str, name: &str) -> io::Result<Box<dyn Read + Send>> {
        Ok(Box::new(File::open(self.job(id).join(name))?))
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
    path: PathBuf,
    durable: bool,
    file: Option<Written>,
}

impl Place for LogFile {
    fn write(&mut self, content: &[u8]) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                if let Some(folder) = self.path.parent() {
                    self.disk.create_folder(folder)?;
                }
                none.insert(self.disk.create(&self.path)?)
            }
        };
        file.write_all(content)
    }

    fn used(&self) -> bool {
        self.file.is_some()
    }

    fn sync(&self) -> io::Result<()> {
        match &self.file {
            Some(file) if self.durable => file.sync(),
            _ => Ok(()),
        }
    }
}

impl Host for Store {
    fn free(&self) -> Option<u64> {
        self.free()
    }

    fn mark(&self, id: &str, attempt: u32) -> io::Result<()> {
        self.mark(id, attempt)
    }

    fn unmark(&self, id: &str) {
        self.unmark(id);
    }

    fn marks(&self) -> io::Result<Vec<(String, u32)>> {
        self.marks()
    }

    fn scratch(&self) -> PathBuf {
        self.tmp()
    }

    fn release(&self) {
        self.release();
    }
}
