//! `initial`: the codes that are active at program start.
//!
//! Invariant: each is modal, and no two are of one group. Facts: reference control-emulator.md 3.1.

use super::names::NameRegistry;
use crate::ident::{self, CodeId};
use crate::rows::CodeRow;
use crate::toml::section::TableReader;

/// Reads the list.
pub(super) fn read(top: &mut TableReader<'_>, names: &NameRegistry<'_>, rows: &[CodeRow]) -> Vec<CodeId> {
    let mut initial: Vec<(CodeId, u16, &str)> = Vec::new();
    for (name, place) in top.texts("initial").unwrap_or_default() {
        let Some(id) = names.code(name, place) else { continue };
        let of_row = rows.iter().find(|row| row.id == id).map(|row| row.group);
        let group = of_row.unwrap_or_else(|| ident::code_facts(id).map_or(0, |facts| facts.group));
        if group == 0 {
            names.check.error(place, format!("{name} has no modal group and cannot be active at program start"));
        } else if let Some((_, _, other)) = initial.iter().find(|(_, known, _)| *known == group) {
            names.check.error(place, format!("{name} and {other} are both of group {group}; one can be active"));
        } else {
            initial.push((id, group, name));
        }
    }
    initial.into_iter().map(|(id, _, _)| id).collect()
}
