//! `[[data]]`: which register supplies which value.
//!
//! Invariant: an identifier and a register meet in one row only. Facts: reference control-emulator.md 1.3.

use super::digits;
use super::names::NameRegistry;
use crate::ident::dimension::Dimension;
use crate::rows::DataRow;
use crate::toml::section::TableReader;
use counterpoint_event::MachineUnit;

/// Most rows of the data table.
const MOST: usize = 4000;

/// Reads the rows in file order.
pub(super) fn read(top: &mut TableReader<'_>, names: &mut NameRegistry<'_>, unit: MachineUnit) -> Vec<DataRow> {
    top.require("data", "the words that supply values");
    let mut rows: Vec<DataRow> = Vec::new();
    for mut section in top.rows("data", "[[data]]", MOST) {
        if let Some(row) = read_row(&mut section, names, unit) {
            if let Some(twin) = rows.iter().find(|other| other.id == row.id && other.register == row.register) {
                let name = section.text("id").unwrap_or_default();
                let text = format!("{name} already has this register at {}:{}", twin.file, twin.line);
                section.error("id", text);
            }
            rows.push(row);
        }
        section.finish();
    }
    rows
}

/// Numbers of all words are as written: no row counts increments.
pub(super) fn as_written(rows: &mut [DataRow]) {
    for row in rows {
        row.increment = None;
    }
}

fn read_row(section: &mut TableReader<'_>, names: &mut NameRegistry<'_>, unit: MachineUnit) -> Option<DataRow> {
    let id = names.data_of_row(section);
    let register = section.text("register").map(|name| names.register(name, section.place_of("register")));
    let enable = section.flag("enable").unwrap_or(true);
    let process = section.flag("process").unwrap_or(true);
    let modal = section.flag("modal");
    let (min, max) = (section.number("min"), section.number("max"));
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        section.error("max", format!("`max` {max} is less than `min` {min}"));
    }
    let known = register.flatten().map(|register| &names.registers[register]);
    for (key, limit) in [("min", min.filter(|min| *min > 0.0)), ("max", max.filter(|max| *max < 0.0))] {
        if let (Some(limit), Some(register)) = (limit, known)
            && digits::out_of_reach(limit, register)
        {
            let shown = digits::shown(register);
            section.warning(key, format!("no number can be within `{key}` {limit}: {shown}"));
        }
    }
    let mut mul = super::values::factor(section);
    let add = section.number("add").unwrap_or(0.0);
    let dimension = dimension(section);
    if dimension == Some(Dimension::Increments) {
        mul *= if unit == MachineUnit::Inch { 0.0001 } else { 0.001 };
    }
    let increment = section.numbers("increment", 2..=2).and_then(|units| <[f64; 2]>::try_from(units).ok());
    if increment.is_some_and(|units| units.iter().any(|unit| *unit <= 0.0)) {
        section.error("increment", "`increment` must be two numbers above zero");
    }
    let (id, swallow) = id?;
    let register = match register {
        None => None,
        Some(register) => Some(register?),
    };
    Some(DataRow {
        id,
        register,
        enable,
        process: process && !swallow,
        modal: modal.unwrap_or_else(|| id.kind().is_modal()),
        min,
        max,
        mul,
        add,
        dimension: dimension.unwrap_or_else(|| id.dimension()),
        increment,
        line: section.place().line,
        file: section.place().file.to_string(),
    })
}

fn dimension(section: &mut TableReader<'_>) -> Option<Dimension> {
    let words = [
        ("none", Dimension::None),
        ("length", Dimension::Length),
        ("increments", Dimension::Increments),
        ("angle", Dimension::Angle),
        ("feed", Dimension::Feed),
        ("feed-tenths", Dimension::FeedTenths),
        ("surface-speed", Dimension::SurfaceSpeed),
        ("time", Dimension::Time),
    ];
    section.choice("dimension", &words)
}
