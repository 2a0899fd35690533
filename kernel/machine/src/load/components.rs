//! `[[components]]`: the definitions that a composite machine is made of.
//!
//! A component is a machine file of its own, or a family. Sections that the components have in common belong to the
//! composite and replace their own sections: axes, channels, spindles, waits, the shape of programs, tools and work
//! offsets; the keys of tool words are each component's own. Times and ranges of variables are shared key by key. A
//! component with another pre-processor has the shape of its own programs. Invariants: units of all components are
//! those of the composite; each channel has a component; the macros of a component see the GLOBAL variables of the
//! composite, and its own GLOBAL variables belong to its object.

use crate::model::{Channel, Machine, MachineKind};
use crate::stored::StoredFile;
use crate::toml::check::FindingCollector;
use crate::toml::merge::merge;
use crate::toml::node::{DefinitionPlace, Node, TomlEntry, TomlTable, TomlValue};
use crate::toml::section::TableReader;
use counterpoint_lang::ident::minor_code;

use super::chain::{FILE, Merged, is_plain};
use super::row_name::row_name;

/// Most components of a machine.
const MOST: usize = 99;

/// Sections that a component has from its composite.
pub(super) const COMMON: [&str; 8] =
    ["axes", "channels", "spindles", "waits", "sync", "format", "tool", "work_offsets"];

/// Keys of `[tool]` for the form in which programs of a control name tools; each component has its own.
const OWN_TOOL_KEYS: [&str; 3] = ["offset_digits", "edges", "named_from"];

/// Sections whose keys a component has from its composite unless its own folder or `add` gives them. A component with
/// another pre-processor has only those of the first list.
const SHARED_KEYS: [&str; 1] = ["time"];
const SHARED_KEYS_OF_A_PREPROCESSOR: [&str; 1] = ["variables"];

/// Macros that a composite has; all others are its components'.
const OWN_MACROS: [&str; 3] = ["declaration", "machine_startup", "machine_shutdown"];

/// A row of the section.
pub(super) struct ComponentRow {
    pub(super) designator: String,
    pub(super) name: String,
    /// Folder of the machine file.
    pub(super) folder: String,
    pub(super) channels: Vec<u16>,
    /// Additions of the composite's file to the definition, as a file that extends it.
    pub(super) add: Option<TomlTable>,
    /// Where the folder is named.
    pub(super) place: DefinitionPlace,
}

/// Reads the rows.
pub(super) fn read(
    top: &mut TableReader<'_>,
    kind: MachineKind,
    channels: &[Channel],
    check: &FindingCollector,
) -> Vec<ComponentRow> {
    let mut rows: Vec<ComponentRow> = Vec::new();
    for mut section in top.rows("components", "[[components]]", MOST) {
        if let Some(row) = read_row(&mut section, channels, check) {
            if rows.iter().any(|other| other.designator == row.designator) {
                section.error("designator", format!("another component has the designator {}", row.designator));
            }
            rows.push(row);
        }
        section.finish();
    }
    match kind {
        MachineKind::Composite => {
            top.require("components", "the definitions that the composite machine is made of");
            let has = |channel: &Channel| rows.iter().any(|row| row.channels.contains(&channel.number));
            if let Some(channel) = channels.iter().find(|channel| !has(channel)).filter(|_| !rows.is_empty()) {
                check.missing(top.place_of("components"), format!("channel {} has no component", channel.number));
            }
        }
        _ if !rows.is_empty() => top.error("components", "only a machine of the type composite has components"),
        _ => {}
    }
    rows
}

fn read_row(row: &mut TableReader<'_>, channels: &[Channel], check: &FindingCollector) -> Option<ComponentRow> {
    row.require("designator", "the minor word by which macros name the component (TURN, MILL)");
    let designator = row.name("designator", 24).map(str::to_ascii_uppercase);
    if let Some(word) = designator.as_deref().filter(|word| minor_code(word).is_none()) {
        row.error("designator", format!("{word} is no minor word of the macro language; TURN, MILL, DRILL are some"));
    }
    let name = row.name("name", 32).map(str::to_owned);
    row.require("machine", "the folder of the definition");
    let folder = row.text("machine").map(str::to_owned);
    if let Some(folder) = folder.as_deref().filter(|folder| !is_plain(folder)) {
        let text = format!(
            "\"{}\" is not the name of a folder: give it without a path; it lies inside the folder of this machine or beside \
             it, or is shipped",
            folder.escape_debug()
        );
        row.error("machine", text);
    }
    let mut own = Vec::new();
    for node in row.list("channels").unwrap_or_default() {
        let channel = channels.iter().find(|channel| match node.value {
            TomlValue::Integer(number) => number == i64::from(channel.number),
            _ => false,
        });
        match channel {
            Some(channel) => own.push(channel.number),
            None => check.error(&node.place, "`channels` lists numbers of channels of this machine"),
        }
    }
    if own.is_empty() {
        row.require("channels", "the channels that the component works in");
    }
    own.sort_unstable();
    own.dedup();
    let add = row.free_table("add").cloned();
    for key in COMMON.iter().chain(&["extends", "abstract", "components"]) {
        if let Some(node) = add.as_ref().and_then(|add| add.get(key)).filter(|node| !is_of_tool_words(key, &node.value))
        {
            check.error(&node.place, format!("`{key}` is no matter of a component"));
        }
    }
    let (designator, place) = (designator?, row.place_of("machine").clone());
    Some(ComponentRow {
        name: name.unwrap_or_else(|| designator.clone()),
        designator,
        folder: folder?,
        channels: own,
        add,
        place,
    })
}

/// Whether a section has only keys of `[tool]` that are a component's own.
fn is_of_tool_words(section: &str, value: &TomlValue) -> bool {
    let only = |table: &TomlTable| table.entries.iter().all(|entry| OWN_TOOL_KEYS.contains(&entry.key.as_str()));
    section == "tool" && matches!(value, TomlValue::Table(table) if only(table))
}

/// Whether a component has a section, or a part of it such as `format.opskip`, from its composite.
#[must_use]
pub fn is_common(section: &str) -> bool {
    COMMON.contains(&section.split('.').next().unwrap_or_default())
}

/// The file of a component with the sections that it has from its composite.
pub(super) fn fit(mut component: Merged, composite: &TomlTable, row: &ComponentRow) -> Merged {
    let control = |table: &TomlTable| table.get("ce").and_then(|ce| preprocessor(&ce.value).map(str::to_owned));
    let own_shape = control(&component.table) != control(composite);
    let of_control = SHARED_KEYS_OF_A_PREPROCESSOR.iter().filter(|_| !own_shape);
    for key in SHARED_KEYS.iter().chain(of_control) {
        let shared = shared_keys(&component.table, composite, key);
        component.table = merge(component.table, shared, row_name);
    }
    if let Some(add) = &row.add {
        component.table = merge(component.table, add.clone(), row_name);
    }
    let table = &mut component.table;
    table.remove("abstract");
    let tool_words = tool_words(table);
    for key in COMMON {
        if key == "format" && own_shape {
            continue;
        }
        table.remove(key);
        table.entries.extend(composite.entries.iter().find(|entry| entry.key == key).cloned());
    }
    let place = row.place.clone();
    if table.get("tool").is_none() && !tool_words.is_empty() {
        table.entries.push(entry("tool", &place, TomlValue::Table(TomlTable::default())));
    }
    if let Some(tool) = table.table_mut("tool") {
        tool.entries.retain(|entry| !OWN_TOOL_KEYS.contains(&entry.key.as_str()));
        tool.entries.extend(tool_words);
    }
    if table.get("ce").is_none() {
        table.entries.push(entry("ce", &place, TomlValue::Table(TomlTable::default())));
    }
    if let Some(ce) = table.table_mut("ce").filter(|ce| ce.get("name").is_none()) {
        ce.entries.push(entry("name", &place, TomlValue::Text(row.name.clone())));
    }
    component
}

/// The keys of `[tool]` that are a component's own.
fn tool_words(component: &TomlTable) -> Vec<TomlEntry> {
    let Some(TomlValue::Table(tool)) = component.get("tool").map(|node| &node.value) else { return Vec::new() };
    tool.entries.iter().filter(|entry| OWN_TOOL_KEYS.contains(&entry.key.as_str())).cloned().collect()
}

/// Keys of a section of the composite, without those that the folder of the component inside that of the composite
/// gives.
fn shared_keys(component: &TomlTable, composite: &TomlTable, section: &str) -> TomlTable {
    let entry = composite.entries.iter().find(|entry| entry.key == section).cloned();
    let Some(mut entry) = entry else { return TomlTable::default() };
    let own = match component.get(section).map(|node| &node.value) {
        Some(TomlValue::Table(own)) => own.entries.as_slice(),
        _ => &[],
    };
    if let TomlValue::Table(table) = &mut entry.node.value {
        table.entries.retain(|entry| own.iter().all(|own| own.key != entry.key || !is_inside(&own.place)));
    }
    TomlTable { entries: vec![entry] }
}

/// Whether a place is in a folder inside that of a machine.
fn is_inside(place: &DefinitionPlace) -> bool {
    place.file.matches('/').count() > 1
}

/// Name of the pre-processor in a section.
fn preprocessor(section: &TomlValue) -> Option<&str> {
    match section {
        TomlValue::Table(section) => section.text("preprocessor"),
        _ => None,
    }
}

fn entry(key: &str, place: &DefinitionPlace, value: TomlValue) -> TomlEntry {
    TomlEntry { key: key.to_owned(), place: place.clone(), node: Node { place: place.clone(), value } }
}

/// Leaves out the macros and stored files that a composite has from the family of a control: they are its components'.
///
/// The family begins after the last folder of the chain that says `type = "composite"` or has rows of components.
pub(super) fn leave_out_family(composite: &mut Merged) {
    let of_machine = composite.table.get("machine").and_then(|node| match &node.value {
        TomlValue::Table(machine) => machine.get("type").filter(|_| machine.text("type") == Some("composite")),
        _ => None,
    });
    let Some(kind) = of_machine else { return };
    let rows = match composite.table.get("components").map(|node| &node.value) {
        Some(TomlValue::Array(rows)) => rows.as_slice(),
        _ => &[],
    };
    let places: Vec<&DefinitionPlace> = rows.iter().map(|row| &row.place).chain([&kind.place]).collect();
    let says =
        |folder: &String| places.iter().any(|place| place.file.strip_suffix(FILE) == Some(&format!("{folder}/")));
    let last = composite.chain.iter().rposition(says).unwrap_or(0);
    let own: Vec<String> = composite.chain.iter().take(last + 1).map(|folder| format!("{folder}/{FILE}")).collect();
    let is_own = |entry: &TomlEntry| own.iter().any(|file| **file == *entry.place.file);
    composite.table.entries.retain(|entry| entry.key != "files" || is_own(entry));
    if let Some(macros) = composite.table.table_mut("macros") {
        macros.entries.retain(is_own);
    }
}

/// Reports a composite without words of its own, which its waits and its axes need.
pub(super) fn check_family(composite: &Merged, check: &FindingCollector) {
    let Some(TomlValue::Array(rows)) = composite.table.get("components").map(|node| &node.value) else { return };
    let missing = ["registers", "codes", "data"].iter().any(|key| composite.table.get(key).is_none());
    if !missing || composite.table.get("extends").is_some() {
        return;
    }
    let first = rows.iter().find_map(|row| match &row.value {
        TomlValue::Table(row) => row.text("machine"),
        _ => None,
    });
    let family = first.map(|first| format!("; add extends = \"{first}\"")).unwrap_or_default();
    check.error(
        &composite.start,
        format!(
            "a composite machine has the words of its waits and axes from the definition of a component, which it \
             extends{family}"
        ),
    );
    check.set_incomplete();
}

/// Warns of a component whose programs are read in the form of another family.
pub(super) fn check_format(
    component: &Merged,
    composite: (&TomlTable, &[String]),
    row: &ComponentRow,
    check: &FindingCollector,
) {
    let control = |table: &TomlTable| table.get("ce").and_then(|ce| preprocessor(&ce.value).map(str::to_owned));
    let (table, folders) = composite;
    let family = folders.last().filter(|_| folders.len() > 1);
    let is_of_family = component.chain.iter().any(|folder| folders.contains(folder));
    if let Some(family) = family.filter(|_| !is_of_family && control(&component.table) == control(table)) {
        check.warning(
            &row.place,
            format!(
                "{} has the [format] of the composite, which is that of {family}: the composite must extend {} or a family \
                 of it",
                row.folder, row.folder
            ),
        );
    }
}

/// The files stored with a composite: its own, and those of its components.
pub(super) fn stored(
    composite: &[StoredFile],
    rows: &[(&ComponentRow, &Machine)],
    check: &FindingCollector,
) -> Vec<StoredFile> {
    let mut all = composite.to_vec();
    for (row, component) in rows {
        for file in &component.storage {
            match all.iter().find(|other| other.path.eq_ignore_ascii_case(&file.path)) {
                None => all.push(file.clone()),
                Some(other) if other.content == file.content => {}
                Some(_) => check.error(
                    &row.place,
                    format!(
                        "{} has a stored file {} with another content than that of the composite or of another component; \
                         files stored with a machine belong to all channels, rename one of them",
                        row.folder, file.path
                    ),
                ),
            }
        }
    }
    all.sort_by(|a, b| a.path.cmp(&b.path));
    all
}

/// The declaration macro of a composite, whose GLOBAL variables its components see: name of the file, and where it is
/// named.
pub(super) fn declaration(composite: &TomlTable) -> Option<(&str, &DefinitionPlace)> {
    let TomlValue::Table(macros) = &composite.get("macros")?.value else { return None };
    Some((macros.text("declaration")?, &macros.get("declaration")?.place))
}

/// Sections that the blocks of a component take from its own definition.
const OWN_SECTIONS: [&str; 15] = [
    "codes",
    "control",
    "refusals",
    "subprograms",
    "system_variables",
    "cycles",
    "arcs",
    "turning",
    "threads",
    "compensation",
    "corners",
    "tape_editor",
    "initial",
    "coolant",
    "kinematics",
];

/// Reports sections of the file of a composite that have no effect, except those inherited from its family.
pub(super) fn check_sections(composite: &TomlTable, file: &str, check: &FindingCollector) {
    let own = |place: &DefinitionPlace| &*place.file == file;
    for entry in composite.entries.iter().filter(|entry| OWN_SECTIONS.contains(&entry.key.as_str())) {
        // Rows of a family keep their places.
        let place = match &entry.node.value {
            TomlValue::Array(rows) => rows.iter().map(|row| &row.place).find(|place| own(place)),
            _ => Some(&entry.place).filter(|place| own(place)),
        };
        let Some(place) = place else { continue };
        let key = &entry.key;
        check.warning(
            place,
            format!(
                "`{key}` of a composite machine is never read: its components have their own; write it to `add` of \
                 [[components]] or to the file of the component"
            ),
        );
    }
}

/// Reports keys of tool words in the file of a composite, which have no effect.
pub(super) fn check_tool_words(composite: &TomlTable, file: &str, check: &FindingCollector) {
    for entry in tool_words(composite).iter().filter(|entry| &*entry.place.file == file) {
        check.warning(
            &entry.place,
            format!(
                "`tool.{}` of a composite machine is never read: its components have their own tool words; write it to \
                 `add` of [[components]] or to the file of the component",
                entry.key
            ),
        );
    }
}

/// Reports macros of a composite that never run.
pub(super) fn check_macros(composite: &TomlTable, check: &FindingCollector) {
    let Some(TomlValue::Table(macros)) = composite.get("macros").map(|node| &node.value) else { return };
    let never = |entry: &&TomlEntry| {
        !OWN_MACROS.contains(&entry.key.as_str()) && !matches!(&*entry.key, "strong" | "warn_unassigned" | "functions")
    };
    for entry in macros.entries.iter().filter(never) {
        check.warning(
            &entry.place,
            format!("`{}` of a composite machine never runs: its components have their own", entry.key),
        );
    }
}

/// Reports a component that cannot work beside the others.
pub(super) fn check_fit(component: &Machine, composite: &Machine, row: &ComponentRow, check: &FindingCollector) {
    if component.unit != composite.unit {
        let word = |unit| if unit == counterpoint_event::MachineUnit::Inch { "inch" } else { "mm" };
        let text = format!(
            "the unit of a component must be that of the composite, whose axes and offsets it has: {} has {}, not {}; \
             a component whose programs are in the other unit begins with CODE_UNITS_SECONDARY",
            row.folder,
            word(component.unit),
            word(composite.unit)
        );
        check.error(&row.place, text);
    }
    if component.kind == MachineKind::Composite || component.kind == MachineKind::MergingLathe {
        check.error(&row.place, "a component is a mill or a lathe");
    }
}
