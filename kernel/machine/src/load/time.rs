//! `[time]`: durations.
//!
//! Invariant: an M number with a time has a code row of its own that carries it.

use super::digits;
use super::names::NameRegistry;
use crate::ident::{self, codes, data};
use crate::index::RegisterId;
use crate::model::{RapidPath, Time};
use crate::rows::{CodeForm, CodeRow, Modality, TimeOverlap};
use crate::tables::form_range;
use crate::toml::node::{TomlEntry, TomlValue};
use crate::toml::section::{TableReader, number};

/// Moves that a control plans at a time if its machine does not say.
const LOOK_AHEAD: u32 = 100;

/// Largest M number.
const LARGEST: u32 = 99_999_999;

/// Reads the section; times of M codes go to the code rows.
pub(super) fn read(top: &mut TableReader<'_>, names: &NameRegistry<'_>, rows: &mut Vec<CodeRow>) -> Time {
    let mut time = Time {
        tool_change: 0.0,
        tool_step: 0.0,
        stations: 0,
        tool_overlap: TimeOverlap::None,
        rapid: RapidPath::SlowestAxis,
        spindle_speed: 0.0,
        look_ahead: LOOK_AHEAD,
        corner_deviation: None,
        block_time: 0.0,
    };
    let Some(mut section) = top.table("time", "[time]") else { return time };
    time.tool_change = section.at_least_zero("tool_change").unwrap_or(0.0);
    time.tool_step = section.at_least_zero("tool_step").unwrap_or(0.0);
    time.stations = section.integer("stations", 0..=999).unwrap_or(0) as u32;
    time.tool_overlap = section.choice("tool_overlap", &TimeOverlap::WORDS).unwrap_or_default();
    let paths = [("slowest-axis", RapidPath::SlowestAxis), ("linear", RapidPath::Linear)];
    time.rapid = section.choice("rapid", &paths).unwrap_or(RapidPath::SlowestAxis);
    time.spindle_speed = section.at_least_zero("spindle_speed").unwrap_or(0.0);
    time.look_ahead = section.integer("look_ahead", 1..=5000).map_or(LOOK_AHEAD, |blocks| blocks as u32);
    time.corner_deviation = section.above_zero("corner_deviation");
    time.block_time = section.at_least_zero("block_time").unwrap_or(0.0);
    if let Some(table) = section.free_table("m_codes") {
        let register = names.registers.find(|register| register.name == "M");
        if register.is_none() {
            names.check.missing(section.place_of("m_codes"), "`m_codes` needs a register M");
        }
        let mut seen: Vec<(u32, &TomlEntry)> = Vec::new();
        for entry in &table.entries {
            let (Some((number, seconds, overlap)), Some(register)) = (read_entry(entry, names), register) else {
                continue;
            };
            if let Some((_, other)) = seen.iter().find(|(known, _)| *known == number) {
                let TomlEntry { key, place, .. } = other;
                let text = format!(
                    "M{number} already has its seconds at {}:{} as \"{key}\"; one key for each M number is expected",
                    place.file, place.line
                );
                names.check.error(&entry.place, text);
                continue;
            }
            seen.push((number, entry));
            let written = format!("M{number}");
            let known = &names.registers[register];
            if let Some(text) = digits::complaint(&written, f64::from(number), known) {
                names.check.warning(&entry.place, text);
            }
            give(entry, register, number, (seconds, overlap), names, rows);
        }
    }
    section.finish();
    time
}

/// `"3" = 1.5`, or `"3" = { seconds = 1.5, overlap = "rapids" }`.
fn read_entry(entry: &TomlEntry, names: &NameRegistry<'_>) -> Option<(u32, f64, TimeOverlap)> {
    let (seconds, overlap) = match &entry.node.value {
        TomlValue::Table(table) => {
            let mut section = TableReader::new(table, entry.node.place.clone(), "a time of `m_codes`", names.check);
            section.require("seconds", "the seconds of the M number");
            let seconds = section.at_least_zero("seconds");
            let overlap = section.choice("overlap", &TimeOverlap::WORDS).unwrap_or_default();
            section.finish();
            (seconds, overlap)
        }
        _ => (number(&entry.node, &entry.key, names.check), TimeOverlap::None),
    };
    let m = entry.key.parse::<u32>().ok().filter(|m| *m <= LARGEST && !entry.key.starts_with('+'));
    if m.is_none() {
        let key = entry.key.escape_debug();
        names.check.error(&entry.place, format!("`m_codes` takes M numbers as keys (\"3\" = 1.5), not \"{key}\""));
    }
    if let Some(seconds) = seconds
        && seconds < 0.0
    {
        names.check.error(&entry.node.place, format!("seconds of M{} must be zero or more", entry.key));
        return None;
    }
    Some((m?, seconds?, overlap))
}

/// Adds the seconds to the rows of the M number, or makes a row for it.
fn give(
    entry: &TomlEntry,
    register: RegisterId,
    m: u32,
    (seconds, overlap): (f64, TimeOverlap),
    names: &NameRegistry<'_>,
    rows: &mut Vec<CodeRow>,
) {
    let value = f64::from(m);
    let mut found = false;
    for row in rows.iter_mut().filter(|row| row.enable && row.process) {
        match form_range(&row.form) {
            Some((of, min, max)) if of == register && min == value && max == value => {
                row.seconds += seconds;
                row.overlap = overlap;
                found = true;
            }
            Some((of, min, max)) if of == register && (min..=max).contains(&value) => {
                let text = "is one of a range of codes; give that row `seconds`, or the number a row of its own";
                names.check.error(&entry.place, format!("M{m} {text}"));
                found = true;
            }
            _ => {}
        }
    }
    if !found {
        let replaces = |row: &CodeRow| {
            row.enable
                && form_range(&row.form).is_some_and(|(of, min, max)| of == register && (min..=max).contains(&value))
        };
        let turns_no_spindle = rows.iter().any(|row| replaces(row) && row.turns_no_spindle);
        let row = function_row(entry, register, value, (seconds, overlap));
        rows.push(CodeRow { turns_no_spindle, ..row });
    }
}

fn function_row(
    entry: &TomlEntry,
    register: RegisterId,
    value: f64,
    (seconds, overlap): (f64, TimeOverlap),
) -> CodeRow {
    CodeRow {
        id: codes::FUNCTION,
        form: CodeForm::RegisterAsData { register, min: value, max: value, data: data::FUNCTION },
        enable: true,
        process: true,
        order: ident::code_facts(codes::FUNCTION).map_or(300, |facts| facts.order),
        group: 0,
        modality: Modality::NonModal,
        mul: 1.0,
        add: 0.0,
        with: Vec::new(),
        without: Vec::new(),
        ignores: Vec::new(),
        owns_axes: false,
        turns_no_spindle: false,
        also: false,
        special: false,
        seconds,
        overlap,
        axis: None,
        line: entry.place.line,
        file: entry.place.file.to_string(),
    }
}
