//! `[[system_variables]]`: the values of numbered system variables.
//!
//! *Invariant:* a number has one row at most. Facts: reference fanuc-variables-and-alarms.md 1. A machine without rows
//! has those that every control of the kind has: clocks, modal codes, positions.

use crate::index::{IdTable, RegisterId};
use crate::rows::{CodeForm, CodeRow, Register};
use crate::system_variables::{FIRST, MODAL_CALLS, Means, OffsetColumn, PositionReference, SystemRow, SystemVariables};
use crate::toml::check::FindingCollector;
use crate::toml::node::TomlValue;
use crate::toml::section::TableReader;

/// Most rows.
const MOST: usize = 255;

/// Highest number.
const LAST: i64 = 999_999;

/// Most values at the start.
const MOST_INITIAL: usize = 1000;

/// Numbers that one row may have.
const LONGEST: u32 = 10_000;

/// Start of a job: a day that programs can print.
const START: (u32, u32) = (20_260_101, 80_000);

/// Reads the rows; switched-off ones are none.
pub(super) fn read(
    top: &mut TableReader<'_>,
    codes: &[CodeRow],
    registers: &IdTable<RegisterId, Register>,
    check: &FindingCollector,
) -> SystemVariables {
    let mut places = Vec::new();
    let mut variables = SystemVariables { start: START, alarm: 3000, ..SystemVariables::default() };
    let mut none = true;
    for mut row in top.rows("system_variables", "[[system_variables]]", MOST) {
        none = false;
        let enable = row.flag("enable").unwrap_or(true);
        if let Some(read) = read_row(&mut row).filter(|_| enable) {
            variables.rows.push(read);
            places.push(row.place().clone());
        }
        row.finish();
    }
    if none {
        variables.rows = every_control();
    }
    if let Err(overlap) = variables.compile()
        && let Some(place) = places.get(overlap.row)
    {
        check.error(place, format!("another row has #{} too", overlap.number));
    }
    variables.words = words(codes, registers);
    variables
}

/// Settings of `[variables]` for system variables.
pub(super) fn read_settings(section: &mut TableReader<'_>, variables: &mut SystemVariables, check: &FindingCollector) {
    if let Some(number) = section.integer("alarm_base", 0..=9999) {
        variables.alarm = number as u32;
    }
    if let Some(date) = section.integer("start_date", 19_700_101..=99_991_231) {
        let (month, day) = (date / 100 % 100, date % 100);
        if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
            section.error("start_date", format!("`start_date` must be a day as yyyymmdd, not {date}"));
        }
        variables.start.0 = date as u32;
    }
    if let Some(time) = section.integer("start_time", 0..=235_959) {
        if time / 100 % 100 > 59 || time % 100 > 59 {
            section.error("start_time", format!("`start_time` must be a time as hhmmss, not {time}"));
        }
        variables.start.1 = time as u32;
    }
    let Some(table) = section.free_table("initial") else { return };
    for entry in table.entries.iter().take(MOST_INITIAL) {
        let number = entry.key.trim_start_matches('#').parse::<u32>().ok().filter(|number| *number >= 100);
        match number.zip(crate::toml::section::number(&entry.node, &entry.key, check)) {
            Some(initial) => variables.initial.push(initial),
            None => check.error(&entry.place, format!("\"{}\" is not the number of a variable from 100 on", entry.key)),
        }
    }
    variables.initial.sort_by_key(|(number, _)| *number);
}

fn read_row(row: &mut TableReader<'_>) -> Option<SystemRow> {
    row.require("first", "the first number");
    row.require("is", "what the variables show");
    let first = row.integer("first", i64::from(FIRST)..=LAST)? as u32;
    let last = row.integer("last", i64::from(FIRST)..=LAST).map_or(first, |last| last as u32);
    if last < first || last - first >= LONGEST {
        row.error("last", format!("`last` must be from {first} to {}", first + LONGEST - 1));
        return None;
    }
    let also = row.list("also").unwrap_or_default();
    let also: Vec<u32> = also.iter().filter_map(|node| number_of(&node.value)).collect();
    let (means, writes) = means(row)?;
    let writable = row.flag("write").unwrap_or(writes);
    Some(SystemRow { first, last, also, means, writable })
}

fn number_of(value: &TomlValue) -> Option<u32> {
    match value {
        TomlValue::Integer(number) if (i64::from(FIRST)..=LAST).contains(number) => Some(*number as u32),
        _ => None,
    }
}

/// Meaning of a row, and whether programs may set it unless the row says otherwise.
fn means(row: &mut TableReader<'_>) -> Option<(Means, bool)> {
    #[derive(Clone, Copy)]
    enum Is {
        Kept,
        Input,
        Output,
        Bits,
        Alias,
        Simple(u8),
        Modal,
        Address,
        Position(PositionReference),
        WorkOffset,
        ToolOffset(bool),
    }
    let choices = [
        ("kept", Is::Kept),
        ("input", Is::Input),
        ("output", Is::Output),
        ("bits", Is::Bits),
        ("alias", Is::Alias),
        ("milliseconds", Is::Simple(0)),
        ("hours", Is::Simple(1)),
        ("date", Is::Simple(2)),
        ("time", Is::Simple(3)),
        ("settings", Is::Simple(4)),
        ("mirrors", Is::Simple(5)),
        ("main-program", Is::Simple(6)),
        ("modal", Is::Modal),
        ("address", Is::Address),
        ("local-shift", Is::Position(PositionReference::Local)),
        ("block-end", Is::Position(PositionReference::BlockEnd)),
        ("machine-position", Is::Position(PositionReference::Machine)),
        ("work-position", Is::Position(PositionReference::Work)),
        ("skip-position", Is::Position(PositionReference::Skip)),
        ("tool-compensation", Is::Position(PositionReference::Tool)),
        ("wear-compensation", Is::Position(PositionReference::Wear)),
        ("geometry-compensation", Is::Position(PositionReference::Geometry)),
        ("zero", Is::Position(PositionReference::Zero)),
        ("work-offset", Is::WorkOffset),
        ("tool-geometry", Is::ToolOffset(false)),
        ("tool-wear", Is::ToolOffset(true)),
    ];
    Some(match row.choice("is", &choices)? {
        Is::Kept => (Means::Kept(row.number("value").unwrap_or(0.0)), true),
        Is::Input => (Means::Kept(row.number("value").unwrap_or(0.0)), false),
        Is::Output => (Means::Bit(row.number("value").unwrap_or(0.0)), true),
        Is::Bits => {
            row.require("of", "the number of the first bit");
            (Means::Bits(row.integer("of", i64::from(FIRST)..=LAST)? as u32), true)
        }
        Is::Alias => {
            row.require("of", "the first number that is meant");
            (Means::Alias(row.integer("of", 100..=LAST)? as u32), true)
        }
        Is::Simple(which) => match which {
            0 => (Means::Milliseconds, true),
            1 => (Means::Hours, true),
            2 => (Means::Date, false),
            3 => (Means::TimeOfDay, false),
            4 => (Means::Settings, true),
            5 => (Means::Mirrors, false),
            _ => (Means::MainProgram, false),
        },
        Is::Modal => {
            let groups = row.numbers("groups", 1..=99).unwrap_or_default();
            let idle = row.numbers("idle", 1..=99).unwrap_or_default();
            let idle = idle.into_iter().chain(std::iter::repeat(0.0));
            let whole = |group: f64| if (0.0..=f64::from(MODAL_CALLS)).contains(&group) { group as u16 } else { 0 };
            (Means::Modal(groups.into_iter().map(whole).zip(idle).collect()), false)
        }
        Is::Address => {
            row.require("letters", "a letter for each number, `-` for none");
            (Means::Address(row.name("letters", 40)?.bytes().collect()), false)
        }
        Is::Position(frame) => {
            let axes = row.name("axes", 3).map(|axes| axes.bytes().map(role).collect());
            (Means::Position(frame, axes), false)
        }
        Is::WorkOffset => {
            let from = row.integer("from", 0..=999).unwrap_or(1) as u32;
            let stride = row.integer("stride", 1..=100).unwrap_or(20) as u32;
            match row.integer("axis", 1..=8) {
                Some(axis) => (Means::WorkOffsetAxis { from, axis: axis as u8 - 1 }, true),
                None => (Means::WorkOffset { from, stride }, true),
            }
        }
        Is::ToolOffset(wear) => {
            let columns = [
                ("X", OffsetColumn::Axis(0)),
                ("Y", OffsetColumn::Axis(1)),
                ("Z", OffsetColumn::Axis(2)),
                ("radius", OffsetColumn::Radius),
                ("diameter", OffsetColumn::Diameter),
                ("tip", OffsetColumn::Tip),
            ];
            row.require("column", "what the offset says: an axis, the radius, the tip");
            (Means::ToolOffset(row.choice("column", &columns)?, wear), true)
        }
    })
}

fn role(letter: u8) -> u8 {
    match letter {
        b'X' => 0,
        b'Y' => 1,
        _ => 2,
    }
}

/// G number of every code that has one, ascending.
fn words(codes: &[CodeRow], registers: &IdTable<RegisterId, Register>) -> Vec<(crate::ident::CodeId, f64)> {
    let mut words: Vec<(crate::ident::CodeId, f64)> = Vec::new();
    for row in codes.iter().filter(|row| row.enable) {
        let (CodeForm::Register { register, min, .. } | CodeForm::RegisterAsData { register, min, .. }) = row.form
        else {
            continue;
        };
        if registers[register].name == "G" && !words.iter().any(|(id, _)| *id == row.id) {
            words.push((row.id, min));
        }
    }
    words.sort_by_key(|(id, _)| *id);
    words
}

/// The common parts of the controls of this kind.
fn every_control() -> Vec<SystemRow> {
    let row = |first: u32, last: u32, means: Means, writable: bool| SystemRow {
        first,
        last,
        also: Vec::new(),
        means,
        writable,
    };
    let position = |first: u32, frame: PositionReference| row(first, first + 7, Means::Position(frame, None), false);
    vec![
        row(3001, 3001, Means::Milliseconds, true),
        row(3002, 3002, Means::Hours, true),
        row(3003, 3004, Means::Kept(0.0), true),
        row(4001, 4001, Means::Modal(vec![(1, 1.0)]), false),
        row(4014, 4014, Means::Modal(vec![(14, 54.0)]), false),
        row(4109, 4109, Means::Address(vec![b'F']), false),
        row(4119, 4120, Means::Address(vec![b'S', b'T']), false),
        row(4130, 4130, Means::Address(vec![b'P']), false),
        position(5001, PositionReference::BlockEnd),
        position(5021, PositionReference::Machine),
        position(5041, PositionReference::Work),
        position(5061, PositionReference::Skip),
    ]
}
