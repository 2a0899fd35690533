//! Records of a kernel for the tables that macros read: operations, travel.
//!
//! *Invariant:* the records change only by the methods of [`Books`].

pub mod operations;
pub mod travel;

use counterpoint_event::event::MAX_AXES;
use operations::Operations;
use travel::TravelTable;

/// Operations and travel of a program.
#[derive(Debug, Default)]
pub struct Books {
    /// Operations of the program.
    operations: Operations,
    /// `$TLMIN`, `$TLMAX`
    tool_travel: TravelTable,
    /// `$OPMIN`, `$OPMAX`
    operation_travel: TravelTable,
    /// Column of each axis of the channel in those.
    columns: [Option<usize>; MAX_AXES],
    /// Sequence number of the last block that had one.
    last_sequence: u32,
}

impl Books {
    /// Records the sequence number of a block.
    pub fn note_sequence(&mut self, number: u32) {
        self.last_sequence = number;
    }

    /// Removes all operations, because the program starts again.
    pub fn forget_operations(&mut self) {
        self.operations = Operations::default();
    }

    /// Notes the severity of a diagnostic in the current operation.
    pub fn diagnosed(&mut self, severity: u8) {
        self.operations.diagnosed(severity);
    }
}
