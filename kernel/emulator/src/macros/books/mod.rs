//! Records of a kernel for the tables that macros read: operations, times, travel.

pub(crate) mod operations;
pub(crate) mod sums;
pub(crate) mod travel;

use counterpoint_event::event::MAX_AXES;
use operations::Operations;
use sums::Sums;
use travel::Travel;

/// Operations, times and travel of a program.
#[derive(Debug, Default)]
pub(crate) struct Books {
    /// Operations of the program.
    pub(crate) operations: Operations,
    /// `$TLSUM`
    pub(crate) tool_sums: Sums,
    /// `$OPSUM`
    pub(crate) operation_sums: Sums,
    /// `$TLMIN`, `$TLMAX`
    pub(crate) tool_travel: Travel,
    /// `$OPMIN`, `$OPMAX`
    pub(crate) operation_travel: Travel,
    /// Column of each axis of the channel in those.
    pub(crate) columns: [Option<usize>; MAX_AXES],
    /// Sequence number of the last block that had one.
    pub(crate) last_sequence: u32,
}
