//! Files as macros see them: names below one folder, a current folder, temporary files, stores of values.
//!
//! A host gives a [`Shelf`] with the files themselves; the rules that do not depend on their location are here.
//! *Invariant:* a name that is absolute, or climbs out of the folder with `..`, never reaches the shelf. Facts:
//! reference functions.md 7.

mod mru;

use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::host::FileFn;
use crate::state::MacroState;
use crate::value::MacroValue;

/// Temporary files of one run.
const MOST_TEMPORARIES: usize = 100;
/// Steps that work on a file costs.
const FILE_TICKS: usize = 100;
/// Storage that macros may only read.
const STORAGE: &str = "//ICAMFS/";

/// Status of a file that does not exist.
pub const NOT_FOUND: i32 = 2;
/// Status of a file that cannot be read or written.
pub const FAILED: i32 = 5;
/// Status of a file name that is outside the folder of the run, or of a file that may not be used.
pub const FORBIDDEN: i32 = 13;
/// Status of arguments that make no sense.
pub const INVALID: i32 = 22;

/// Facts of a file or folder.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FileFacts {
    /// Bytes.
    pub size: u64,
    /// Seconds since 1970 of the last access, change of the entry, and change of the content.
    pub times: [f64; 3],
    /// Bits: type and permissions as the system has them.
    pub mode: u32,
    /// Number of the owner.
    pub owner: u32,
    /// Number of the group.
    pub group: u32,
    /// Bits: 4 may be read, 2 may be written, 1 may be run.
    pub allowed: u8,
    /// It is a folder.
    pub folder: bool,
}

impl FileFacts {
    /// A file in memory that may be read, and written unless it is stored with the machine.
    #[must_use]
    pub fn file(size: usize, stored: bool) -> Self {
        let allowed = if stored { 5 } else { 6 };
        Self { size: size as u64, mode: 0o644, allowed, ..Self::default() }
    }

    /// A folder in memory.
    #[must_use]
    pub fn folder() -> Self {
        Self { mode: 0o755, allowed: 7, folder: true, ..Self::default() }
    }
}

/// Files by name. A name has `/` between its parts and stays inside; one that begins with `//ICAMFS/` is a file stored
/// with the machine, found in any letter case, and never written. A failure is a status for `$ERRNO`.
pub trait Shelf {
    /// Text of a file.
    ///
    /// # Errors
    /// The status.
    fn read(&mut self, path: &str) -> Result<String, i32>;

    /// Replaces a file.
    ///
    /// # Errors
    /// The status.
    fn write(&mut self, path: &str, text: &str) -> Result<(), i32>;

    /// Facts of a file or folder; `.` is the folder of the run.
    ///
    /// # Errors
    /// The status.
    fn facts(&mut self, path: &str) -> Result<FileFacts, i32>;

    /// Tells whether a file that does not exist could be written; false where its folder is missing.
    fn creatable(&mut self, path: &str) -> bool {
        let _ = path;
        true
    }

    /// Removes a file.
    fn remove(&mut self, path: &str);
}

/// The state of the file functions of one run.
#[derive(Clone, Debug, Default)]
pub struct MacroFolder {
    /// Current folder below the folder of the run.
    current: String,
    temporaries: Vec<String>,
    stores: Vec<Option<mru::MruStore>>,
}

impl MacroFolder {
    /// The current folder below the folder of the run, empty for the folder of the run itself.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.current
    }

    /// The name of a file below the folder of the run, none if it leads out of it.
    fn located(&self, path: &str) -> Option<String> {
        let path = path.trim();
        if stored(path) {
            return Some(path.to_owned());
        }
        let path = path.replace('\\', "/");
        if path.starts_with('/') || path.contains([':', '\0']) {
            return None;
        }
        let mut parts: Vec<&str> = Vec::new();
        for part in self.current.split('/').chain(path.split('/')) {
            match part {
                "" | "." => {}
                ".." => {
                    parts.pop()?;
                }
                part => parts.push(part),
            }
        }
        Some(if parts.is_empty() { ".".to_owned() } else { parts.join("/") })
    }

    /// [`MacroFolder::located`], with a warning for a name that leads out.
    fn place(&self, state: &mut MacroState, path: &str) -> Result<String, i32> {
        self.located(path).ok_or_else(|| {
            let message = format!("'{path}' is outside the folder of the run");
            state.warn(MacroFault::new(DiagnosticNumber::OUTSIDE, message));
            FORBIDDEN
        })
    }

    /// Text of a file.
    ///
    /// # Errors
    /// The status.
    pub fn load(&self, shelf: &mut dyn Shelf, path: &str) -> Result<String, i32> {
        shelf.read(&self.located(path).ok_or(FORBIDDEN)?)
    }

    /// Replaces a file.
    ///
    /// # Errors
    /// The status.
    pub fn save(&self, shelf: &mut dyn Shelf, path: &str, text: &str) -> Result<(), i32> {
        let place = self.located(path).filter(|place| !stored(place) && place != ".").ok_or(FORBIDDEN)?;
        shelf.write(&place, text)
    }

    /// Status of writing a file.
    pub fn writable(&self, shelf: &mut dyn Shelf, path: &str) -> i32 {
        let Some(place) = self.located(path).filter(|place| !stored(place)) else { return FORBIDDEN };
        match shelf.facts(&place) {
            Ok(facts) if facts.folder || facts.allowed & 2 == 0 => FORBIDDEN,
            Ok(_) => 0,
            Err(_) if shelf.creatable(&place) => 0,
            Err(status) => status,
        }
    }

    /// Status of opening a file. The file may be missing if it can be created; otherwise it must be a regular file
    /// below the folder of the run.
    pub fn openable(&self, shelf: &mut dyn Shelf, state: &mut MacroState, path: &str) -> i32 {
        let found = self.place(state, path).and_then(|place| match shelf.facts(&place) {
            Ok(facts) if facts.folder || facts.allowed & 4 == 0 => Err(FORBIDDEN),
            Ok(_) => Ok(()),
            Err(NOT_FOUND) if !stored(&place) && shelf.creatable(&place) => Ok(()),
            Err(status) => Err(status),
        });
        found.err().unwrap_or(0)
    }

    /// A function of files; `program` is the name of the NC program.
    ///
    /// # Errors
    /// Arguments that make no sense, too many steps.
    pub fn function(
        &mut self,
        shelf: &mut dyn Shelf,
        state: &mut MacroState,
        (function, arguments): (FileFn, &[MacroValue]),
        program: &str,
    ) -> Outcome<MacroValue> {
        state.spend(FILE_TICKS)?;
        match function {
            FileFn::FileAccess => Ok(self.access(shelf, state, arguments)),
            FileFn::FileStatus => self.stat(shelf, state, arguments),
            FileFn::CurrentFolder => Ok(self.current()),
            FileFn::ChangeFolder => Ok(self.change(shelf, state, arguments)),
            FileFn::TemporaryFile => Ok(self.temporary(shelf, state, arguments)),
            _ => self.most_recently_used(shelf, state, (function, arguments), program),
        }
    }

    fn access(&self, shelf: &mut dyn Shelf, state: &mut MacroState, arguments: &[MacroValue]) -> MacroValue {
        let mode = arguments.get(1).and_then(MacroValue::as_real).unwrap_or(6.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let wanted = mode.clamp(0.0, 7.0) as u8;
        let found = self.place(state, text(arguments, 0)).and_then(|place| shelf.facts(&place));
        MacroValue::Logical(found.is_ok_and(|facts| facts.allowed & wanted == wanted))
    }

    fn stat(&self, shelf: &mut dyn Shelf, state: &mut MacroState, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        const ITEMS: [&str; 7] = ["mtime", "size", "atime", "ctime", "mode", "owner", "group"];
        let wanted = text(arguments, 1).trim().to_lowercase();
        let Some(item) = ITEMS.into_iter().find(|item| !wanted.is_empty() && item.starts_with(&wanted)) else {
            let message = format!("'{wanted}' is not one of size, atime, ctime, mtime, mode, owner, group");
            return Err(MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, message));
        };
        let found = self.place(state, text(arguments, 0)).and_then(|place| shelf.facts(&place));
        let facts = match found {
            Ok(facts) => facts,
            Err(status) => {
                state.status = status;
                return Ok(MacroValue::Real(-1.0));
            }
        };
        state.status = 0;
        let [accessed, changed, modified] = facts.times;
        #[allow(clippy::cast_precision_loss)]
        let size = facts.size as f64;
        Ok(MacroValue::Real(match item {
            "size" => size,
            "atime" => accessed,
            "ctime" => changed,
            "mtime" => modified,
            "mode" => f64::from(facts.mode),
            "owner" => f64::from(facts.owner),
            _ => f64::from(facts.group),
        }))
    }

    /// Current folder, `.` for the folder of the run.
    fn current(&self) -> MacroValue {
        MacroValue::text(if self.current.is_empty() { "." } else { self.current.as_str() })
    }

    /// Names of folders are relative to the folder of the run, so that a result of `$FGETCWD` leads back.
    fn change(&mut self, shelf: &mut dyn Shelf, state: &mut MacroState, arguments: &[MacroValue]) -> MacroValue {
        let before = std::mem::take(&mut self.current);
        let found = self.place(state, text(arguments, 0)).and_then(|place| match shelf.facts(&place) {
            Ok(facts) if facts.folder => Ok(if place == "." { String::new() } else { place }),
            Ok(_) => Err(INVALID),
            Err(status) => Err(status),
        });
        state.status = found.as_ref().err().copied().unwrap_or(0);
        self.current = found.unwrap_or(before);
        self.current()
    }

    fn temporary(&mut self, shelf: &mut dyn Shelf, state: &mut MacroState, arguments: &[MacroValue]) -> MacroValue {
        let content = match arguments.first() {
            Some(_) => self.place(state, text(arguments, 0)).and_then(|place| shelf.read(&place)),
            None => Ok(String::new()),
        };
        let content = if self.temporaries.len() < MOST_TEMPORARIES { content } else { Err(FAILED) };
        let mut number = self.temporaries.len() + 1;
        let name = loop {
            let name = format!("macro-{number}.tmp");
            match self.place(state, &name).and_then(|place| shelf.facts(&place)) {
                Ok(_) => number += 1,
                Err(_) => break name,
            }
        };
        let made = content.and_then(|content| self.save(shelf, &name, &content));
        state.status = made.as_ref().err().copied().unwrap_or(0);
        if made.is_err() {
            return MacroValue::text("");
        }
        self.temporaries.extend(self.located(&name));
        MacroValue::text(name)
    }

    /// Removes the temporary files of the run.
    pub fn clean(&mut self, shelf: &mut dyn Shelf) {
        std::mem::take(&mut self.temporaries).iter().for_each(|place| shelf.remove(place));
    }
}

/// Whether a name is that of a file stored with the machine.
#[must_use]
pub fn stored(path: &str) -> bool {
    path.get(..STORAGE.len()).is_some_and(|start| start.eq_ignore_ascii_case(STORAGE))
}

/// An argument as a text.
pub(super) fn text(arguments: &[MacroValue], position: usize) -> &str {
    arguments.get(position).and_then(MacroValue::as_text).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out() {
        let folder = MacroFolder { current: "a".into(), ..MacroFolder::default() };
        assert_eq!(folder.located("./b").as_deref(), Some("a/b"));
        assert_eq!(folder.located("").as_deref(), Some("a"));
        assert_eq!(folder.located("../b/../x").as_deref(), Some("x"));
        assert_eq!(folder.located("//icamfs/x").as_deref(), Some("//icamfs/x"));
        for path in ["../..", "../../x", "b/../../../x", "/etc/x", "\\x", "c:/x", "..\\..\\x", "x\0"] {
            assert_eq!(folder.located(path), None, "{path}");
        }
    }
}
