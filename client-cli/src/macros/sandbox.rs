//! The access of a running macro: standard output, the console, and files below the current folder.
//!
//! *Invariant:* only PPRINT output and the trace go to standard output, line by line as they are produced. A path never
//! leads outside the folder, not even through a link.

use std::cell::RefCell;
use std::io::{self, BufRead as _, Read as _};
use std::rc::Rc;
use std::time::{SystemTime, UNIX_EPOCH};

use cap_std::ambient_authority;
use cap_std::fs::{Dir, Metadata, OpenOptions};
use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang::host::{FAILED, FORBIDDEN, FileFacts, NOT_FOUND, Shelf};
use counterpoint_lang_standalone::{HostEnvironment, OutputStream};

use crate::error::Error;
use crate::say;

/// Largest file a macro can read, in bytes.
const LARGEST: u64 = 256 << 20;

#[derive(Debug)]
pub(super) struct MacroSandbox {
    folder: Dir,
    /// Why standard output cannot be written any more.
    broken: Rc<RefCell<Option<Error>>>,
}

impl MacroSandbox {
    /// The current folder.
    pub(super) fn here() -> Result<Self, Error> {
        let folder = Dir::open_ambient_dir(".", ambient_authority()).map_err(Error::file("."))?;
        Ok(Self { folder, broken: Rc::default() })
    }

    /// Stores the reason here when standard output fails.
    pub(super) fn telling(self, broken: Rc<RefCell<Option<Error>>>) -> Self {
        Self { broken, ..self }
    }

    /// Opens a regular file; pipes and devices could block indefinitely.
    fn open(&self, path: &str, options: &OpenOptions) -> Result<cap_std::fs::File, i32> {
        if !self.folder.metadata(path).map_err(|error| status(&error))?.is_file() {
            return Err(FORBIDDEN);
        }
        self.folder.open_with(path, options).map_err(|error| status(&error))
    }

    fn may(&self, path: &str, options: &OpenOptions) -> bool {
        self.open(path, options).is_ok()
    }
}

fn status(error: &io::Error) -> i32 {
    match error.kind() {
        io::ErrorKind::NotFound => NOT_FOUND,
        io::ErrorKind::PermissionDenied => FORBIDDEN,
        _ => FAILED,
    }
}

fn seconds(time: io::Result<cap_std::time::SystemTime>) -> f64 {
    let since = time.map(|time| time.into_std().duration_since(UNIX_EPOCH));
    since.map_or(0.0, |since| since.map_or(0.0, |since| since.as_secs_f64()))
}

#[cfg(unix)]
fn owner(metadata: &Metadata) -> (u32, u32, u32) {
    use cap_std::fs::MetadataExt as _;
    (metadata.mode(), metadata.uid(), metadata.gid())
}

#[cfg(not(unix))]
fn owner(metadata: &Metadata) -> (u32, u32, u32) {
    (if metadata.permissions().readonly() { 0o444 } else { 0o666 }, 0, 0)
}

impl Shelf for MacroSandbox {
    fn read(&mut self, path: &str) -> Result<String, i32> {
        let file = self.open(path, OpenOptions::new().read(true))?;
        let mut bytes = Vec::new();
        let read = file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|error| status(&error))?;
        if read as u64 > LARGEST {
            return Err(FAILED);
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn write(&mut self, path: &str, text: &str) -> Result<(), i32> {
        if self.folder.metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
            return Err(FORBIDDEN);
        }
        self.folder.write(path, text).map_err(|error| status(&error))
    }

    fn facts(&mut self, path: &str) -> Result<FileFacts, i32> {
        let metadata = self.folder.metadata(path).map_err(|error| status(&error))?;
        let (mode, owner, group) = owner(&metadata);
        let modified = seconds(metadata.modified());
        let folder = metadata.is_dir();
        let mut allowed = if folder { 7 } else { 0 };
        if !folder {
            allowed |= 4 * u8::from(self.may(path, OpenOptions::new().read(true)));
            allowed |= 2 * u8::from(self.may(path, OpenOptions::new().write(true)));
            allowed |= u8::from(mode & 0o111 != 0);
        }
        let times = [seconds(metadata.accessed()), modified, modified];
        Ok(FileFacts { size: metadata.len(), times, mode, owner, group, allowed, folder })
    }

    fn creatable(&mut self, path: &str) -> bool {
        let folder = path.rsplit_once('/').map_or(".", |(folder, _)| folder);
        let facts = self.folder.metadata(folder);
        facts.is_ok_and(|facts| facts.is_dir() && !facts.permissions().readonly())
    }

    fn remove(&mut self, path: &str) {
        let _ = self.folder.remove_file(path);
    }
}

impl HostEnvironment for MacroSandbox {
    fn line(&mut self, stream: OutputStream, text: &str) -> bool {
        if stream == OutputStream::Console {
            say::status_line(text);
            return true;
        }
        match say::line(text) {
            Ok(()) => true,
            Err(error) => {
                self.broken.borrow_mut().get_or_insert(error);
                false
            }
        }
    }

    fn report(&mut self, diagnostic: &MacroDiagnostic) {
        super::say_finding(diagnostic);
    }

    fn console(&mut self) -> Option<String> {
        let mut line = Vec::new();
        let read = io::stdin().lock().take(LARGEST).read_until(b'\n', &mut line).ok()?;
        (read > 0).then(|| String::from_utf8_lossy(&line).trim_end_matches(['\n', '\r']).to_owned())
    }

    fn now(&self) -> (f64, i32, String) {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        (since.map_or(0.0, |since| since.as_secs_f64()), 0, "UTC".to_owned())
    }

    fn environment(&self, name: &str) -> Option<String> {
        std::env::var(name).ok()
    }
}
