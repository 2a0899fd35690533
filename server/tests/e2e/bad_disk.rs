//! A disk that fails by a seeded schedule, and that remembers the state after a loss of power.
//!
//! Synced data survive: the content of a file at its last sync, the names in a folder at the last sync of the folder.
//! Later writes survive in part, page by page, or not at all.

use std::collections::HashMap;
use std::ffi::OsString;
use std::io;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::UNIX_EPOCH;

use counterpoint_server::local::disk::{DiskOperation, Faults};

const PAGE: usize = 4096;
/// Numbers of the system's errors: I/O error, too many open files, no space left on the device.
const TROUBLES: [i32; 3] = [5, 24, 28];

/// Pseudo-random numbers, the same for the same seed.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end.max(1)
    }
}

/// The kind of a file or folder, for any name: plain numbers are reused for new files.
type Identity = (u64, u128);

fn identity(path: &Path) -> io::Result<Identity> {
    let meta = path.metadata()?;
    let born = meta.created().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
    Ok((meta.ino(), born.map_or(0, |at| at.as_nanos())))
}

struct State {
    random: Random,
    /// Of a thousand steps this many fail.
    permille: u64,
    steps: u64,
    failed: u64,
    /// The power fails at this step.
    power_until: u64,
    files: HashMap<Identity, Vec<u8>>,
    folders: HashMap<Identity, Vec<(OsString, Identity)>>,
}

/// The disk.
pub struct BadDisk {
    state: Mutex<State>,
    /// Whether syncs are remembered.
    remembers: bool,
}

impl BadDisk {
    pub fn new(seed: u64, remembers: bool) -> Self {
        let state = State {
            random: Random(seed),
            permille: 0,
            steps: 0,
            failed: 0,
            power_until: u64::MAX,
            files: HashMap::new(),
            folders: HashMap::new(),
        };
        Self { state: Mutex::new(state), remembers }
    }

    /// Lets this many of a thousand steps fail from now on.
    pub fn fail(&self, permille: u64) {
        self.state.lock().unwrap().permille = permille;
    }

    /// Lets the power fail after this many more steps.
    pub fn lose_power_after(&self, steps: u64) {
        let mut state = self.state.lock().unwrap();
        state.power_until = state.steps + steps;
    }

    pub fn has_power(&self) -> bool {
        self.state.lock().unwrap().has_power()
    }

    /// Steps that have failed.
    pub fn failed(&self) -> u64 {
        self.state.lock().unwrap().failed
    }

    /// Writes the state of the folder `from` after the loss of power to the folder `to`. With `torn`, pages written
    /// after the last sync survive by chance.
    pub fn survived(&self, from: &Path, to: &Path, torn: bool) {
        let mut state = self.state.lock().unwrap();
        let root = identity(from).unwrap();
        state.restore(root, from, to, torn);
    }
}

impl State {
    fn has_power(&self) -> bool {
        self.steps < self.power_until
    }

    fn restore(&mut self, folder: Identity, from: &Path, to: &Path, torn: bool) {
        std::fs::create_dir_all(to).unwrap();
        for (name, what) in self.folders.get(&folder).cloned().unwrap_or_default() {
            let (from, to) = (from.join(&name), to.join(&name));
            if what.1 == FOLDER {
                let Ok(inside) = identity(&from) else { continue };
                self.restore(inside, &from, &to, torn);
                continue;
            }
            let mut content = self.files.get(&what).cloned().unwrap_or_default();
            let now =
                if torn && identity(&from).is_ok_and(|now| now == what) { std::fs::read(&from) } else { Ok(vec![]) };
            for (number, page) in now.unwrap_or_default().chunks(PAGE).enumerate() {
                let at = number * PAGE;
                if self.random.below(2) == 0 {
                    content.resize(content.len().max(at + page.len()), 0);
                    content[at..at + page.len()].copy_from_slice(page);
                }
            }
            std::fs::write(to, content).unwrap();
        }
    }

    /// A file or folder has been synced.
    fn synced(&mut self, path: &Path) -> io::Result<()> {
        let what = identity(path)?;
        if !path.is_dir() {
            self.files.insert(what, std::fs::read(path)?);
            return Ok(());
        }
        let mut names = Vec::new();
        for entry in std::fs::read_dir(path)? {
            let entry = entry?;
            // A file may be gone by now.
            let Ok(mut inside) = identity(&entry.path()) else { continue };
            if entry.file_type()?.is_dir() {
                inside.1 = FOLDER;
            }
            names.push((entry.file_name(), inside));
        }
        self.folders.insert(what, names);
        Ok(())
    }
}

/// In the place of the time of birth: it is a folder, which keeps its name.
const FOLDER: u128 = u128::MAX;

impl Faults for BadDisk {
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        let mut state = self.state.lock().unwrap();
        state.steps += 1;
        if !state.has_power() {
            return Err(io::Error::other("there is no power"));
        }
        if state.random.below(1000) < state.permille {
            state.failed += 1;
            if let DiskOperation::Write(length) = step
                && state.random.below(2) == 0
            {
                return Ok(1 + usize::try_from(state.random.below(length as u64)).unwrap());
            }
            let number = TROUBLES[usize::try_from(state.random.below(3)).unwrap()];
            return Err(io::Error::from_raw_os_error(number));
        }
        if step == DiskOperation::Sync && self.remembers {
            state.synced(path)?;
        }
        Ok(usize::MAX)
    }

    fn free(&self) -> Option<u64> {
        Some(1 << 40)
    }
}

/// A new folder for each use.
pub fn numbered(folder: &Path, number: u64) -> PathBuf {
    folder.join(number.to_string())
}
