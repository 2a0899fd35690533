//! `[[spindles]]`.
//!
//! Invariant: numbers and names are unique, and the smallest speed is below the largest. A spindle that has
//! followers does not follow a spindle.

use crate::index::{AxisId, IdTable, SpindleId};
use crate::model::{Axis, ChuckAtStart, Spindle};
use crate::rows::TimeOverlap;
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Most spindles of a machine.
const MOST: usize = 99;

/// Reads the rows in file order.
pub(super) fn read(
    top: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) -> IdTable<SpindleId, Spindle> {
    let mut spindles: Vec<Spindle> = Vec::new();
    for mut row in top.rows("spindles", "[[spindles]]", MOST) {
        if let Some(spindle) = read_row(&mut row, axes) {
            if spindles.iter().any(|other| other.number == spindle.number) {
                check.error(row.place_of("number"), format!("there is already a spindle {}", spindle.number));
            } else if spindles.iter().any(|other| other.name == spindle.name) {
                let text = format!("there is already a spindle with the name \"{}\"", spindle.name);
                check.error(row.place_of("name"), text);
            }
            spindles.push(spindle);
        }
        row.finish();
    }
    for spindle in &spindles {
        let Some(leader) = spindle.follows else { continue };
        let name = spindle.number;
        match spindles.iter().find(|other| other.number == leader) {
            None => {
                check.error(top.place_of("spindles"), format!("spindle {name} follows {leader}, which does not exist"))
            }
            Some(other) if other.follows.is_some() => {
                let text = format!("spindle {name} follows {leader}, which itself follows a spindle");
                check.error(top.place_of("spindles"), text);
            }
            Some(_) => {}
        }
    }
    spindles.into_iter().collect()
}

fn read_row(row: &mut TableReader<'_>, axes: &IdTable<AxisId, Axis>) -> Option<Spindle> {
    row.require("number", "a whole number from 1 to 99");
    let number = row.integer("number", 1..=99).map(|number| number as u16);
    let name = row.name("name", 32).map(str::to_owned);
    row.require("max", "the largest speed in rev/min");
    let max = row.above_zero("max");
    let min = row.at_least_zero("min").unwrap_or(0.0);
    if let Some(max) = max
        && min > max
    {
        row.error("min", format!("`min` {min} is more than `max` {max}"));
    }
    let run_up = row.at_least_zero("run_up").unwrap_or(0.0);
    let overlap = row.choice("overlap", &TimeOverlap::WORDS).unwrap_or_default();
    let follows = row.integer("follows", 1..=99).map(|number| number as u16);
    let phase = row.at_least_zero("phase").unwrap_or(0.0);
    let chuck = row.choice("chuck", &ChuckAtStart::WORDS);
    let takes_in_phase = row.flag("takes_in_phase").unwrap_or(false);
    let slide = row.text("slide").map(str::to_owned);
    let found = slide.as_ref().and_then(|name| axes.find(|axis| axis.name == *name));
    if let Some(name) = slide.filter(|_| found.is_none()) {
        row.error("slide", format!("there is no axis with the name \"{name}\""));
    }
    let slide = found;
    let number = number?;
    let name = name.unwrap_or_else(|| format!("S{number}"));
    Some(Spindle {
        number,
        name,
        max: max.unwrap_or(1.0),
        min,
        run_up,
        overlap,
        follows,
        phase,
        chuck,
        slide,
        takes_in_phase,
    })
}
