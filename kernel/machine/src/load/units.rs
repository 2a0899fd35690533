//! A machine whose unit is not that of the family that it extends.
//!
//! *Invariant:* a row that selects the primary or the secondary unit has the unit of the machine in mind that wrote it,
//! so a machine with another unit does not inherit it: G20 never selects millimetres by accident.

use crate::ident::codes;
use crate::toml::check::FindingCollector;
use crate::toml::node::{Node, TomlTable, TomlValue};

/// Codes that select a unit.
const UNITS: [crate::ident::CodeId; 3] = [codes::UNITS_PRIMARY, codes::UNITS_SECONDARY, codes::UNITS_SECONDARY_LENGTHS];

/// Reports rows of the units that a machine has from a family in another unit.
pub(super) fn check_units(family: &TomlTable, own: &TomlTable, check: &FindingCollector) {
    let Some(wanted) = unit(own).filter(|wanted| unit_text(Some(wanted)) != unit_text(unit(family))) else { return };
    let system = [own, family].iter().find_map(|table| section(table, "control")?.text("system")).unwrap_or("A");
    let own: Vec<_> = rows(own).filter_map(name).collect();
    let kept = |row: &&TomlTable| {
        let selects = row.text("id").and_then(crate::ident::code).is_some_and(|id| UNITS.contains(&id));
        let enabled = !matches!(row.get("enable").map(|node| &node.value), Some(TomlValue::Flag(false)));
        selects && enabled && is_in_system(row, system) && name(row).is_none_or(|name| !own.contains(&name))
    };
    let mut words: Vec<&str> = Vec::new();
    for word in rows(family).filter(kept).filter_map(|row| row.text("word").or_else(|| row.text("text"))) {
        if !words.contains(&word) {
            words.push(word);
        }
    }
    if words.is_empty() {
        return;
    }
    let text = format!(
        "the family has the unit {}, so {} would select the opposite unit here, and all its lengths and rates would \
         count as {}; leave `units` out (programs select their unit, and CODE_UNITS_SECONDARY in `initial` makes the \
         other one that of the start), or write these rows of [[codes]] anew for this machine",
        unit_text(unit(family)),
        words.join(", "),
        unit_text(Some(wanted)),
    );
    check.error(&wanted.place, text);
}

fn section<'t>(table: &'t TomlTable, name: &str) -> Option<&'t TomlTable> {
    if let TomlValue::Table(section) = &table.get(name)?.value { Some(section) } else { None }
}

fn unit(table: &TomlTable) -> Option<&Node> {
    section(table, "ce")?.get("units")
}

fn unit_text(unit: Option<&Node>) -> &str {
    match unit.map(|node| &node.value) {
        Some(TomlValue::Text(text)) => text,
        _ => "mm",
    }
}

fn rows(table: &TomlTable) -> impl Iterator<Item = &TomlTable> {
    let rows = match table.get("codes").map(|node| &node.value) {
        Some(TomlValue::Array(rows)) => rows.as_slice(),
        _ => &[],
    };
    rows.iter().filter_map(|row| if let TomlValue::Table(row) = &row.value { Some(row) } else { None })
}

/// Whether the row is one of the machine's system of G codes.
fn is_in_system(row: &TomlTable, system: &str) -> bool {
    match row.get("systems").map(|node| &node.value) {
        Some(TomlValue::Array(systems)) => {
            systems.iter().any(|known| matches!(&known.value, TomlValue::Text(known) if known == system))
        }
        _ => true,
    }
}

fn name(row: &TomlTable) -> Option<String> {
    super::row_name::row_name("codes", row)
}
