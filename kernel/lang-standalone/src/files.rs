//! Files: in memory, or those of the outside.

use std::collections::BTreeMap;

use counterpoint_lang::host::{Facts, Folder, NOT_FOUND, Shelf, stored};

use crate::outside::Outside;

/// Files in memory, the folder of the run and its current folder.
#[derive(Debug, Default)]
pub struct Disk {
    /// Files by name.
    pub files: BTreeMap<String, String>,
    folder: Folder,
}

/// Where the files are.
struct Storage<'a> {
    files: &'a mut BTreeMap<String, String>,
    outside: Option<&'a mut Box<dyn Outside>>,
}

impl Storage<'_> {
    fn outside(&mut self, path: &str) -> Option<&mut Box<dyn Outside>> {
        if stored(path) { None } else { self.outside.as_deref_mut() }
    }

    fn text(&self, path: &str) -> Option<&str> {
        let exact = self.files.get(path);
        let same = || self.files.iter().find(|(name, _)| stored(path) && name.eq_ignore_ascii_case(path));
        exact.or_else(|| same().map(|(_, text)| text)).map(String::as_str)
    }
}

impl Shelf for Storage<'_> {
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

impl Disk {
    /// Runs an operation on the folder of the run and its files.
    pub(crate) fn with<R>(
        &mut self,
        outside: Option<&mut Box<dyn Outside>>,
        work: impl FnOnce(&mut Folder, &mut dyn Shelf) -> R,
    ) -> R {
        work(&mut self.folder, &mut Storage { files: &mut self.files, outside })
    }
}
