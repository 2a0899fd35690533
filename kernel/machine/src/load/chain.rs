//! The chain of `extends`: a machine, its family, the family's family.
//!
//! A component of a composite machine may lie in a folder of its own inside that of the composite; such folders come
//! before those beside the composite. Invariant: identity (name, description, being a family) is never inherited.

use std::sync::Arc;

use super::row_name::row_name;
use super::units::check_units;
use crate::toml::check::FindingCollector;
use crate::toml::merge::merge;
use crate::toml::node::{DefinitionPlace, TomlTable, TomlValue};
use crate::toml::parse::parse;
use crate::toml::suggest::did_you_mean;
use counterpoint_ports::files::{FileError, JobFiles};

/// Name of the file in a machine's folder.
pub(super) const FILE: &str = "machine.toml";

/// A machine's own file over all its families.
pub(super) struct Merged {
    /// Everything.
    pub(super) table: TomlTable,
    /// The machine's own file.
    pub(super) start: DefinitionPlace,
    /// The folder it was loaded from.
    pub(super) folder: String,
    /// The folders of the chain, its own first.
    pub(super) chain: Vec<String>,
    /// The own file has signs.
    pub(super) own_signs: bool,
}

/// Reads and merges the chain; `None` when the machine's own file is not there. Folders inside those of `within` come
/// before folders beside them.
pub(super) fn read(files: &dyn JobFiles, name: &str, within: &[String], check: &FindingCollector) -> Option<Merged> {
    let folder = resolved(files, name, within, &[]);
    let start = place_of(&folder);
    let own = read_file(files, (name, &folder), &start, None, check)?;
    let own_signs = own.get("signs").is_some();
    let mut tables = vec![own];
    let mut folders = vec![folder.clone()];
    while let Some((parent, place)) = tables.last().and_then(extends) {
        let next = resolved(files, &parent, within, &folders);
        let Some(table) = parent_table(files, &folders, (&parent, &next), &place, check) else { break };
        folders.push(next);
        tables.push(table);
    }
    if tables.last().is_some_and(|table| table.get("extends").is_some()) {
        check.set_incomplete();
    }
    let table = tables.into_iter().rev().reduce(|parent, child| {
        check_units(&parent, &child, check);
        merge(heritage(parent), child, row_name)
    })?;
    Some(Merged { table, start, folder, chain: folders, own_signs })
}

/// The folder that a name means: the first one inside those of `within`, except for those that were seen, otherwise one
/// beside them.
fn resolved(files: &dyn JobFiles, name: &str, within: &[String], seen: &[String]) -> String {
    let mut inside = within.iter().filter(|_| is_plain(name)).map(|outer| format!("{outer}/{name}"));
    let found = inside.find(|folder| !seen.contains(folder) && files.read(&format!("{folder}/{FILE}")).is_ok());
    found.unwrap_or_else(|| name.to_owned())
}

/// Whether a name is that of a folder, without a path.
pub(super) fn is_plain(name: &str) -> bool {
    !name.is_empty() && !name.contains(['/', '\\']) && !name.starts_with('.')
}

fn parent_table(
    files: &dyn JobFiles,
    seen: &[String],
    (parent, folder): (&str, &str),
    place: &DefinitionPlace,
    check: &FindingCollector,
) -> Option<TomlTable> {
    if seen.iter().any(|seen| seen == folder) {
        let circle = seen.iter().map(String::as_str).chain([folder]).collect::<Vec<_>>().join(" -> ");
        check.error(place, format!("`extends` runs in a circle: {circle}"));
        return None;
    }
    read_file(files, (parent, folder), place, Some(parent), check)
}

fn extends(table: &TomlTable) -> Option<(String, DefinitionPlace)> {
    let node = table.get("extends")?;
    match &node.value {
        TomlValue::Text(name) => Some((name.clone(), node.place.clone())),
        _ => None,
    }
}

fn read_file(
    files: &dyn JobFiles,
    (name, folder): (&str, &str),
    place: &DefinitionPlace,
    parent: Option<&str>,
    check: &FindingCollector,
) -> Option<TomlTable> {
    let path = format!("{folder}/{FILE}");
    let content = if is_plain(name) { files.read(&path) } else { Err(FileError::Missing(path)) };
    match content {
        Ok(bytes) => Some(parse(&place_of(folder).file, &bytes, check)),
        Err(FileError::Missing(_)) => {
            let what = if parent.is_some() { "no machine to extend" } else { "no machine" };
            check.error(place, format!("{what} of the name \"{}\"{}", name.escape_debug(), known(files, name)));
            None
        }
        Err(FileError::Unreadable { reason, .. }) => {
            check.error(place, format!("cannot read {folder}/{FILE}: {reason}"));
            None
        }
    }
}

/// The machines there are, and the nearest.
fn known(files: &dyn JobFiles, wanted: &str) -> String {
    let paths = files.list();
    let names: Vec<&str> = paths
        .iter()
        .filter_map(|path| path.strip_suffix(FILE)?.strip_suffix('/'))
        .filter(|name| !name.contains('/'))
        .collect();
    if names.is_empty() {
        return "; there are none".to_owned();
    }
    format!("{}; there are: {}", did_you_mean(wanted, names.iter().copied()), names.join(", "))
}

fn place_of(folder: &str) -> DefinitionPlace {
    DefinitionPlace { file: Arc::from(format!("{folder}/{FILE}")), line: 0, column: 0 }
}

/// The inherited parts of a child.
fn heritage(mut parent: TomlTable) -> TomlTable {
    parent.remove("abstract");
    parent.remove("extends");
    if let Some(ce) = parent.table_mut("ce") {
        ce.remove("name");
        ce.remove("description");
        ce.remove("created");
    }
    parent
}
