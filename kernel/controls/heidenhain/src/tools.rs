//! The tool table, as far as the program knows or changes it.
//!
//! Facts: programming manuals of the control (columns of ID50 by their numbers, pocket table ID51 and ID52). Length and
//! radius are those of the machine's tool offsets, which have the numbers of the tools; the other columns hold the
//! values that programs have written, 0 before. Decisions: tool n is in pocket n until a program changes that.
//! Invariant: a written length or radius acts from the next TOOL CALL on.

use rustc_hash::FxHashMap;

use super::words::EvaluatedWord;
use counterpoint_control_api::host::InterpreterHost;

/// Existing columns.
const COLUMNS: std::ops::RangeInclusive<u32> = 1..=48;

pub(super) const LENGTH: u32 = 1;
pub(super) const RADIUS: u32 = 2;
const MORE_LENGTH: u32 = 4;
const MORE_RADIUS: u32 = 5;
const TEETH: u32 = 15;

/// Lengths: L, R, R2, DL, DR, DR2, LCUTS, the tolerances and limits of measuring and the offsets for it.
const LENGTHS: [u32; 13] = [1, 2, 3, 4, 5, 6, 13, 16, 17, 19, 20, 21, 22];

/// Base of the rows of indexed tools: this plus ten times the tool number plus the index.
const INDEXED: u32 = 100_000;

/// The last row.
const LAST: u32 = INDEXED + 327_679;

/// Whether a tool has an index, as 5.1.
pub(super) fn is_indexed(tool: f64) -> bool {
    !((tool * 10.0).round() as u32).is_multiple_of(10)
}

/// The row of a tool.
pub(super) fn row(tool: f64) -> u32 {
    if is_indexed(tool) { INDEXED + (tool * 10.0).round() as u32 } else { tool as u32 }
}

/// Most values that programs write.
const MOST: usize = 10_000;

/// Data of tools from programs.
#[derive(Debug, Default)]
pub(super) struct ToolTableValues {
    /// By tool and column; lengths in units of the machine.
    table: FxHashMap<(u32, u32), f64>,
    /// Pocket table by pocket and column.
    pockets: FxHashMap<(u32, u32), f64>,
}

impl ToolTableValues {
    /// Bytes that they take, about.
    pub(super) fn bytes(&self) -> usize {
        (self.table.len() + self.pockets.len()) * 60
    }

    /// Teeth of a tool, 0 if no program has set them.
    pub(super) fn teeth(&self, tool: f64) -> f64 {
        self.table.get(&(row(tool), TEETH)).copied().unwrap_or(0.0)
    }

    /// A value of the tool table; none for a column or tool that does not exist.
    pub(super) fn column(&self, host: &dyn InterpreterHost, tool: u32, column: u32) -> Option<f64> {
        if tool > LAST || !COLUMNS.contains(&column) {
            return None;
        }
        let value = match column {
            LENGTH => host.tool_size(tool)[0],
            RADIUS => host.tool_size(tool)[1],
            _ => self.table.get(&(tool, column)).copied().unwrap_or(0.0),
        };
        Some(if LENGTHS.contains(&column) { value / host.length_factor() } else { value })
    }

    /// Writes a value of the tool table; whether there is such a place.
    pub(super) fn write_column(&mut self, host: &mut dyn InterpreterHost, tool: u32, column: u32, value: f64) -> bool {
        if !(1..=LAST).contains(&tool) || !COLUMNS.contains(&column) {
            return false;
        }
        let value = if LENGTHS.contains(&column) { value * host.length_factor() } else { value };
        if matches!(column, LENGTH | RADIUS) {
            return host.set_tool_size(tool, usize::from(column == RADIUS), value);
        }
        put(&mut self.table, (tool, column), value)
    }

    /// A value of the pocket table.
    pub(super) fn pocket(&self, pocket: u32, column: u32) -> Option<f64> {
        if !(1..=5).contains(&column) {
            return None;
        }
        let own = if column == 1 { f64::from(pocket) } else { 0.0 };
        Some(self.pockets.get(&(pocket, column)).copied().unwrap_or(own))
    }

    /// Writes a value of the pocket table; whether there is such a place.
    pub(super) fn write_pocket(&mut self, pocket: u32, column: u32, value: f64) -> bool {
        (1..=5).contains(&column) && pocket <= 32_767 && put(&mut self.pockets, (pocket, column), value)
    }

    /// The pocket of a tool, 0 for none.
    pub(super) fn pocket_of(&self, tool: u32) -> f64 {
        let written = self.pockets.iter().filter(|((_, column), value)| *column == 1 && **value == f64::from(tool));
        let moved = self.pockets.contains_key(&(tool, 1));
        let own = if moved { 0.0 } else { f64::from(tool) };
        written.map(|((pocket, _), _)| f64::from(*pocket)).min_by(f64::total_cmp).unwrap_or(own)
    }

    /// Adds the allowances of the tool table to those of a TOOL CALL.
    pub(super) fn add_allowances(&self, host: &dyn InterpreterHost, tool: f64, seen: &mut Vec<EvaluatedWord>) {
        for (column, name) in [(MORE_LENGTH, "DL"), (MORE_RADIUS, "DR")] {
            let more = self.column(host, row(tool), column).unwrap_or(0.0);
            if more == 0.0 {
                continue;
            }
            match seen.iter_mut().find(|word| word.is(name) && word.value.is_some()) {
                Some(word) => *word = EvaluatedWord::made(name, word.value.unwrap_or(0.0) + more),
                None => seen.push(EvaluatedWord::made(name, more)),
            }
        }
    }
}

fn put(table: &mut FxHashMap<(u32, u32), f64>, place: (u32, u32), value: f64) -> bool {
    let fits = table.len() < MOST || table.contains_key(&place);
    if fits {
        table.insert(place, value);
    }
    fits
}
