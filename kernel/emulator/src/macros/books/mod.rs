//! Records of a kernel for the tables that macros read: operations, times, travel.
//!
//! *Invariant:* the records change only by the methods of [`Books`].

pub(crate) mod operations;
mod sums;
pub(crate) mod travel;

use counterpoint_event::event::MAX_AXES;
use operations::Operations;
use sums::Sums;
use travel::Travel;

/// Operations, times and travel of a program.
#[derive(Debug, Default)]
pub(crate) struct Books {
    /// Operations of the program.
    operations: Operations,
    /// `$TLSUM`
    tool_sums: Sums,
    /// `$OPSUM`
    operation_sums: Sums,
    /// `$TLMIN`, `$TLMAX`
    tool_travel: Travel,
    /// `$OPMIN`, `$OPMAX`
    operation_travel: Travel,
    /// Column of each axis of the channel in those.
    columns: [Option<usize>; MAX_AXES],
    /// Sequence number of the last block that had one.
    last_sequence: u32,
}

impl Books {
    /// The block has this sequence number.
    pub(crate) fn note_sequence(&mut self, number: u32) {
        self.last_sequence = number;
    }

    /// A tool is loaded at this clock: its row of the tool table counts from now on.
    pub(crate) fn switch_tool(&mut self, row: usize, clock: i64) {
        self.tool_sums.switch(row, clock);
    }

    /// The program starts again: it has no operations.
    pub(crate) fn forget_operations(&mut self) {
        self.operations = Operations::default();
    }

    /// Notes the severity of a diagnostic in the current operation.
    pub(crate) fn diagnosed(&mut self, severity: u8) {
        self.operations.diagnosed(severity);
    }
}
