//! `[[codes]]`: which word or text fires which code.
//!
//! Invariant: a row has exactly one form, an order of 1 to 999 and a group of 0 to 999. Facts: reference
//! control-emulator.md 1.2.

use super::defaults;
use super::digits;
use super::names::NameRegistry;
use super::word::{self, CodeWordError};
use crate::ident;
use crate::ident::kind::CodeKind;
use crate::index::RegisterId;
use crate::rows::{CodeForm, CodeRow, Modality, TimeOverlap};
use crate::toml::section::TableReader;

/// Most rows of the code table.
const MOST: usize = 4000;

/// Order of a custom code.
const CUSTOM_ORDER: u16 = 300;

/// Systems of G codes that one control may be set to.
const SYSTEMS: [(&str, &str); 3] = [("A", "A"), ("B", "B"), ("C", "C")];

/// Whether the row belongs to other systems of G codes than that of the machine.
fn in_other_systems(section: &mut TableReader<'_>, system: &str) -> bool {
    let Some(systems) = section.texts("systems") else { return false };
    for (name, place) in &systems {
        if SYSTEMS.iter().all(|(known, _)| known != name) {
            section.error_at(
                place,
                format!("`systems` is a list of \"A\", \"B\" and \"C\", not of \"{}\"", name.escape_debug()),
            );
        }
    }
    systems.iter().all(|(name, _)| *name != system)
}

/// Reads the rows in file order.
pub(super) fn read(top: &mut TableReader<'_>, names: &mut NameRegistry<'_>) -> Vec<CodeRow> {
    top.require("codes", "the words that fire codes");
    let mut rows: Vec<CodeRow> = Vec::new();
    let system = top.table("control", "[control]").and_then(|mut control| control.choice("system", &SYSTEMS));
    for mut section in top.rows("codes", "[[codes]]", MOST) {
        let elsewhere = in_other_systems(&mut section, system.unwrap_or("A"));
        let Some(row) = read_row(&mut section, names).filter(|_| !elsewhere) else {
            section.finish();
            continue;
        };
        if let Some(twin) = rows.iter().find(|other| other.is_twin_of(&row)) {
            let name = section.text("id").unwrap_or_default();
            section.error("id", format!("{name} is already written like this at {}:{}", twin.file, twin.line));
        }
        if section.flag("alias") == Some(true) && !rows.iter().any(|other| other.id == row.id) {
            let text = "`alias` is for a second form, but no row before this one has the identifier";
            names.check.warning(section.place_of("alias"), text);
        }
        section.finish();
        rows.push(row);
    }
    rows
}

fn read_row(section: &mut TableReader<'_>, names: &mut NameRegistry<'_>) -> Option<CodeRow> {
    let id = names.code_of_row(section);
    let form = read_form(section, names);
    let enable = section.flag("enable").unwrap_or(true);
    let process = section.flag("process").unwrap_or(true);
    let order = section.integer("order", 1..=999).map(|order| order as u16);
    let group = section.integer("group", 0..=999).map(|group| group as u16);
    let modality = modality(section);
    let mul = super::values::factor(section);
    let add = section.number("add").unwrap_or(0.0);
    let with = registers(section, "with", names);
    let without = registers(section, "without", names);
    let ignores = registers(section, "ignores", names);
    let owns_axes = section.flag("owns_axes");
    let turns_no_spindle = section.flag("turns_no_spindle").unwrap_or(false);
    let also = section.flag("also").unwrap_or(false);
    if also && with.is_empty() && without.is_empty() {
        section.error("also", "a row that acts beside another one of its word needs `with` or `without`");
    }
    if with.iter().any(|register| without.contains(register)) {
        section.error("without", "a register cannot be both in `with` and in `without`");
    }
    if let Some(CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. }) = &form {
        if without.contains(register) {
            section.error(
                "without",
                "the row's own register is on every block that it could match: the row never matches",
            );
        }
        if with.contains(register) {
            let text = "the row's own register is on every block that it could match: this says nothing";
            names.check.warning(section.place_of("with"), text);
        }
    }
    let seconds = section.at_least_zero("seconds").unwrap_or(0.0);
    let overlap = section.choice("overlap", &TimeOverlap::WORDS).unwrap_or_default();
    let axis = section.choice("axis", &[("X", 0), ("Y", 1), ("Z", 2)]);
    section.node("alias");
    let (id, swallow) = id?;
    let facts = ident::code_facts(id);
    let group = group.unwrap_or_else(|| facts.map_or(0, |facts| facts.group));
    if group == 0 && matches!(modality, Some(Modality::Modal | Modality::Persistent)) {
        section.error("modality", "a modal code needs a group of 1 to 999");
    }
    Some(CodeRow {
        id,
        form: form?,
        enable,
        process: process && !swallow,
        order: order.unwrap_or_else(|| facts.map_or(CUSTOM_ORDER, |facts| facts.order)),
        group,
        modality: modality.unwrap_or_else(|| defaults::modality(id, group)),
        mul,
        add,
        with,
        without,
        ignores,
        owns_axes: owns_axes.unwrap_or_else(|| ident::owns::owns_axes(id)),
        turns_no_spindle,
        also,
        special: swallow || !process || matches!(id.kind(), CodeKind::Length { .. }),
        seconds,
        overlap,
        axis,
        line: section.place().line,
        file: section.place().file.to_string(),
    })
}

fn modality(section: &mut TableReader<'_>) -> Option<Modality> {
    let words = [("non-modal", Modality::NonModal), ("modal", Modality::Modal), ("persistent", Modality::Persistent)];
    section.choice("modality", &words)
}

/// Exactly one of `word`, `text`, `none = true`.
fn read_form(section: &mut TableReader<'_>, names: &NameRegistry<'_>) -> Option<CodeForm> {
    let has_word = section.node("word").is_some();
    let has_text = section.node("text").is_some();
    let none = section.flag("none") == Some(true);
    let has_data = section.node("as_data").is_some();
    match (has_word, has_text, none) {
        (true, false, false) => read_word(section, names),
        (false, true, false) => {
            if has_data {
                section.error("as_data", "`as_data` needs a `word`: a text has no value");
            }
            section.name("text", 64).map(|text| CodeForm::Text(text.to_owned()))
        }
        (false, false, true) => Some(CodeForm::NotApplicable),
        (false, false, false) => {
            let forms = "`word` (\"G1\", \"G54-G59\"), `text` or `none = true`";
            names.check.error(section.place(), format!("[[codes]] needs a form: {forms}"));
            None
        }
        _ => {
            names.check.error(section.place(), "[[codes]] takes only one of `word`, `text` and `none`");
            None
        }
    }
}

fn read_word(section: &mut TableReader<'_>, names: &NameRegistry<'_>) -> Option<CodeForm> {
    let data = section.text("as_data").map(|name| names.data(name, section.place_of("as_data")));
    let written = section.text("word")?;
    let word = match word::parse(written, &names.registers) {
        Ok(word) => word,
        Err(CodeWordError::Register(letters)) => {
            names.unknown_register(&letters, section.place_of("word"));
            return None;
        }
        Err(CodeWordError::Form(text)) => {
            section.error("word", text);
            return None;
        }
    };
    let (register, min, max) = (word.register, word.min, word.max);
    let known = &names.registers[register];
    if let Some(text) = digits::complaint(written, min, known) {
        section.warning("word", text);
    }
    match data {
        None => Some(CodeForm::Register { register, min, max }),
        Some(data) => Some(CodeForm::RegisterAsData { register, min, max, data: data? }),
    }
}

fn registers(section: &mut TableReader<'_>, key: &'static str, names: &NameRegistry<'_>) -> Vec<RegisterId> {
    let texts = section.texts(key).unwrap_or_default();
    texts.into_iter().filter_map(|(name, place)| names.register(name, place)).collect()
}
