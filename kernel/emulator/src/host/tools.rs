//! The tool table as macros see it: `$TLTAB`, `$TLSORT`, `$TI`.
//!
//! Facts: reference system-variables.md 13. Invariants: rows are kept in the order of the first loads, row 1 is not a
//! tool; only the view of macros is in the order of `$TLSORT`. Decisions: the rows are sorted when `$TLSORT` is
//! assigned and when a tool is loaded; numbers come before texts, rows without a value last, equal rows by their loads.

use std::cmp::Ordering;

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::Value;

use crate::channel::Kernel;
use crate::macros::store::{column, names};
use counterpoint_machine::model::ToolFacts;

/// The machine's data of a loaded tool, by column.
fn known(tool: u32, facts: Option<&ToolFacts>) -> [(i64, Option<Value>); 6] {
    let number = |value: Option<f64>| value.map(Value::Real);
    [
        (column::NUMBER, Some(Value::Real(f64::from(tool)))),
        (column::ID, Some(Value::Real(f64::from(tool)))),
        (column::OFFSET, facts.and_then(|facts| facts.offset).map(|offset| Value::Real(f64::from(offset)))),
        (column::LENGTH, number(facts.and_then(|facts| facts.length))),
        (column::DIAMETER, number(facts.and_then(|facts| facts.diameter))),
        (column::NAME, facts.filter(|facts| !facts.name.is_empty()).map(|facts| Value::text(facts.name.as_str()))),
    ]
}

fn rank(value: Option<&Value>) -> u8 {
    match value {
        Some(Value::Real(_)) => 0,
        Some(Value::Text(text)) if !text.trim().is_empty() => 1,
        _ => 2,
    }
}

fn compare(a: Option<&Value>, b: Option<&Value>) -> Ordering {
    rank(a).cmp(&rank(b)).then_with(|| match (a, b) {
        (Some(Value::Real(a)), Some(Value::Real(b))) => a.total_cmp(b),
        (Some(Value::Text(a)), Some(Value::Text(b))) => a.as_str().cmp(b.as_str()),
        _ => Ordering::Equal,
    })
}

impl Kernel<'_> {
    /// A cell of the row of a loaded tool, if it has a value.
    pub(crate) fn tool_cell(&self, tool: u32, column: i64) -> Option<&Value> {
        let runtime = &*self.macros;
        let at = runtime.tools.loaded.iter().position(|known| *known == tool)?;
        runtime.variables.store.element(names().tool_table, (column, at as i64 + 2))
    }

    /// Fills the new row of a loaded tool with the machine's data; values that macros have written there stay.
    pub(crate) fn fill_tool_row(&mut self, tool: u32, row: i64) {
        let facts = self.channel.env.machine.tool.facts(tool);
        let runtime = &mut *self.macros;
        for (column, value) in known(tool, facts) {
            let Some(value) = value else { continue };
            let (table, place) = (names().tool_table, (column, row));
            if column == column::NUMBER || runtime.variables.store.element(table, place).is_none() {
                runtime.variables.store.set_element(table, place, value);
            }
        }
    }

    /// `$TLSORT` as a column: 0 for none, negative for the listing only.
    pub(crate) fn tool_sort(&self) -> i64 {
        if self.plan.hooks.is_none() {
            return 0;
        }
        let value = self.macros.variables.store.get(names().tool_sort).as_real();
        value.map_or(0, |column| column as i64)
    }

    /// Tools by the values of a column: places among the first loads.
    pub(crate) fn sorted_tools(&self, column: i64) -> Vec<u16> {
        let runtime = &*self.macros;
        let mut order: Vec<u16> = (0..).take(runtime.tools.loaded.len()).collect();
        let cell = |at: u16| runtime.variables.store.element(names().tool_table, (column, i64::from(at) + 2));
        order.sort_by(|a, b| compare(cell(*a), cell(*b)));
        order
    }

    /// Puts the rows that macros see in order.
    pub(crate) fn sort_tools(&mut self) {
        let column = self.tool_sort();
        let order = if column > 0 { self.sorted_tools(column) } else { Vec::new() };
        self.macros.tools.order = order;
    }

    /// The row that is kept, of one that macros name.
    pub(crate) fn kept_tool_row(&self, row: i64) -> i64 {
        let order = &self.macros.tools.order;
        let at = usize::try_from(row).ok().and_then(|row| row.checked_sub(2)).and_then(|at| order.get(at));
        at.map_or(row, |at| i64::from(*at) + 2)
    }

    /// The row that macros see, of one that is kept.
    pub(crate) fn seen_tool_row(&self, row: f64) -> f64 {
        let order = &self.macros.tools.order;
        order.iter().position(|at| f64::from(*at) + 2.0 == row).map_or(row, |at| at as f64 + 2.0)
    }

    fn tool_place(&self, at: &[i64]) -> (i64, i64) {
        (at.first().copied().unwrap_or(0), self.kept_tool_row(at.get(1).copied().unwrap_or(0)))
    }

    /// `$TLTAB(column,row)`
    pub(crate) fn tool_table_value(&self, at: &[i64]) -> Value {
        let place = self.tool_place(at);
        let kept = self.macros.variables.store.element(names().tool_table, place);
        kept.cloned().unwrap_or(Value::Null)
    }

    /// Writes it.
    pub(crate) fn set_tool_table_value(&mut self, at: &[i64], value: &Value) -> Outcome<()> {
        let place = self.tool_place(at);
        let runtime = &mut *self.macros;
        runtime.tools.changed |= matches!(place.0, column::LENGTH | column::DIAMETER | column::NAME);
        runtime.variables.store.keep_element(names().tool_table, place, value.clone())
    }

    /// `$TLSORT` is assigned.
    pub(crate) fn set_tool_sort(&mut self, value: &Value) {
        let value = value.clone();
        self.store(names().tool_sort, || value);
        self.sort_tools();
    }
}
