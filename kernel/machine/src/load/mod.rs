//! Reads a machine file, with the families it extends, into a checked [`Machine`].
//!
//! Invariant: there is a machine exactly when no finding is an error, and every mistake of the file is reported in one
//! go. One file per section of the form, which docs/machine-definition.md documents.

mod axes;
mod build;
mod calls;
mod chain;
mod channels;
mod codes;
mod compensation;
mod components;
mod cycles;
mod data;
mod defaults;
mod definition;
mod diagnostics;
mod dialogs;
mod digits;
mod external;
mod format;
mod habits;
mod head;
mod idle;
mod initial;
mod kinematics;
mod macro_uses;
mod macros;
mod names;
mod output;
mod overlap;
mod paths;
mod pump;
mod questionnaire;
mod questions;
mod refusals;
mod registers;
mod row_name;
mod signs;
mod spindles;
mod stops;
mod storage;
mod subprograms;
mod sync;
mod system_variables;
mod tape;
mod time;
mod tool;
mod units;
mod values;
mod variables;
mod waits;
mod word;

#[cfg(test)]
mod tests;

pub use components::is_common as is_section_of_composites;
pub use definition::{DefinedComponent, DefinitionKey, DefinitionRow, WrittenDefinition, definition, without_key};
pub use signs::candidates;

use std::sync::Arc;

use super::finding::Finding;
use super::model::{Component, Machine};
use super::toml::check::FindingCollector;
use super::toml::node::TomlTable;
use counterpoint_ports::files::JobFiles;

/// A machine, or why there is none.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The machine; there is one exactly when no finding is an error.
    pub machine: Option<Machine>,
    /// Errors and warnings by file, line and column.
    pub findings: Vec<Finding>,
}

/// Loads `<folder>/machine.toml`; `files` is a view of the machines folder, so that a family is `<name>/machine.toml`
/// in the same view.
#[must_use]
pub fn load(files: &dyn JobFiles, folder: &str) -> Loaded {
    let check = FindingCollector::default();
    let machine = chain::read(files, folder, &[], &check).map(|mut merged| {
        questionnaire::expand(&mut merged.table, &check);
        components::leave_out_family(&mut merged);
        components::check_family(&merged, &check);
        let plain = merged.table.clone();
        waits::expand(&mut merged.table);
        let (mut machine, rows) = build::machine(&merged, files, None, &check);
        if !rows.is_empty() {
            components::check_macros(&plain, &check);
            components::check_sections(&plain, &machine.file, &check);
            components::check_tool_words(&plain, &machine.file, &check);
            let made = made_of(&machine, (&plain, &merged.chain), &rows, files, &check);
            let of_rows: Vec<_> = made.iter().map(|(row, one)| (*row, &*one.machine)).collect();
            machine.storage = components::stored(&machine.storage, &of_rows, &check);
            machine.components = made.into_iter().map(|(_, component)| component).collect();
        }
        machine
    });
    let findings = check.into_findings();
    let usable = !findings.iter().any(|finding| finding.error);
    Loaded { machine: machine.filter(|_| usable), findings }
}

/// The components of a composite machine. Faults in a section that they have from the composite are reported once, as
/// faults of the composite.
fn made_of<'r>(
    composite: &Machine,
    (table, folders): (&TomlTable, &[String]),
    rows: &'r [components::ComponentRow],
    files: &dyn JobFiles,
    check: &FindingCollector,
) -> Vec<(&'r components::ComponentRow, Component)> {
    let mut made = Vec::new();
    for row in rows {
        let own = FindingCollector::default();
        let Some(merged) = chain::read(files, &row.folder, folders, &own) else {
            own.into_findings().into_iter().for_each(|finding| check.error(&row.place, finding.text));
            continue;
        };
        components::check_format(&merged, (table, folders), row, check);
        let mut merged = components::fit(merged, table, row);
        questionnaire::expand(&mut merged.table, &own);
        waits::expand(&mut merged.table);
        let (machine, _) = build::machine(&merged, files, Some(components::declaration(table)), &own);
        components::check_fit(&machine, composite, row, &own);
        own.pass_on(check, |finding| finding.error || finding.file != composite.file);
        let (designator, name) = (row.designator.clone(), row.name.clone());
        let channels = row.channels.clone();
        made.push((row, Component { designator, name, channels, machine: Arc::new(machine) }));
    }
    made
}
