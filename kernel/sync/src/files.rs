//! Files that macros and printing statements of a job write.
//!
//! They belong to all kernels and are reached in the order of simulated time, like any shared operation. Invariant: the
//! amount of written text is bounded; text written after the stop of a job is not in it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::sink::WrittenFiles;
use crate::tag::Tag;

/// Files that macros may write.
const MOST_FILES: usize = 200;

/// Bytes in all of them.
const MOST_BYTES: usize = 64 << 20;

/// The files by path; one without a text has been removed.
#[derive(Debug, Clone, Default)]
pub struct SharedFiles {
    files: BTreeMap<String, Option<Arc<str>>>,
    bytes: usize,
    /// Files that printing statements of programs write line by line, by path.
    printed: BTreeMap<String, String>,
    /// Texts of units that were open when their kernel came to its end; without a text: a temporary file.
    left: Vec<(Tag, String, Option<String>)>,
}

impl SharedFiles {
    /// Text of a file; `Some(None)`: it has been removed.
    pub fn get(&self, path: &str) -> Option<Option<Arc<str>>> {
        if let Some(text) = self.printed.get(path) {
            return Some(Some(text.as_str().into()));
        }
        self.files.get(path).cloned()
    }

    /// Whether there is such a file; `Some(false)`: it has been removed.
    pub fn has(&self, path: &str) -> Option<bool> {
        if self.printed.contains_key(path) { Some(true) } else { self.files.get(path).map(Option::is_some) }
    }

    /// All files; one without a text has been removed.
    pub fn all(&self) -> BTreeMap<String, Option<Arc<str>>> {
        let printed = self.printed.iter().map(|(path, text)| (path.clone(), Some(text.as_str().into())));
        self.files.clone().into_iter().chain(printed).collect()
    }

    /// Whether a file lies in this folder.
    pub fn has_folder(&self, folder: &str) -> bool {
        let inside = |path: &str| path.strip_prefix(folder).is_some_and(|rest| rest.starts_with('/'));
        self.files.iter().any(|(path, text)| text.is_some() && inside(path))
    }

    /// Replaces a file.
    ///
    /// # Errors
    /// The exceeded resource.
    pub fn put(&mut self, path: &str, text: &str) -> Result<(), String> {
        let printed = self.printed.remove(path).map(|text| Some(Arc::from(text)));
        self.files.extend(printed.map(|text| (path.to_owned(), text)));
        let old = self.files.get(path).and_then(Option::as_deref).map_or(0, str::len);
        let bytes = self.bytes - old + text.len();
        if bytes > MOST_BYTES || !self.files.contains_key(path) && self.files.len() >= MOST_FILES {
            return Err(format!(
                "macros may write {MOST_FILES} files with {MOST_BYTES} bytes in all, '{path}' is lost"
            ));
        }
        self.bytes = bytes;
        self.files.insert(path.to_owned(), Some(text.into()));
        Ok(())
    }

    /// Adds to a file of printing statements.
    ///
    /// # Errors
    /// The exceeded resource.
    pub fn print(&mut self, path: &str, text: &str) -> Result<(), String> {
        if !self.printed.contains_key(path) {
            if self.files.len() + self.printed.len() >= MOST_FILES {
                return Err(format!("programs and macros may write {MOST_FILES} files, '{path}' is lost"));
            }
            // A file of that name that macros have written is continued.
            let before = self.get(path).flatten().map_or_else(String::new, |text| (*text).to_owned());
            self.files.remove(path);
            self.printed.insert(path.to_owned(), before);
        }
        if self.bytes + text.len() > MOST_BYTES {
            return Err(format!("programs and macros may write {MOST_BYTES} bytes in all, more for '{path}' is lost"));
        }
        self.bytes += text.len();
        if let Some(file) = self.printed.get_mut(path) {
            file.push_str(text);
        }
        Ok(())
    }

    /// Bytes of all texts.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Removes a file.
    pub fn remove(&mut self, path: &str) {
        let printed = self.printed.remove(path).map_or(0, |text| text.len());
        let old = self.files.insert(path.to_owned(), None).flatten();
        self.bytes -= old.map_or(0, |text| text.len()) + printed;
    }

    /// Files that a kernel had open at its end, or temporary files to remove then.
    pub fn leave(&mut self, tag: Tag, path: &str, text: Option<&str>) {
        self.left.push((tag, path.to_owned(), text.map(str::to_owned)));
    }

    /// Called when all kernels have ended: writes their open files in the order of their ends, up to the stop of the
    /// job; temporary files are removed.
    pub fn close(&mut self, stop: Tag) {
        let mut left = std::mem::take(&mut self.left);
        left.sort_by_key(|(tag, ..)| *tag);
        for (tag, path, text) in left {
            match text {
                Some(text) if tag <= stop => {
                    let _ = self.put(&path, &text);
                }
                Some(_) => {}
                None => self.remove(&path),
            }
        }
    }

    /// The files with their texts, by path.
    pub fn take(&mut self) -> WrittenFiles {
        let mut files = std::mem::take(&mut self.files);
        let printed = std::mem::take(&mut self.printed);
        files.extend(printed.into_iter().map(|(path, text)| (path, Some(Arc::from(text)))));
        files.into_iter().filter_map(|(path, text)| Some((path, text?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn how_much_may_be_written_is_bounded() {
        let mut written = SharedFiles::default();
        let big = "x".repeat(MOST_BYTES / 2);
        assert_eq!(written.put("a", &big), Ok(()));
        assert_eq!(written.put("a", &big), Ok(()), "in its own place");
        assert_eq!(written.put("b", &big), Ok(()));
        assert!(written.put("c", "x").is_err());
        written.remove("b");
        assert_eq!(written.put("c", "x"), Ok(()));
        assert_eq!(written.get("b"), Some(None));
        assert_eq!(written.take().iter().map(|(path, _)| path.as_str()).collect::<Vec<_>>(), ["a", "c"]);
        let mut printed = SharedFiles::default();
        for text in ["a", "b", "c"] {
            assert_eq!(printed.print("p", text), Ok(()));
        }
        assert_eq!(printed.get("p"), Some(Some("abc".into())));
        assert!(printed.print("p", &"x".repeat(MOST_BYTES)).is_err());
        assert_eq!(printed.put("p", "new"), Ok(()));
        assert_eq!(printed.print("p", "er"), Ok(()));
        assert_eq!(printed.take(), [("p".to_owned(), Arc::from("newer"))]);
        let mut many = SharedFiles::default();
        for number in 0..MOST_FILES {
            assert_eq!(many.put(&number.to_string(), ""), Ok(()));
        }
        assert!(many.put("one more", "").is_err());
        assert!(many.print("one more", "").is_err());
        assert_eq!([many.has("0"), many.has("one more")], [Some(true), None]);
        many.remove("0");
        assert_eq!(many.has("0"), Some(false));
    }

    #[test]
    fn what_was_open_is_written_up_to_the_stop() {
        let tag = |t, channel| Tag { t, micro: 0, channel };
        let mut written = SharedFiles::default();
        assert_eq!(written.put("t", "temporary"), Ok(()));
        for (at, text) in [(tag(5, 2), "late"), (tag(3, 2), "second"), (tag(3, 1), "first")] {
            written.leave(at, "a", Some(text));
        }
        written.leave(tag(5, 2), "t", None);
        written.close(tag(4, 1));
        assert_eq!(written.take(), [("a".to_owned(), Arc::from("second"))]);
    }
}
