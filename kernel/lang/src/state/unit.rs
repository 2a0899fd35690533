//! Open units: text files as macros read and write them.

use super::MacroState;
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};

/// Bytes that a line takes besides its text.
pub(crate) const LINE: usize = 48;

/// An open unit.
#[derive(Debug, Default)]
pub(crate) struct OpenUnit {
    pub(crate) path: String,
    pub(crate) lines: Vec<String>,
    pub(crate) next: usize,
    /// Appends at the end.
    pub(crate) rear: bool,
    pub(crate) changed: bool,
    pub(crate) console: bool,
    /// Bytes written since it was opened.
    pub(crate) written: usize,
    /// Bytes read when the unit was opened.
    pub(crate) read: usize,
    /// Status of writing to it, found by the first WRITE.
    pub(crate) writable: Option<i32>,
}

impl OpenUnit {
    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.read + self.written + self.lines.len() * LINE
    }
}

/// The number of a unit.
pub(crate) fn unit_number(value: f64) -> Outcome<u8> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    if (20.0..30.0).contains(&value) {
        return Ok(value as u8);
    }
    Err(MacroFault::new(DiagnosticNumber::UNITS, format!("{value} is not a unit; units are 20 to 29")))
}

impl MacroState {
    /// End-of-file test of a unit.
    pub(crate) fn unit_at_end(&self, number: f64) -> Outcome<bool> {
        let number = unit_number(number)?;
        match self.units.get(&number) {
            Some(unit) => Ok(!unit.console && unit.next >= unit.lines.len()),
            None => Err(MacroFault::new(DiagnosticNumber::UNIT_NOT_OPEN, format!("the unit {number} is not open"))),
        }
    }
}
