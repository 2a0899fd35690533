//! Operations: rows of `$OPTAB`, started by tool changes and by assigning `$OPNAME`.
//!
//! Facts: reference system-variables.md 14. Decisions: the first assignment after a tool change names the operation
//! that the change has started, if that has no name yet; otherwise it waits for the next change. Rows count from 2, row
//! 1 is no operation. *Invariant:* values that a macro writes into the table take precedence.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::Value;

use crate::channel::Kernel;
use crate::host::variables::positions;
use crate::macros::books::operations::Operation;
use crate::macros::store::names;
use crate::state::modal::group;
use counterpoint_machine::ident::codes;

/// Rows of the tables with the one that is not an operation.
const MOST: usize = 999;

/// Numbers of offsets that a row keeps of a kind.
const MOST_OFFSETS: usize = 64;

/// Characters of a name that a row keeps.
const LONGEST_NAME: usize = 200;

impl Kernel<'_> {
    /// A tool has been changed.
    pub(crate) fn operation_of_tool(&mut self) {
        let runtime = &mut *self.macros;
        let operations = &mut runtime.books.operations;
        operations.assigned = 0;
        operations.first = 0;
        let name = std::mem::take(&mut operations.name);
        self.begin_operation(name);
    }

    /// `$OPNAME` as diagnostics show it, empty without a name.
    pub(crate) fn operation_name(&self) -> String {
        let runtime = &*self.macros;
        let name = runtime.variables.store.get(names().operation_name).as_text().unwrap_or("").trim();
        name.chars().take(LONGEST_NAME).map(|c| if c.is_control() { ' ' } else { c }).collect()
    }

    /// Number of the active diameter offset, 0 for none.
    fn diameter_number(&self) -> u32 {
        let active = self.channel.state.modal.code(group::DIAMETER).is_some_and(|code| code != codes::COMP_DIAM_OFF);
        if active { self.channel.state.remembered.diameter() } else { 0 }
    }

    /// Notes the active offsets while the axes of a motion move.
    pub(crate) fn note_offsets(&mut self, moving: u8) {
        if self.macros.books.operations.rows.is_empty() || self.macros.books.operations.full {
            return;
        }
        let lathe = self.channel.env.machine.tool.offset_digits > 0;
        let moves =
            |letter: char| positions::axis_of(&self.channel, letter).is_some_and(|axis| moving & axis.bit() != 0);
        // A lathe's tool word shifts X, Y and Z, a mill's length offset Z.
        let compensated = moves('Z') || lathe && (moves('X') || moves('Y'));
        let length = if lathe {
            self.channel.state.place.in_force.tool_offset
        } else {
            self.channel.state.place.in_force.length_number
        };
        let numbers = [
            if compensated { length } else { 0 },
            self.diameter_number(),
            self.channel.state.place.in_force.work_offset,
        ];
        let operations = &mut self.macros.books.operations;
        let Some(row) = operations.rows.last_mut() else { return };
        for (list, number) in row.offsets.iter_mut().zip(numbers) {
            if moving != 0 && number != 0 && list.len() < MOST_OFFSETS && !list.contains(&number) {
                list.push(number);
            }
        }
    }

    /// `$OPNAME` is assigned.
    pub(crate) fn name_operation(&mut self, name: &str) {
        let runtime = &mut *self.macros;
        let name: String = name.chars().take(LONGEST_NAME).collect();
        let merge = runtime.variables.store.get(names().operation_merge).as_logical() == Some(true);
        let operations = &mut runtime.books.operations;
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
        let (clock, sequence) = (self.channel.now(), self.channel.block.sequence);
        let now = clock as f64 / 1e9;
        let runtime = &mut *self.macros;
        let tool = runtime.variables.store.get(names().tool_row).clone();
        let last = runtime.books.last_sequence;
        let head = match self.channel.state.modal.code(group::HEAD) {
            Some(codes::HEAD_MAIN) => Some(1),
            Some(codes::HEAD_SIDE) => Some(2),
            _ => None,
        };
        let operations = &mut runtime.books.operations;
        if let Some(row) = operations.rows.last_mut().filter(|row| row.times.1.is_none()) {
            row.times.1 = Some(now);
            row.blocks.1 = last;
        }
        if operations.rows.len() + 1 >= MOST {
            operations.full = true;
            return;
        }
        let number = sequence.unwrap_or(last);
        let (times, blocks, offsets) = ((now, None), (number, number), [const { Vec::new() }; 3]);
        operations.rows.push(Operation { tool, name, times, blocks, severity: 0, head, offsets });
        runtime.books.operation_sums.switch(operations.row(), clock);
        if operations.first == 0 {
            operations.first = operations.row();
        }
    }

    /// `$OPTAB` as the kernel knows it.
    fn operation(&self, column: i64, row: i64) -> Option<Value> {
        let runtime = &*self.macros;
        let at = usize::try_from(row).ok()?.checked_sub(2)?;
        let row = runtime.books.operations.rows.get(at)?;
        let ended = row.times.1.is_some();
        Some(match column {
            1 => row.tool.as_real().map_or(Value::Null, |row| Value::Real(self.seen_tool_row(row))),
            2 => Value::Real(f64::from(row.head?)),
            5 => Value::text(row.name.as_str()),
            6 => Value::Real(row.times.0),
            7 => Value::Real(row.times.1.unwrap_or(self.channel.now() as f64 / 1e9)),
            8 => Value::Real(f64::from(row.blocks.0)),
            9 => Value::Real(f64::from(if ended { row.blocks.1 } else { runtime.books.last_sequence })),
            10 => Value::Real(f64::from(row.severity)),
            11..=13 => {
                let numbers = row.offsets.get(usize::try_from(column - 11).ok()?)?;
                Value::sequence(numbers.iter().map(|number| Value::Real(f64::from(*number))).collect())
            }
            _ => return None,
        })
    }

    /// Reads `$OPTAB(column,row)`.
    pub(crate) fn operation_value(&self, at: &[i64]) -> Value {
        let (column, row) = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
        let written = self.macros.variables.store.element(names().operation_table, (column, row));
        written.cloned().or_else(|| self.operation(column, row)).unwrap_or(Value::Null)
    }

    /// Writes it.
    pub(crate) fn set_operation_value(&mut self, at: &[i64], value: &Value) -> Outcome<()> {
        let place = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
        self.macros.variables.store.keep_element(names().operation_table, place, value.clone())
    }

    /// `$FOI`, 0 for none.
    pub(crate) fn first_operation(&self) -> usize {
        self.macros.books.operations.first
    }

    /// Sets it.
    pub(crate) fn set_first_operation(&mut self, row: f64) {
        self.macros.books.operations.first = row.clamp(0.0, MOST as f64) as usize;
    }
}
