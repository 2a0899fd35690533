//! Files of macros: those of the job are read, what is written stays in memory until the job ends.
//!
//! Invariants: a name never leads out of the job; how much may be written is bounded; a file that one kernel writes is
//! seen by that kernel alone, so that no result depends on who was faster.

use counterpoint_lang::diag::Number;
use counterpoint_lang::fault::Fault;
use counterpoint_lang::host::{FORBIDDEN, NOT_FOUND};
use counterpoint_lang::vm::State;

use crate::channel::Kernel;
use crate::diag;
use crate::files::Bytes;
use crate::machine::model::StoredFile;

/// Files that the macros of a kernel may write.
const MOST_FILES: usize = 200;

/// Bytes in all of them.
const MOST_BYTES: usize = 64 << 20;

/// The path below the job's folder, none if it leads out of it.
fn inside(path: &str) -> Option<String> {
    let path = path.replace('\\', "/");
    if path.starts_with('/') || path.contains([':', '\0']) {
        return None;
    }
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    if parts.is_empty() { None } else { Some(parts.join("/")) }
}

impl Kernel<'_> {
    pub(super) fn openable(&mut self, state: &mut State, path: &str) -> i32 {
        if self.stored_file(path).is_some() {
            return 0;
        }
        if inside(path).is_some() {
            return 0;
        }
        state.warn(Fault::new(Number::OUTSIDE, format!("the file name '{path}' leads out of the job")));
        FORBIDDEN
    }

    /// A file stored with the machine, named in full.
    fn stored_file(&self, path: &str) -> Option<&Bytes> {
        let path = path.replace('\\', "/");
        let root = path.get(..StoredFile::ROOT.len()).is_some_and(|start| start.eq_ignore_ascii_case(StoredFile::ROOT));
        if root { StoredFile::find(&self.machine.storage, &path) } else { None }
    }

    pub(super) fn file_text(&mut self, path: &str) -> Option<String> {
        if let Some(stored) = self.stored_file(path) {
            return Some(String::from_utf8_lossy(stored).into_owned());
        }
        let path = inside(path)?;
        let written = self.macros.as_deref().and_then(|runtime| runtime.files.get(&path).cloned());
        written.or_else(|| Some(String::from_utf8_lossy(&self.files.read(&path).ok()?).into_owned()))
    }

    pub(super) fn keep_file(&mut self, path: &str, text: &str) -> bool {
        let Some(path) = inside(path) else { return false };
        let Some(runtime) = self.macros.as_deref_mut() else { return false };
        let old = runtime.files.get(&path).map(String::len);
        let bytes = runtime.written - old.unwrap_or(0) + text.len();
        if bytes > MOST_BYTES || old.is_none() && runtime.files.len() >= MOST_FILES {
            let text = format!("macros may write {MOST_FILES} files with {MOST_BYTES} bytes in all, '{path}' is lost");
            self.diagnose(&diag::MACRO_FILES, text);
            return false;
        }
        runtime.written = bytes;
        runtime.files.insert(path, text.to_owned());
        true
    }

    /// `$FACCESS`: 4 may be read, 2 may be written; every bit asked for must be allowed.
    pub(super) fn file_access(&mut self, path: &str, wanted: u8) -> bool {
        let exists = self.file_status(path) == 0;
        // What is stored with the machine is never written.
        let writes = wanted & 2 != 0 && self.stored_file(path).is_some();
        exists && wanted & 1 == 0 && !writes
    }

    /// 0, or why there is no such file.
    pub(super) fn file_status(&mut self, path: &str) -> i32 {
        if self.stored_file(path).is_some() {
            return 0;
        }
        match inside(path) {
            None => FORBIDDEN,
            Some(inner) => {
                let written = self.macros.as_deref().is_some_and(|runtime| runtime.files.contains_key(&inner));
                if written || self.files.read(&inner).is_ok() { 0 } else { NOT_FOUND }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::inside;

    #[test]
    fn no_name_leads_out() {
        assert_eq!(inside("a/./b").as_deref(), Some("a/b"));
        assert_eq!(inside("a/../b").as_deref(), Some("b"));
        for path in ["..", "../x", "a/../../x", "/etc/x", "\\x", "c:/x", "", "a/../..\\x"] {
            assert_eq!(inside(path), None, "{path}");
        }
    }
}
