//! Operations: rows of `$OPTAB`, begun by tool changes and by assigning `$OPNAME`.
//!
//! Facts: reference system-variables.md 14. Decisions: the first assignment behind a tool change names the operation
//! that the change has begun, if that has no name yet; else it waits for the next change. Rows count from 2, row 1 is
//! no operation. Invariant: what a macro writes into the table stands before what is known here.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::Value;

use super::variables::names;
use crate::channel::Kernel;

/// Rows of the tables with the one that is no operation.
const MOST: usize = 999;

/// Characters of a name that a row keeps.
const LONGEST_NAME: usize = 200;

/// An operation.
#[derive(Debug)]
struct Operation {
    /// Row of its tool in the tool tables.
    tool: Value,
    name: String,
    /// Start, and end once another one has begun, in seconds.
    times: (f64, Option<f64>),
    /// First and last sequence number.
    blocks: (u32, u32),
    /// Highest severity of a diagnostic in it.
    severity: u8,
}

/// The operations of a kernel.
#[derive(Debug, Default)]
pub(crate) struct Operations {
    rows: Vec<Operation>,
    /// Name that waits for the next operation.
    name: String,
    /// Assignments of `$OPNAME` since the last tool change.
    assigned: u32,
    /// Row of the first operation of the loaded tool, 0 for none.
    first: usize,
    /// The table is full: nothing more is kept.
    full: bool,
}

impl Operations {
    /// Row of the current operation, 1 for none.
    pub(super) fn row(&self) -> usize {
        self.rows.len() + 1
    }

    /// Notes the severity of a diagnostic.
    pub(super) fn diagnosed(&mut self, severity: u8) {
        if let Some(row) = self.rows.last_mut().filter(|_| !self.full) {
            row.severity = row.severity.max(severity);
        }
    }
}

impl Kernel<'_> {
    /// A tool has been changed.
    pub(crate) fn operation_of_tool(&mut self) {
        let Some(runtime) = self.macros.as_deref_mut() else { return };
        let operations = &mut runtime.operations;
        operations.assigned = 0;
        operations.first = 0;
        let name = std::mem::take(&mut operations.name);
        self.begin_operation(name);
    }

    /// `$OPNAME` is assigned.
    pub(super) fn name_operation(&mut self, name: &str) {
        let Some(runtime) = self.macros.as_deref_mut() else { return };
        let name: String = name.chars().take(LONGEST_NAME).collect();
        let merge = runtime.store.get(names().operation_merge).as_logical() == Some(true);
        let operations = &mut runtime.operations;
        operations.assigned += 1;
        if operations.assigned > 1 && !merge {
            operations.name.clear();
            return self.begin_operation(name);
        }
        match operations.rows.last_mut().filter(|row| row.name.trim().is_empty()) {
            Some(row) => row.name = name,
            None => operations.name = name,
        }
    }

    fn begin_operation(&mut self, name: String) {
        let (clock, sequence) = (self.clock, self.block.sequence);
        let now = clock as f64 / 1e9;
        let Some(runtime) = self.macros.as_deref_mut() else { return };
        let tool = runtime.store.get(names().tool_row).clone();
        let last = runtime.last_sequence;
        let operations = &mut runtime.operations;
        if let Some(row) = operations.rows.last_mut().filter(|row| row.times.1.is_none()) {
            row.times.1 = Some(now);
            row.blocks.1 = last;
        }
        if operations.rows.len() + 1 >= MOST {
            operations.full = true;
            return;
        }
        let number = sequence.unwrap_or(last);
        operations.rows.push(Operation { tool, name, times: (now, None), blocks: (number, number), severity: 0 });
        runtime.operation_sums.switch(operations.row(), clock);
        if operations.first == 0 {
            operations.first = operations.row();
        }
    }

    /// `$OPTAB` as the kernel knows it.
    fn operation(&self, column: i64, row: i64) -> Option<Value> {
        let runtime = self.macros.as_deref()?;
        let at = usize::try_from(row).ok()?.checked_sub(2)?;
        let row = runtime.operations.rows.get(at)?;
        let ended = row.times.1.is_some();
        Some(match column {
            1 => row.tool.clone(),
            5 => Value::text(row.name.as_str()),
            6 => Value::Real(row.times.0),
            7 => Value::Real(row.times.1.unwrap_or(self.clock as f64 / 1e9)),
            8 => Value::Real(f64::from(row.blocks.0)),
            9 => Value::Real(f64::from(if ended { row.blocks.1 } else { runtime.last_sequence })),
            10 => Value::Real(f64::from(row.severity)),
            _ => return None,
        })
    }

    /// Reads `$OPTAB(column,row)`.
    pub(super) fn operation_value(&self, at: &[i64]) -> Value {
        let (column, row) = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
        let written = self.macros.as_deref().and_then(|r| r.store.element(names().operation_table, (column, row)));
        written.cloned().or_else(|| self.operation(column, row)).unwrap_or(Value::Null)
    }

    /// Writes it.
    pub(super) fn set_operation_value(&mut self, at: &[i64], value: &Value) -> Outcome<()> {
        let place = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
        match self.macros.as_deref_mut() {
            Some(runtime) => runtime.store.keep_element(names().operation_table, place, value.clone()),
            None => Ok(()),
        }
    }

    /// `$FOI`, 0 for none.
    pub(super) fn first_operation(&self) -> usize {
        self.macros.as_deref().map_or(0, |runtime| runtime.operations.first)
    }

    /// Sets it.
    pub(super) fn set_first_operation(&mut self, row: f64) {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.operations.first = row.clamp(0.0, MOST as f64) as usize;
        }
    }
}
