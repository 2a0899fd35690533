//! Files that macros open by unit number.

use crate::state::MacroState;

/// The host's files.
pub trait FileHost {
    /// Tells whether a macro may open a file of this name: 0, otherwise the status for `$ERRNO`.
    fn may_open(&mut self, state: &mut MacroState, path: &str) -> i32 {
        let _ = (state, path);
        0
    }

    /// Tells whether a file of this name could be written: 0, otherwise the status for `$ERRNO`.
    fn may_write(&mut self, path: &str) -> i32 {
        let _ = path;
        0
    }

    /// Text of a file, none if it cannot be read.
    fn read_file(&mut self, path: &str) -> Option<String>;

    /// Replaces a file; false if it cannot be written.
    fn write_file(&mut self, path: &str, text: &str) -> bool;
}
