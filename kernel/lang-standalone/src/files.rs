//! Files: in memory, or those of the outside.

use std::collections::BTreeMap;

use counterpoint_lang::host::{FileFacts, MacroFolder, NOT_FOUND, Shelf, stored};

use crate::outside::HostEnvironment;

/// Files in memory, the folder of the run and its current folder.
#[derive(Debug, Default)]
pub struct VirtualDisk {
    /// Files by name.
    pub files: BTreeMap<String, String>,
    folder: MacroFolder,
}

/// Where the files are.
struct FileBackend<'a> {
    files: &'a mut BTreeMap<String, String>,
    outside: Option<&'a mut Box<dyn HostEnvironment>>,
}

impl FileBackend<'_> {
    fn outside(&mut self, path: &str) -> Option<&mut Box<dyn HostEnvironment>> {
        if stored(path) { None } else { self.outside.as_deref_mut() }
    }

    fn text(&self, path: &str) -> Option<&str> {
        let exact = self.files.get(path);
        let same = || self.files.iter().find(|(name, _)| stored(path) && name.eq_ignore_ascii_case(path));
        exact.or_else(|| same().map(|(_, text)| text)).map(String::as_str)
    }
}

impl Shelf for FileBackend<'_> {
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

    fn facts(&mut self, path: &str) -> Result<FileFacts, i32> {
        if let Some(outside) = self.outside(path) {
            return outside.facts(path);
        }
        let folder = path == "." || self.files.keys().any(|name| name.starts_with(&format!("{path}/")));
        match self.text(path) {
            Some(text) => Ok(FileFacts::file(text.len(), stored(path))),
            None if folder => Ok(FileFacts::folder()),
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

impl VirtualDisk {
    /// Runs an operation on the folder of the run and its files.
    pub(crate) fn with<R>(
        &mut self,
        outside: Option<&mut Box<dyn HostEnvironment>>,
        work: impl FnOnce(&mut MacroFolder, &mut dyn Shelf) -> R,
    ) -> R {
        work(&mut self.folder, &mut FileBackend { files: &mut self.files, outside })
    }
}
