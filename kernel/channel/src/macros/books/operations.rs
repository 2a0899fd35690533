//! Operations: rows of `$OPTAB`, started by tool changes and by assigning `$OPNAME`.
//!
//! Facts: reference system-variables.md 14. Decisions: the first assignment after a tool change names the operation
//! that the change has started, if that has no name yet; otherwise it waits for the next change. Operations
//! have the rows from 2 on. *Invariant:* values that a macro writes into the table take precedence.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::MacroValue;

use super::Books;
use crate::channel_context::ChannelContext;
use crate::macros::store::{SystemVariableStore, names};
use crate::macros::tool_table::ToolTable;
use crate::modal::group;
use counterpoint_machine::ident::codes;

/// Rows of the tables with the one that is not an operation.
const MOST: usize = 999;

/// Numbers of offsets that a row keeps of a kind.
const MOST_OFFSETS: usize = 64;

/// Characters of a name that a row keeps.
const LONGEST_NAME: usize = 200;

/// An operation.
#[derive(Debug)]
pub struct MachiningOperation {
    /// Row of its tool in the tool tables.
    pub tool: MacroValue,
    /// Its name.
    pub name: String,
    /// Start, and end once another one has started, in seconds.
    pub times: (f64, Option<f64>),
    /// First and last sequence number.
    pub blocks: (u32, u32),
    /// Highest severity of a diagnostic in it.
    pub severity: u8,
    /// Head that was active when it began.
    pub head: Option<u8>,
    /// Numbers of the active length, diameter and fixture offsets when something moved.
    pub offsets: [Vec<u32>; 3],
}

/// The operations of a kernel.
#[derive(Debug, Default)]
pub struct Operations {
    rows: Vec<MachiningOperation>,
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
    pub fn row(&self) -> usize {
        self.rows.len() + 1
    }

    /// Notes the severity of a diagnostic.
    pub fn diagnosed(&mut self, severity: u8) {
        if let Some(row) = self.rows.last_mut().filter(|_| !self.full) {
            row.severity = row.severity.max(severity);
        }
    }
}

/// `$OPNAME` as diagnostics show it, empty without a name.
pub fn operation_name(store: &SystemVariableStore) -> String {
    let name = store.get(names().operation_name).as_text().unwrap_or("").trim();
    name.chars().take(LONGEST_NAME).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Writes `$OPTAB(column,row)`.
pub fn set_operation_value(store: &mut SystemVariableStore, at: &[i64], value: &MacroValue) -> Outcome<()> {
    store.keep_element(names().operation_table, place(at), value.clone())
}

fn place(at: &[i64]) -> (i64, i64) {
    (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0))
}

/// Number of the active diameter offset, 0 for none.
fn active_diameter(channel: &ChannelContext<'_>) -> u32 {
    let active = channel.state.modal.code(group::DIAMETER).is_some_and(|code| code != codes::COMP_DIAM_OFF);
    if active { channel.state.remembered.diameter() } else { 0 }
}

impl Books {
    /// Begins an operation after a tool change.
    pub fn begin_with_tool(&mut self, channel: &mut ChannelContext<'_>, store: &SystemVariableStore) {
        (self.operations.assigned, self.operations.first) = (0, 0);
        let name = std::mem::take(&mut self.operations.name);
        self.begin(channel, store, name);
    }

    /// Notes the active offsets while the axes of a motion move.
    pub(super) fn note_offsets(&mut self, channel: &ChannelContext<'_>, moving: u8) {
        if self.operations.rows.is_empty() || self.operations.full {
            return;
        }
        let (machine, layout) = (channel.env.machine, &channel.state.place.layout);
        let lathe = machine.tool.offset_digits > 0;
        let moves = |letter| layout.axis_of_letter(machine, letter).is_some_and(|axis| moving & axis.bit() != 0);
        // A lathe's tool word shifts X, Y and Z, a mill's length offset Z.
        let compensated = moves('Z') || lathe && (moves('X') || moves('Y'));
        let in_force = &channel.state.place.in_force;
        let length = if lathe { in_force.tool_offset } else { in_force.length_number };
        let numbers = [if compensated { length } else { 0 }, active_diameter(channel), in_force.work_offset];
        let Some(row) = self.operations.rows.last_mut() else { return };
        for (list, number) in row.offsets.iter_mut().zip(numbers) {
            if moving != 0 && number != 0 && list.len() < MOST_OFFSETS && !list.contains(&number) {
                list.push(number);
            }
        }
    }

    /// `$OPNAME` is assigned.
    pub fn name_operation(&mut self, channel: &mut ChannelContext<'_>, store: &SystemVariableStore, name: &str) {
        let name: String = name.chars().take(LONGEST_NAME).collect();
        let merge = store.get(names().operation_merge).as_logical() == Some(true);
        self.operations.assigned += 1;
        if self.operations.assigned > 1 && !merge {
            self.operations.name.clear();
            return self.begin(channel, store, name);
        }
        match self.operations.rows.last_mut().filter(|row| row.name.trim().is_empty()) {
            Some(row) => row.name = name,
            None => self.operations.name = name,
        }
    }

    fn begin(&mut self, channel: &mut ChannelContext<'_>, store: &SystemVariableStore, name: String) {
        let (clock, sequence, last) = (channel.now(), channel.block.sequence, self.last_sequence);
        let now = clock as f64 / 1e9;
        let head = match channel.state.modal.code(group::HEAD) {
            Some(codes::HEAD_MAIN) => Some(1),
            Some(codes::HEAD_SIDE) => Some(2),
            _ => None,
        };
        let operations = &mut self.operations;
        if let Some(row) = operations.rows.last_mut().filter(|row| row.times.1.is_none()) {
            row.times.1 = Some(now);
            row.blocks.1 = last;
        }
        if operations.rows.len() + 1 >= MOST {
            operations.full = true;
            return;
        }
        let (tool, number) = (store.get(names().tool_row).clone(), sequence.unwrap_or(last));
        let (times, blocks, offsets) = ((now, None), (number, number), [const { Vec::new() }; 3]);
        operations.rows.push(MachiningOperation { tool, name, times, blocks, severity: 0, head, offsets });
        channel.state.times.switch_operation(operations.row(), clock);
        if operations.first == 0 {
            operations.first = operations.row();
        }
    }

    /// `$OPTAB` as the kernel knows it at this clock, ns.
    fn operation(&self, tools: &ToolTable, clock: i64, (column, row): (i64, i64)) -> Option<MacroValue> {
        let at = usize::try_from(row).ok()?.checked_sub(2)?;
        let row = self.operations.rows.get(at)?;
        let ended = row.times.1.is_some();
        Some(match column {
            1 => row.tool.as_real().map_or(MacroValue::Null, |row| MacroValue::Real(tools.seen_row(row))),
            2 => MacroValue::Real(f64::from(row.head?)),
            5 => MacroValue::text(row.name.as_str()),
            6 => MacroValue::Real(row.times.0),
            7 => MacroValue::Real(row.times.1.unwrap_or(clock as f64 / 1e9)),
            8 => MacroValue::Real(f64::from(row.blocks.0)),
            9 => MacroValue::Real(f64::from(if ended { row.blocks.1 } else { self.last_sequence })),
            10 => MacroValue::Real(f64::from(row.severity)),
            11..=13 => {
                let numbers = row.offsets.get(usize::try_from(column - 11).ok()?)?;
                MacroValue::sequence(numbers.iter().map(|number| MacroValue::Real(f64::from(*number))).collect())
            }
            _ => return None,
        })
    }

    /// `$OPTAB(column,row)` at this clock, ns; a value that a macro has written takes precedence.
    pub fn operation_value(
        &self,
        tools: &ToolTable,
        store: &SystemVariableStore,
        clock: i64,
        at: &[i64],
    ) -> MacroValue {
        let written = store.element(names().operation_table, place(at));
        written.cloned().or_else(|| self.operation(tools, clock, place(at))).unwrap_or(MacroValue::Null)
    }

    /// Row of the current operation, 1 for none.
    pub fn operation_row(&self) -> usize {
        self.operations.row()
    }

    /// `$FOI`, 0 for none.
    pub fn first_operation(&self) -> usize {
        self.operations.first
    }

    /// Sets it.
    pub fn set_first_operation(&mut self, row: f64) {
        self.operations.first = row.clamp(0.0, MOST as f64) as usize;
    }
}
