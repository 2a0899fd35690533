//! `[signs]`: the signs by which the machine of a program is guessed.
//!
//! Invariant: every pattern can be read. A machine is guessed only if its own file has the section; signs of its
//! families also count.

use counterpoint_ports::files::JobFiles;
use counterpoint_signs::{HEAVIEST, MachineCandidate, Rows, SignPattern, Signs};

use super::chain;
use crate::toml::check::FindingCollector;
use crate::toml::node::{TomlTable, TomlValue};
use crate::toml::section::TableReader;

/// Longest name of a control or trait.
const LONGEST: usize = 80;

/// Reads the section.
pub(super) fn read(top: &mut TableReader<'_>, check: &FindingCollector) -> Option<Signs> {
    let mut section = top.table("signs", "[signs]")?;
    section.require("control", "the control, as messages name it");
    let signs = Signs {
        control: section.name("control", LONGEST).unwrap_or_default().to_owned(),
        plain: section.flag("plain").unwrap_or(false),
        marks: section.free_table("marks").map_or_else(Rows::new, |table| rows(table, check)),
        waits: section.free_table("waits").map_or_else(Rows::new, |table| rows(table, check)),
        channels: section.free_table("channels").map_or_else(Rows::new, |table| rows(table, check)),
        elsewhere: section.free_table("elsewhere").map_or_else(Vec::new, |table| tables(table, check)),
        traits: section.free_table("traits").map_or_else(Vec::new, |table| tables(table, check)),
    };
    section.finish();
    Some(signs)
}

/// Tables of signs under names.
fn tables(table: &TomlTable, check: &FindingCollector) -> Vec<(String, Rows)> {
    let mut all = Vec::with_capacity(table.entries.len());
    for entry in &table.entries {
        let length = entry.key.chars().count();
        if length == 0 || length > LONGEST || entry.key.chars().any(char::is_control) {
            check.error(
                &entry.place,
                format!(
                    "the name of a table of signs must have 1 to {LONGEST} characters, none of them a control character"
                ),
            );
        }
        match &entry.node.value {
            TomlValue::Table(table) => all.push((entry.key.clone(), rows(table, check))),
            other => check.error(&entry.node.place, format!("signs must be a table, not {}", other.kind())),
        }
    }
    // A machine does not have a trait of its family without a sign that is left.
    all.retain(|(_, rows)| !rows.is_empty());
    all
}

/// Patterns with their weights; weight 0 removes a sign of the family.
fn rows(table: &TomlTable, check: &FindingCollector) -> Rows {
    let mut rows = Rows::new();
    for entry in &table.entries {
        let weight = match &entry.node.value {
            TomlValue::Integer(weight) => u32::try_from(*weight).ok().filter(|weight| *weight <= HEAVIEST),
            _ => None,
        };
        let Some(weight) = weight else {
            check.error(&entry.node.place, format!("the weight of a sign must be a whole number from 0 to {HEAVIEST}"));
            continue;
        };
        match SignPattern::parse(&entry.key) {
            Ok(pattern) => rows.push((pattern, weight)),
            Err(why) => check.error(&entry.place, format!("the sign \"{}\" {why}", entry.key.escape_debug())),
        }
    }
    rows.retain(|(_, weight)| *weight > 0);
    rows
}

/// The machines of these names that programs can show, with their signs. A machine that cannot be read is left out.
#[must_use]
pub fn candidates(files: &dyn JobFiles, names: &[String]) -> Vec<MachineCandidate> {
    names.iter().filter_map(|name| candidate(files, name)).collect()
}

fn candidate(files: &dyn JobFiles, name: &str) -> Option<MachineCandidate> {
    // Most machines need not be read for it.
    let own = files.read(&format!("{name}/{}", chain::FILE)).ok()?;
    if !own.windows(6).any(|part| part == b"[signs") {
        return None;
    }
    let check = FindingCollector::default();
    let merged = chain::read(files, name, &[], &check).filter(|merged| merged.own_signs)?;
    let mut top = TableReader::new(&merged.table, merged.start.clone(), "the machine file", &check);
    let signs = read(&mut top, &check).filter(|_| !check.has_errors())?;
    let channels = match merged.table.get("channels").map(|node| &node.value) {
        Some(TomlValue::Array(rows)) => rows.len(),
        _ => 0,
    };
    let layout = match merged.table.get("control").map(|node| &node.value) {
        Some(TomlValue::Table(control)) => control.text("programs").unwrap_or_default(),
        _ => "",
    };
    let axes = match merged.table.get("axes").map(|node| &node.value) {
        Some(TomlValue::Array(rows)) => rows.iter().filter_map(|row| first_letter(&row.value)).collect(),
        _ => Vec::new(),
    };
    let whole_file = matches!(layout, "heads" | "sections");
    Some(MachineCandidate { name: name.to_owned(), channels, whole_file, axes, signs })
}

/// The first letter of the name of an axis.
fn first_letter(axis: &TomlValue) -> Option<char> {
    let TomlValue::Table(axis) = axis else { return None };
    axis.text("name")?.chars().next()
}
