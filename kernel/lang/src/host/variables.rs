//! The host's variables.

use crate::fault::Outcome;
use crate::state::MemoryTally;
use crate::value::MacroValue;

/// Variables that macros share with the outside.
pub trait VariableHost {
    /// Reads a system variable.
    ///
    /// # Errors
    /// The variable is not available here, or an index is out of range.
    fn read_system(&mut self, index: u32, indices: &[i64]) -> Outcome<MacroValue>;

    /// Writes a system variable.
    ///
    /// # Errors
    /// The variable is not available here, or the value is out of its range.
    fn write_system(&mut self, index: u32, indices: &[i64], value: MacroValue) -> Outcome<()>;

    /// Lets `access` read a global variable (no `growth`), or change it; it grows by this many bytes at most.
    fn global(&mut self, index: u32, growth: Option<usize>, access: &mut dyn FnMut(&mut MacroValue));

    /// Adds the values of macros that the host keeps.
    fn held(&self, scale: &mut MemoryTally) {
        let _ = scale;
    }

    /// Place of a global variable that only this macro accesses while it runs; none if there may be other users, which
    /// are kept away by [`global`](Self::global). Between two calls of the host it is always the same place.
    fn own_global(&mut self, index: u32) -> Option<&mut MacroValue> {
        let _ = index;
        None
    }
}
