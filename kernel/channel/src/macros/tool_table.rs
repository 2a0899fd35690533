//! The tool table as macros see it: `$TLTAB`, `$TLSORT`, `$TI`.
//!
//! Facts: reference system-variables.md 13. Invariants: rows are kept in the order of the first loads, row 1 is not a
//! tool; only the view of macros is in the order of `$TLSORT`. Decisions: the rows are sorted when `$TLSORT` is
//! assigned and when a tool is loaded; numbers come before texts, rows without a value last, equal rows by their loads.

use std::cmp::Ordering;

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::MacroValue;

use super::store::{SystemVariableStore, column, names};
use counterpoint_machine::model::ToolFacts;

/// The machine's data of a loaded tool, by column.
fn known(tool: u32, facts: Option<&ToolFacts>) -> [(i64, Option<MacroValue>); 6] {
    let number = |value: Option<f64>| value.map(MacroValue::Real);
    [
        (column::NUMBER, Some(MacroValue::Real(f64::from(tool)))),
        (column::ID, Some(MacroValue::Real(f64::from(tool)))),
        (column::OFFSET, facts.and_then(|facts| facts.offset).map(|offset| MacroValue::Real(f64::from(offset)))),
        (column::LENGTH, number(facts.and_then(|facts| facts.length))),
        (column::DIAMETER, number(facts.and_then(|facts| facts.diameter))),
        (column::NAME, facts.filter(|facts| !facts.name.is_empty()).map(|facts| MacroValue::text(facts.name.as_str()))),
    ]
}

fn rank(value: Option<&MacroValue>) -> u8 {
    match value {
        Some(MacroValue::Real(_)) => 0,
        Some(MacroValue::Text(text)) if !text.trim().is_empty() => 1,
        _ => 2,
    }
}

fn compare(a: Option<&MacroValue>, b: Option<&MacroValue>) -> Ordering {
    rank(a).cmp(&rank(b)).then_with(|| match (a, b) {
        (Some(MacroValue::Real(a)), Some(MacroValue::Real(b))) => a.total_cmp(b),
        (Some(MacroValue::Text(a)), Some(MacroValue::Text(b))) => a.as_str().cmp(b.as_str()),
        _ => Ordering::Equal,
    })
}

/// Rows of the tool table with the dummy tool (reference system-variables.md 13).
pub const MOST_TOOLS: usize = 200;

/// The tools in the rows of the tool table, and the order of the rows.
#[derive(Debug, Default)]
pub struct ToolTable {
    /// Tools loaded so far; the first row of the tool table is the dummy tool.
    loaded: Vec<u32>,
    /// The rows of the tool tables as macros see them, by place in `loaded`; empty while that is their order.
    order: Vec<u16>,
    /// Macros have written facts of a tool that are not reported yet.
    changed: bool,
}

impl ToolTable {
    /// Tools loaded so far.
    pub fn loaded(&self) -> &[u32] {
        &self.loaded
    }

    /// Forgets the loaded tools.
    pub fn clear(&mut self) {
        self.loaded.clear();
    }

    /// Whether macros have written facts of a tool since the last call.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// A cell of the row of a loaded tool, if it has a value.
    pub fn cell<'s>(&self, store: &'s SystemVariableStore, tool: u32, column: i64) -> Option<&'s MacroValue> {
        let at = self.loaded.iter().position(|known| *known == tool)?;
        store.element(names().tool_table, (column, at as i64 + 2))
    }

    /// The row of a tool. A new row gets the machine's data; values that macros have written there are kept. None if
    /// the table is full.
    pub fn load(&mut self, store: &mut SystemVariableStore, tool: u32, facts: Option<&ToolFacts>) -> Option<usize> {
        if let Some(at) = self.loaded.iter().position(|known| *known == tool) {
            return Some(at + 2);
        }
        let row = self.loaded.len() + 2;
        if row > MOST_TOOLS {
            return None;
        }
        self.loaded.push(tool);
        for (column, value) in known(tool, facts) {
            let Some(value) = value else { continue };
            let (table, place) = (names().tool_table, (column, row as i64));
            if column == column::NUMBER || store.element(table, place).is_none() {
                store.set_element(table, place, value);
            }
        }
        Some(row)
    }

    /// Tools by the values of a column: places among the first loads.
    pub fn sorted(&self, store: &SystemVariableStore, column: i64) -> Vec<u16> {
        let mut order: Vec<u16> = (0..).take(self.loaded.len()).collect();
        let cell = |at: u16| store.element(names().tool_table, (column, i64::from(at) + 2));
        order.sort_by(|a, b| compare(cell(*a), cell(*b)));
        order
    }

    /// Puts the rows that macros see in the order of `$TLSORT`.
    pub fn sort(&mut self, store: &SystemVariableStore) {
        let column = sort_column(store);
        self.order = if column > 0 { self.sorted(store, column) } else { Vec::new() };
    }

    /// The row that is kept, of one that macros name.
    pub fn kept_row(&self, row: i64) -> i64 {
        let at = usize::try_from(row).ok().and_then(|row| row.checked_sub(2)).and_then(|at| self.order.get(at));
        at.map_or(row, |at| i64::from(*at) + 2)
    }

    /// The row that macros see, of one that is kept.
    pub fn seen_row(&self, row: f64) -> f64 {
        self.order.iter().position(|at| f64::from(*at) + 2.0 == row).map_or(row, |at| at as f64 + 2.0)
    }

    fn place(&self, at: &[i64]) -> (i64, i64) {
        (at.first().copied().unwrap_or(0), self.kept_row(at.get(1).copied().unwrap_or(0)))
    }

    /// `$TLTAB(column,row)`
    pub fn value(&self, store: &SystemVariableStore, at: &[i64]) -> MacroValue {
        store.element(names().tool_table, self.place(at)).cloned().unwrap_or(MacroValue::Null)
    }

    /// Writes it.
    pub fn set_value(&mut self, store: &mut SystemVariableStore, at: &[i64], value: &MacroValue) -> Outcome<()> {
        let place = self.place(at);
        self.changed |= matches!(place.0, column::LENGTH | column::DIAMETER | column::NAME);
        store.keep_element(names().tool_table, place, value.clone())
    }
}

/// `$TLSORT` as a column: 0 for none, negative for the listing only.
pub fn sort_column(store: &SystemVariableStore) -> i64 {
    store.get(names().tool_sort).as_real().map_or(0, |column| column as i64)
}
