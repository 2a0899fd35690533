//! Files of the double: in memory, or those of the outside.

use super::Test;
use super::outside::Outside;
use crate::host::folder::{Facts, Folder, NOT_FOUND, Shelf, stored};
use std::collections::BTreeMap;

/// Where they are.
struct Disk<'a> {
    files: &'a mut BTreeMap<String, String>,
    outside: Option<&'a mut Box<dyn Outside>>,
}

impl Disk<'_> {
    fn outside(&mut self, path: &str) -> Option<&mut Box<dyn Outside>> {
        if stored(path) { None } else { self.outside.as_deref_mut() }
    }

    fn text(&self, path: &str) -> Option<&str> {
        let exact = self.files.get(path);
        let same = || self.files.iter().find(|(name, _)| stored(path) && name.eq_ignore_ascii_case(path));
        exact.or_else(|| same().map(|(_, text)| text)).map(String::as_str)
    }
}

impl Shelf for Disk<'_> {
    fn read(&mut self, path: &str) -> Result<String, i32> {
        match self.outside(path) {
            Some(outside) => outside.read(path),
            None => self.text(path).map(str::to_owned).ok_or(NOT_FOUND),
        }
    }

    fn write(&mut self, path: &str, text: &str) -> Result<(), i32> {
        match self.outside(path) {
            Some(outside) => outside.write(path, text),
            None => {
                self.files.insert(path.to_owned(), text.to_owned());
                Ok(())
            }
        }
    }

    fn facts(&mut self, path: &str) -> Result<Facts, i32> {
        if let Some(outside) = self.outside(path) {
            return outside.facts(path);
        }
        let folder = path == "." || self.files.keys().any(|name| name.starts_with(&format!("{path}/")));
        match self.text(path) {
            Some(text) => Ok(Facts::file(text.len(), stored(path))),
            None if folder => Ok(Facts::folder()),
            None => Err(NOT_FOUND),
        }
    }

    fn creatable(&mut self, path: &str) -> bool {
        self.outside(path).is_none_or(|outside| outside.creatable(path))
    }

    fn remove(&mut self, path: &str) {
        match self.outside(path) {
            Some(outside) => outside.remove(path),
            None => {
                self.files.remove(path);
            }
        }
    }
}

impl Test {
    /// Does something with the folder of the run and its files.
    pub(super) fn with_files<R>(&mut self, work: impl FnOnce(&mut Folder, &mut dyn Shelf) -> R) -> R {
        let mut disk = Disk { files: &mut self.files, outside: self.outside.as_mut() };
        work(&mut self.folder, &mut disk)
    }

    /// Text of a file.
    pub(super) fn load(&mut self, path: &str) -> Result<String, i32> {
        self.with_files(|folder, shelf| folder.load(shelf, path))
    }

    /// Removes the temporary files of the run.
    pub fn clean(&mut self) {
        self.with_files(Folder::clean);
    }
}
