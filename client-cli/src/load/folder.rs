//! Size of the data folder of a server on this machine.
//!
//! *Invariant:* a large folder is measured less often: measuring takes a tenth of the time at most.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The ledger, which a server has open as long as it runs.
const LEDGER: &str = "ledger.redb";

/// A folder that is measured beside everything else.
#[derive(Debug)]
pub(super) struct FolderGauge(Arc<AtomicU64>);

impl FolderGauge {
    /// The data folder of a process: the one in which it has a ledger open.
    pub(super) fn of(pid: u32) -> Option<Self> {
        let open = std::fs::read_dir(format!("/proc/{pid}/fd")).ok()?.filter_map(Result::ok);
        let files = open.filter_map(|fd| std::fs::read_link(fd.path()).ok());
        let ledger = files.into_iter().find(|path| path.file_name().is_some_and(|name| name == LEDGER))?;
        Self::measure(ledger.parent()?.to_owned())
    }

    fn measure(folder: PathBuf) -> Option<Self> {
        let bytes = Arc::new(AtomicU64::new(size(&folder)));
        let kept = Arc::downgrade(&bytes);
        let work = move || {
            while let Some(bytes) = kept.upgrade() {
                let begin = Instant::now();
                bytes.store(size(&folder), Ordering::Relaxed);
                drop(bytes);
                std::thread::sleep((begin.elapsed() * 10).max(Duration::from_secs(1)));
            }
        };
        std::thread::Builder::new().name("folder".to_owned()).spawn(work).ok()?;
        Some(Self(bytes))
    }

    /// Bytes of its files when they were last measured.
    pub(super) fn bytes(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Bytes of all files of a folder; files that come and go meanwhile count or not.
fn size(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let sizes = entries.map(|entry| match entry.file_type() {
        Ok(kind) if kind.is_dir() => size(&entry.path()),
        Ok(kind) if kind.is_file() => entry.metadata().map_or(0, |file| file.len()),
        _ => 0,
    });
    sizes.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_folder_is_that_of_all_its_files() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("a/b")).unwrap();
        std::fs::write(folder.path().join("a/b/c"), [0; 300]).unwrap();
        std::fs::write(folder.path().join("d"), [0; 40]).unwrap();
        assert_eq!(FolderGauge::measure(folder.path().to_owned()).unwrap().bytes(), 340);
        assert_eq!(size(&folder.path().join("none")), 0);
    }
}
