//! Tables of a composite machine: those of its components, one below the other.
//!
//! Invariant: every row names its component. The tables of the composite itself, which blocks never read, are not
//! shown; its macros are shown with `-` as their component.

use serde_json::{Value, json};

use super::grid::TextTable;
use crate::model::Machine;

/// The components with their definitions; a machine that is not a composite is its only component, without a name.
pub(super) fn of(machine: &Machine) -> Vec<(&str, &Machine)> {
    if machine.components.is_empty() {
        return vec![("", machine)];
    }
    machine.components.iter().map(|component| (component.designator.as_str(), &*component.machine)).collect()
}

/// Definitions with macros: the components, and the composite itself, whose macros run in kernel 0.
pub(super) fn with_macros(machine: &Machine) -> Vec<(&str, &Machine)> {
    let own = (!machine.components.is_empty() && machine.macros.is_some()).then_some(("-", machine));
    own.into_iter().chain(of(machine)).collect()
}

/// A table of several definitions.
pub(super) fn text(all: Vec<(&str, &Machine)>, part: fn(&Machine) -> TextTable) -> String {
    match all.as_slice() {
        [("", machine)] => part(machine).text(),
        _ => TextTable::below(all.into_iter().map(|(name, machine)| (name, part(machine))), "component").text(),
    }
}

/// Rows of several definitions as JSON, each with the name of its component.
pub(super) fn rows(all: Vec<(&str, &Machine)>, part: impl Fn(&Machine) -> Vec<Value>) -> Vec<Value> {
    let mut all_rows = Vec::new();
    for (designator, own) in all {
        let mut rows = part(own);
        for row in rows.iter_mut().filter_map(Value::as_object_mut).filter(|_| !designator.is_empty()) {
            row.insert("component".to_owned(), json!(designator));
        }
        all_rows.extend(rows);
    }
    all_rows
}
