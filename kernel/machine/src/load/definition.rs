//! A definition as written, including the families that it extends: sections, rows and keys, each with its place.
//!
//! Invariant: nothing is interpreted but the questionnaire, whose answers are shown as the rows that they make; so
//! every key of a file is there, also one that the machine as loaded no longer has.

use super::build;
use super::chain::{self, Merged};
use super::row_name::row_name;
use super::{questionnaire, waits};
use crate::finding::Finding;
use crate::model::Machine;
use crate::toml::check::FindingCollector;
use crate::toml::merge::merge;
use crate::toml::node::{DefinitionPlace, Node, TomlEntry, TomlTable, TomlValue};
use counterpoint_ports::files::JobFiles;

/// A definition.
#[derive(Debug, Clone, Default)]
pub struct WrittenDefinition {
    /// The machine, its family, the family's family.
    pub chain: Vec<String>,
    /// All rows in the order of the files.
    pub rows: Vec<DefinitionRow>,
    /// The components of a composite machine, in the order of their rows.
    pub components: Vec<DefinedComponent>,
}

/// The definition of a component of a composite machine, without the sections that it has from the composite.
#[derive(Debug, Clone)]
pub struct DefinedComponent {
    /// The minor word by which macros name it.
    pub designator: String,
    /// The folder that its row names.
    pub machine: String,
    /// Its definition, with the additions in the row.
    pub definition: WrittenDefinition,
}

/// A row of a section, or a section without rows.
#[derive(Debug, Clone, PartialEq)]
pub struct DefinitionRow {
    /// Section: `codes`, `time.m_codes`; empty for the keys above all sections.
    pub section: String,
    /// The key by which a row of another file replaces it (`CODE_RAPID word G0`); empty for a section without rows.
    pub name: String,
    /// File and line.
    pub place: String,
    /// Its keys.
    pub keys: Vec<DefinitionKey>,
}

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct DefinitionKey {
    /// Key; tables inside a row are written with dots.
    pub key: String,
    /// Value as a machine file has it.
    pub value: String,
    /// File and line.
    pub place: String,
}

/// The definition in a folder, or the findings that keep it from being read.
pub fn definition(files: &dyn JobFiles, folder: &str) -> Result<WrittenDefinition, Vec<Finding>> {
    let mut merged = merged(files, folder)?;
    let check = FindingCollector::default();
    questionnaire::expand(&mut merged.table, &check);
    let mut definition = WrittenDefinition { chain: merged.chain.clone(), ..WrittenDefinition::default() };
    definition.add("", &merged.table, &merged.start);
    definition.components = components(files, &merged)?;
    Ok(definition)
}

/// The components of a composite machine.
fn components(files: &dyn JobFiles, composite: &Merged) -> Result<Vec<DefinedComponent>, Vec<Finding>> {
    let Some(TomlValue::Array(rows)) = composite.table.get("components").map(|node| &node.value) else {
        return Ok(Vec::new());
    };
    let mut made = Vec::new();
    for row in rows {
        let TomlValue::Table(row) = &row.value else { continue };
        let (Some(designator), Some(machine)) = (row.text("designator"), row.text("machine")) else { continue };
        let check = FindingCollector::default();
        let merged = chain::read(files, machine, &composite.chain, &check);
        let findings = check.into_findings();
        let Some(merged) = merged.filter(|_| findings.iter().all(|finding| !finding.error)) else {
            return Err(findings);
        };
        let mut table = merged.table;
        if let Some(TomlValue::Table(add)) = row.get("add").map(|node| &node.value) {
            table = merge(table, add.clone(), row_name);
        }
        super::components::COMMON.iter().for_each(|key| table.remove(key));
        let check = FindingCollector::default();
        questionnaire::expand(&mut table, &check);
        let mut definition = WrittenDefinition { chain: merged.chain, ..WrittenDefinition::default() };
        definition.add("", &table, &merged.start);
        let designator = designator.to_ascii_uppercase();
        made.push(DefinedComponent { designator, machine: machine.to_owned(), definition });
    }
    Ok(made)
}

/// The machine without a key of a section without rows; its behaviour is then the default.
#[must_use]
pub fn without_key(files: &dyn JobFiles, folder: &str, section: &str, key: &str) -> Option<Machine> {
    let mut merged = merged(files, folder).ok()?;
    let mut table = &mut merged.table;
    for part in section.split('.').filter(|part| !part.is_empty()) {
        table = table.table_mut(part)?;
    }
    table.remove(key);
    let check = FindingCollector::default();
    questionnaire::expand(&mut merged.table, &check);
    waits::expand(&mut merged.table);
    let (machine, _) = build::machine(&merged, files, None, &check);
    check.into_findings().iter().all(|finding| !finding.error).then_some(machine)
}

fn merged(files: &dyn JobFiles, folder: &str) -> Result<Merged, Vec<Finding>> {
    let check = FindingCollector::default();
    let merged = chain::read(files, folder, &[], &check);
    let findings = check.into_findings();
    match merged {
        Some(merged) if findings.iter().all(|finding| !finding.error) => Ok(merged),
        _ => Err(findings),
    }
}

impl WrittenDefinition {
    /// Adds a section with everything below it.
    fn add(&mut self, section: &str, table: &TomlTable, place: &DefinitionPlace) {
        let mut plain = Vec::new();
        for TomlEntry { key, node, place } in &table.entries {
            let inside = if section.is_empty() { key.clone() } else { format!("{section}.{key}") };
            match &node.value {
                TomlValue::Table(table) => self.add(&inside, table, place),
                TomlValue::Array(items) if items.iter().any(|item| matches!(item.value, TomlValue::Table(_))) => {
                    self.add_rows(&inside, items);
                }
                _ => plain.push(self::key(key, node, place)),
            }
        }
        if !plain.is_empty() {
            let place = at(place);
            self.rows.push(DefinitionRow { section: section.to_owned(), name: String::new(), place, keys: plain });
        }
    }

    fn add_rows(&mut self, section: &str, items: &[Node]) {
        for item in items {
            let TomlValue::Table(row) = &item.value else { continue };
            let name = row_name(section, row).unwrap_or_default().trim().to_owned();
            let mut keys = Vec::new();
            add_keys("", row, &mut keys);
            self.rows.push(DefinitionRow { section: section.to_owned(), name, place: at(&item.place), keys });
        }
    }
}

/// The keys of a row, those of its tables with dots.
fn add_keys(before: &str, table: &TomlTable, keys: &mut Vec<DefinitionKey>) {
    for TomlEntry { key, node, place } in &table.entries {
        let inside = format!("{before}{key}");
        match &node.value {
            TomlValue::Table(table) => add_keys(&format!("{inside}."), table, keys),
            _ => keys.push(self::key(&inside, node, place)),
        }
    }
}

fn key(key: &str, node: &Node, place: &DefinitionPlace) -> DefinitionKey {
    DefinitionKey { key: key.to_owned(), value: written(node), place: at(place) }
}

fn at(place: &DefinitionPlace) -> String {
    format!("{}:{}", place.file, place.line)
}

/// A value as a machine file has it.
fn written(node: &Node) -> String {
    match &node.value {
        TomlValue::Text(text) => format!("\"{}\"", text.escape_debug()),
        TomlValue::Integer(number) => number.to_string(),
        TomlValue::Float(number) => number.to_string(),
        TomlValue::Flag(flag) => flag.to_string(),
        TomlValue::Date => "a date".to_owned(),
        TomlValue::Array(items) => format!("[{}]", items.iter().map(written).collect::<Vec<_>>().join(", ")),
        TomlValue::Table(table) => {
            let keys = table.entries.iter().map(|entry| format!("{} = {}", entry.key, written(&entry.node)));
            format!("{{ {} }}", keys.collect::<Vec<_>>().join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::Overlay;
    use counterpoint_ports::files::MemoryFiles;

    fn own(text: &str) -> Overlay<MemoryFiles, MemoryFiles> {
        let mut files = MemoryFiles::default();
        files.insert("own/machine.toml", text);
        Overlay::over_shipped(files)
    }

    #[test]
    fn every_key_has_its_value_and_its_place() {
        let files = own("extends = \"fanuc-lathe\"\n[ce]\nname = \"own\"\n[time]\ntool_step = 0.5\n");
        let found = definition(&files, "own").expect("a definition");
        assert_eq!(found.chain, ["own", "fanuc-lathe", "fanuc-turning", "fanuc-common"]);
        let time = found.rows.iter().find(|row| row.section == "time").expect("times");
        let key = |name: &str| time.keys.iter().find(|key| key.key == name).expect("a key");
        assert_eq!((key("tool_step").value.as_str(), key("tool_step").place.as_str()), ("0.5", "own/machine.toml:5"));
        assert_eq!(key("stations").value, "12");
        assert!(key("stations").place.starts_with("fanuc-lathe/machine.toml:"));
        let code = found.rows.iter().find(|row| row.name == "CODE_RAPID word G0").expect("a code");
        assert!(code.section == "codes" && code.place.starts_with("fanuc-common/machine.toml:"));
    }

    #[test]
    fn without_a_key_the_default_counts() {
        let files = own("extends = \"fanuc-lathe\"\n[ce]\nname = \"own\"\n[time]\nstations = 7\n");
        assert_eq!(without_key(&files, "own", "time", "stations").map(|machine| machine.time.stations), Some(0));
        assert!(without_key(&files, "own", "nothing", "stations").is_none());
        assert!(definition(&files, "missing").is_err_and(|findings| findings.iter().any(|finding| finding.error)));
    }
}
