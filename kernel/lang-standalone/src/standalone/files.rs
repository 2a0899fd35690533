//! Files of macros.

use counterpoint_lang::host::{FileHost, MacroFolder, Shelf};
use counterpoint_lang::state::MacroState;

use super::Standalone;

impl Standalone {
    /// Runs an operation on the folder of the run and its files.
    pub(super) fn with_files<R>(&mut self, work: impl FnOnce(&mut MacroFolder, &mut dyn Shelf) -> R) -> R {
        self.disk.with(self.outside.as_mut(), work)
    }

    /// Text of a file.
    pub(super) fn load(&mut self, path: &str) -> Result<String, i32> {
        self.with_files(|folder, shelf| folder.load(shelf, path))
    }

    /// Removes the temporary files of the run.
    pub fn clean(&mut self) {
        self.with_files(MacroFolder::clean);
    }
}

impl FileHost for Standalone {
    fn may_open(&mut self, state: &mut MacroState, path: &str) -> i32 {
        self.with_files(|folder, shelf| folder.openable(shelf, state, path))
    }

    fn may_write(&mut self, path: &str) -> i32 {
        self.with_files(|folder, shelf| folder.writable(shelf, path))
    }

    fn read_file(&mut self, path: &str) -> Option<String> {
        self.load(path).ok()
    }

    fn write_file(&mut self, path: &str, text: &str) -> bool {
        self.with_files(|folder, shelf| folder.save(shelf, path, text)).is_ok()
    }
}
