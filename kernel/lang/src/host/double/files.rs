//! Files and folders of the double: in memory, or below the folder of a run.
//!
//! Invariant: a name that is absolute or climbs with `..` never reaches the outside. Facts: reference functions.md 7.

use super::Test;
use super::outside::{FAILED, FORBIDDEN, Facts, INVALID, NOT_FOUND};
use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::value::Value;
use crate::vm::State;

/// Temporary files of one run.
const MOST_TEMPORARIES: usize = 100;

/// Storage that macros may only read.
const STORAGE: &str = "//ICAMFS/";

impl Test {
    /// The name of a file below the folder of the run, none if it leads out of it.
    fn located(&self, path: &str) -> Option<String> {
        let path = path.trim();
        if stored(path) {
            return Some(path.to_owned());
        }
        let path = path.replace('\\', "/");
        let drive = path.as_bytes().get(1) == Some(&b':');
        if path.starts_with('/') || drive || path.split('/').any(|part| part == "..") {
            return None;
        }
        let parts = self.folder.split('/').chain(path.split('/')).filter(|part| !part.is_empty() && *part != ".");
        let joined = parts.collect::<Vec<_>>().join("/");
        Some(if joined.is_empty() { ".".to_owned() } else { joined })
    }

    /// [`Test::located`], with a warning for a name that leads out.
    fn place(&self, state: &mut State, path: &str) -> Result<String, i32> {
        self.located(path).ok_or_else(|| {
            let message = format!("'{path}' leads out of the folder of the run");
            state.warn(Fault::new(Number::OUTSIDE, message));
            FORBIDDEN
        })
    }

    fn facts(&mut self, place: &str) -> Result<Facts, i32> {
        if stored(place) || self.outside.is_none() {
            let file = self.stored_text(place).map(str::len);
            let folder = place == "." || self.files.keys().any(|name| name.starts_with(&format!("{place}/")));
            let allowed = if stored(place) { 5 } else { 6 };
            return match file {
                Some(size) => Ok(Facts { size: size as u64, mode: 0o644, allowed, ..Facts::default() }),
                None if folder => Ok(Facts { mode: 0o755, allowed: 7, folder: true, ..Facts::default() }),
                None => Err(NOT_FOUND),
            };
        }
        self.outside.as_mut().map_or(Err(NOT_FOUND), |outside| outside.facts(place))
    }

    fn stored_text(&self, place: &str) -> Option<&str> {
        let exact = self.files.get(place);
        let same = || self.files.iter().find(|(name, _)| stored(place) && name.eq_ignore_ascii_case(place));
        exact.or_else(|| same().map(|(_, text)| text)).map(String::as_str)
    }

    /// Text of a file.
    pub(super) fn load(&mut self, path: &str) -> Result<String, i32> {
        let place = self.located(path).ok_or(FORBIDDEN)?;
        match &mut self.outside {
            Some(outside) if !stored(&place) => outside.read(&place),
            _ => self.stored_text(&place).map(str::to_owned).ok_or(NOT_FOUND),
        }
    }

    /// Replaces a file.
    pub(super) fn save(&mut self, path: &str, text: &str) -> Result<(), i32> {
        let place = self.located(path).ok_or(FORBIDDEN)?;
        if stored(&place) {
            return Err(FORBIDDEN);
        }
        match &mut self.outside {
            Some(outside) => outside.write(&place, text),
            None => {
                self.files.insert(place, text.to_owned());
                Ok(())
            }
        }
    }

    /// Status of opening a file: it may be missing, but it must be one and lie below the folder of the run.
    pub(super) fn openable(&mut self, state: &mut State, path: &str) -> i32 {
        let found = self.place(state, path).and_then(|place| match self.facts(&place) {
            Ok(facts) if facts.folder || facts.allowed & 4 == 0 => Err(FORBIDDEN),
            Err(NOT_FOUND) if stored(&place) => Err(NOT_FOUND),
            Ok(_) | Err(NOT_FOUND) => Ok(()),
            Err(status) => Err(status),
        });
        found.err().unwrap_or(0)
    }

    pub(super) fn access(&mut self, state: &mut State, arguments: &[Value]) -> Value {
        let mode = arguments.get(1).and_then(Value::as_real).unwrap_or(6.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let wanted = mode.clamp(0.0, 7.0) as u8;
        let found = self.place(state, text(arguments, 0)).and_then(|place| self.facts(&place));
        Value::Logical(found.is_ok_and(|facts| facts.allowed & wanted == wanted))
    }

    pub(super) fn stat(&mut self, state: &mut State, arguments: &[Value]) -> Outcome<Value> {
        const ITEMS: [&str; 7] = ["mtime", "size", "atime", "ctime", "mode", "owner", "group"];
        let wanted = text(arguments, 1).trim().to_lowercase();
        let Some(item) = ITEMS.into_iter().find(|item| !wanted.is_empty() && item.starts_with(&wanted)) else {
            let message = format!("'{wanted}' is none of size, atime, ctime, mtime, mode, owner, group");
            return Err(Fault::new(Number::TYPE_MISMATCH, message));
        };
        let found = self.place(state, text(arguments, 0)).and_then(|place| self.facts(&place));
        let facts = match found {
            Ok(facts) => facts,
            Err(status) => {
                state.status = status;
                return Ok(Value::Real(-1.0));
            }
        };
        state.status = 0;
        let [accessed, changed, modified] = facts.times;
        #[allow(clippy::cast_precision_loss)]
        let size = facts.size as f64;
        Ok(Value::Real(match item {
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
    pub(super) fn current(&self) -> Value {
        Value::text(if self.folder.is_empty() { "." } else { self.folder.as_str() })
    }

    /// Names of folders count from the folder of the run, so that what `$FGETCWD` gave leads back.
    pub(super) fn change(&mut self, state: &mut State, arguments: &[Value]) -> Value {
        let before = std::mem::take(&mut self.folder);
        let found = self.place(state, text(arguments, 0)).and_then(|place| match self.facts(&place) {
            Ok(facts) if facts.folder => Ok(if place == "." { String::new() } else { place }),
            Ok(_) => Err(INVALID),
            Err(status) => Err(status),
        });
        state.status = found.as_ref().err().copied().unwrap_or(0);
        self.folder = found.unwrap_or(before);
        self.current()
    }

    pub(super) fn temporary(&mut self, state: &mut State, arguments: &[Value]) -> Value {
        let content = match arguments.first() {
            Some(_) => self.place(state, text(arguments, 0)).and_then(|_| self.load(text(arguments, 0))),
            None => Ok(String::new()),
        };
        let content = if self.temporaries.len() < MOST_TEMPORARIES { content } else { Err(FAILED) };
        let mut number = self.temporaries.len() + 1;
        let name = loop {
            let name = format!("macro-{number}.tmp");
            match self.place(state, &name).and_then(|place| self.facts(&place)) {
                Ok(_) => number += 1,
                Err(_) => break name,
            }
        };
        let made = content.and_then(|content| self.save(&name, &content));
        state.status = made.as_ref().err().copied().unwrap_or(0);
        if made.is_err() {
            return Value::text("");
        }
        if let Ok(place) = self.place(state, &name) {
            self.temporaries.push(place);
        }
        Value::text(name)
    }

    /// Removes the temporary files of the run.
    pub fn clean(&mut self) {
        for place in std::mem::take(&mut self.temporaries) {
            match &mut self.outside {
                Some(outside) => outside.remove(&place),
                None => {
                    self.files.remove(&place);
                }
            }
        }
    }
}

fn stored(path: &str) -> bool {
    path.get(..STORAGE.len()).is_some_and(|start| start.eq_ignore_ascii_case(STORAGE))
}

/// An argument as a text.
pub(super) fn text(arguments: &[Value], position: usize) -> &str {
    arguments.get(position).and_then(Value::as_text).unwrap_or("")
}
