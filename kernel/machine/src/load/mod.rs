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
mod cycles;
mod data;
mod defaults;
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
mod spindles;
mod storage;
mod subprograms;
mod sync;
mod system_variables;
mod tape;
mod time;
mod tool;
mod values;
mod variables;
mod waits;
mod word;

#[cfg(test)]
mod tests;

use super::finding::Finding;
use super::model::Machine;
use super::toml::check::Check;
use counterpoint_ports::files::Files;

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
pub fn load(files: &dyn Files, folder: &str) -> Loaded {
    let check = Check::default();
    let machine = chain::read(files, folder, &check).map(|mut merged| {
        questionnaire::expand(&mut merged.table, &check);
        waits::expand(&mut merged.table);
        build::machine(&merged, files, &check)
    });
    let findings = check.into_findings();
    let usable = !findings.iter().any(|finding| finding.error);
    Loaded { machine: machine.filter(|_| usable), findings }
}
