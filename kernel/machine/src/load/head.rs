//! `[ce]` and `[machine]`: the identity of the machine.
//!
//! Invariant: a name has 1 to 32 characters; units and pre-processor are always decided.

use crate::model::MachineKind;
use crate::preprocessor::Preprocessor;
use crate::toml::section::TableReader;
use counterpoint_event::MachineUnit;

/// The content of the two sections.
pub(super) struct MachineIdentity {
    pub(super) name: String,
    pub(super) number: u32,
    pub(super) revision: u32,
    pub(super) created: String,
    pub(super) author: String,
    pub(super) description: String,
    pub(super) unit: MachineUnit,
    pub(super) preprocessor: Preprocessor,
    pub(super) kind: MachineKind,
}

/// Reads both.
pub(super) fn read(top: &mut TableReader<'_>) -> MachineIdentity {
    let mut head = MachineIdentity {
        name: String::new(),
        number: 1,
        revision: 1,
        created: String::new(),
        author: String::new(),
        description: String::new(),
        unit: MachineUnit::Mm,
        preprocessor: Preprocessor::NONE,
        kind: MachineKind::Mill,
    };
    top.require("ce", "a section with the machine's name");
    if let Some(section) = top.table("ce", "[ce]") {
        read_ce(section, &mut head);
    }
    top.require("machine", "a section with the type of the machine");
    if let Some(section) = top.table("machine", "[machine]") {
        read_machine(section, &mut head);
    }
    head
}

fn read_ce(mut section: TableReader<'_>, head: &mut MachineIdentity) {
    section.require("name", "1 to 32 characters");
    head.name = section.name("name", 32).unwrap_or_default().to_owned();
    head.number = section.integer("number", 1..=999_999).unwrap_or(1) as u32;
    head.revision = section.integer("revision", 0..=999_999).unwrap_or(1) as u32;
    head.created = section.name("created", 40).unwrap_or_default().to_owned();
    head.author = section.text("author").unwrap_or_default().to_owned();
    head.description = section.text("description").unwrap_or_default().to_owned();
    for key in ["author", "description"] {
        let text = if key == "author" { &head.author } else { &head.description };
        if text.chars().any(char::is_control) {
            section.error(key, format!("`{key}` must be one line of text"));
        }
    }
    head.unit =
        section.choice("units", &[("mm", MachineUnit::Mm), ("inch", MachineUnit::Inch)]).unwrap_or(MachineUnit::Mm);
    let preprocessors: Vec<_> =
        Preprocessor::all().map(|preprocessor| (preprocessor.row().name, preprocessor)).collect();
    head.preprocessor = section.choice("preprocessor", &preprocessors).unwrap_or_default();
    section.finish();
}

fn read_machine(mut section: TableReader<'_>, head: &mut MachineIdentity) {
    section.require("type", "mill, lathe, merging-lathe or composite");
    let kinds = [
        ("mill", MachineKind::Mill),
        ("lathe", MachineKind::Lathe),
        ("merging-lathe", MachineKind::MergingLathe),
        ("composite", MachineKind::Composite),
    ];
    head.kind = section.choice("type", &kinds).unwrap_or(MachineKind::Mill);
    section.finish();
}
