//! Operations of a program: rows of `$OPTAB`.
//!
//! Rows count from 2, row 1 is not an operation. Facts: reference system-variables.md 14.

use counterpoint_lang::value::Value;

/// An operation.
#[derive(Debug)]
pub(crate) struct Operation {
    /// Row of its tool in the tool tables.
    pub(crate) tool: Value,
    pub(crate) name: String,
    /// Start, and end once another one has started, in seconds.
    pub(crate) times: (f64, Option<f64>),
    /// First and last sequence number.
    pub(crate) blocks: (u32, u32),
    /// Highest severity of a diagnostic in it.
    pub(crate) severity: u8,
    /// Head that was active when it began.
    pub(crate) head: Option<u8>,
    /// Numbers of the active length, diameter and fixture offsets when something moved.
    pub(crate) offsets: [Vec<u32>; 3],
}

/// The operations of a kernel.
#[derive(Debug, Default)]
pub(crate) struct Operations {
    pub(crate) rows: Vec<Operation>,
    /// Name that waits for the next operation.
    pub(crate) name: String,
    /// Assignments of `$OPNAME` since the last tool change.
    pub(crate) assigned: u32,
    /// Row of the first operation of the loaded tool, 0 for none.
    pub(crate) first: usize,
    /// The table is full: nothing more is kept.
    pub(crate) full: bool,
}

impl Operations {
    /// Row of the current operation, 1 for none.
    pub(crate) fn row(&self) -> usize {
        self.rows.len() + 1
    }

    /// Notes the severity of a diagnostic.
    pub(crate) fn diagnosed(&mut self, severity: u8) {
        if let Some(row) = self.rows.last_mut().filter(|_| !self.full) {
            row.severity = row.severity.max(severity);
        }
    }
}
