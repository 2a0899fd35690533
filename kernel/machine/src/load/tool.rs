//! `[tool]`, `[[tool.names]]`, `[[tool.data]]`, `[[tool.offsets]]` and `[[work_offsets]]`.
//!
//! Invariant: every offset has one value per axis of the machine; tools and tool offsets are in ascending order.

use super::values::{by_axis, some_by_axis};
use crate::index::{AxisId, IdTable};
use crate::model::{Axis, ToolFacts, ToolOffset, ToolSetup};
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Most offsets of a kind.
const MOST: usize = 1000;

/// Characters of a tool's name.
const LONGEST_NAME: usize = 80;

/// The largest number of a tool offset.
const LAST: i64 = 999_999;

/// Work offsets that always exist, G54 to G59.
const STANDARD: usize = 6;

/// Reads `[tool]`.
pub(super) fn read(top: &mut TableReader<'_>, axes: &IdTable<AxisId, Axis>, check: &FindingCollector) -> ToolSetup {
    let mut tool = ToolSetup { change_point: axes.map(|_, _| None), ..ToolSetup::default() };
    let Some(mut section) = top.table("tool", "[tool]") else { return tool };
    tool.offset_digits = section.integer("offset_digits", 0..=4).unwrap_or(0) as u8;
    tool.change_point = some_by_axis(&mut section, "change_position", axes, check);
    tool.change_motion = section.flag("change_motion").unwrap_or(false);
    if tool.change_motion && tool.change_point.iter().all(Option::is_none) {
        section.error("change_motion", "`change_motion` needs `change_position`, the axes to move and where to");
    }
    tool.edges = section.integer("edges", 2..=1000).unwrap_or(0) as u32;
    tool.named_from = section.integer("named_from", 1..=99_999_999).map(|number| number as u32);
    for mut row in section.rows("offsets", "[[tool.offsets]]", MOST) {
        if let Some(offset) = read_offset(&mut row, axes, check) {
            if tool.offsets.iter().any(|other| other.number == offset.number) {
                row.error("number", format!("there is already a tool offset {}", offset.number));
            }
            tool.offsets.push(offset);
        }
        row.finish();
    }
    tool.offsets.sort_by_key(|offset| offset.number);
    for mut row in section.rows("names", "[[tool.names]]", MOST) {
        row.require("name", "1 to 32 characters");
        row.require("number", "the number of the tool");
        let name = row.name("name", 32).map(str::to_ascii_uppercase);
        let number = row.integer("number", 1..=99_999_999);
        if let Some((name, number)) = name.zip(number) {
            if tool.names.iter().any(|(other, _)| *other == name) {
                row.error("name", format!("there is already a tool with the name \"{name}\""));
            }
            tool.names.push((name, number as u32));
        }
        row.finish();
    }
    for mut row in section.rows("data", "[[tool.data]]", MOST) {
        if let Some(facts) = read_data(&mut row) {
            if tool.data.iter().any(|other| other.number == facts.number) {
                row.error("number", format!("there is already a tool {}", facts.number));
            }
            tool.data.push(facts);
        }
        row.finish();
    }
    tool.data.sort_by_key(|facts| facts.number);
    section.finish();
    tool
}

fn read_data(row: &mut TableReader<'_>) -> Option<ToolFacts> {
    row.require("number", "a whole number from 1 to 99999999");
    let number = row.integer("number", 1..=99_999_999).map(|number| number as u32);
    let name = row.name("name", LONGEST_NAME).unwrap_or_default().to_owned();
    let [diameter, radius, length] = ["diameter", "radius", "length"].map(|key| row.at_least_zero(key));
    let offset = row.integer("offset", 1..=LAST).map(|number| number as u32);
    Some(ToolFacts { number: number?, name, diameter, radius, length, offset })
}

fn read_offset(
    row: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) -> Option<ToolOffset> {
    row.require("number", "a whole number from 1 to 999999");
    let number = row.integer("number", 1..=LAST).map(|number| number as u32);
    let radius = row.at_least_zero("radius").unwrap_or(0.0);
    let tip = row.integer("tip", 0..=9).unwrap_or(0) as u8;
    let values = by_axis(row, axes, check);
    let wear = some_by_axis(row, "wear", axes, check).map(|_, value| value.unwrap_or_default());
    let radius_wear = row.number("radius_wear").unwrap_or(0.0);
    Some(ToolOffset { number: number?, values, wear, radius, radius_wear, tip })
}

/// Reads `[[work_offsets]]`: G54 first, the part zero of the axes where the file says nothing.
pub(super) fn read_work(
    top: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) -> Vec<IdTable<AxisId, f64>> {
    let unset = axes.map(|_, axis| axis.positioning.part_zero);
    let mut offsets = vec![unset.clone(); STANDARD];
    let mut seen: Vec<i64> = Vec::new();
    for mut row in top.rows("work_offsets", "[[work_offsets]]", MOST) {
        row.require("number", "a whole number from 1 (G54) to 999");
        let number = row.integer("number", 1..=999);
        let given = some_by_axis(&mut row, "values", axes, check);
        let values = unset.map(|axis, unset| given[axis].unwrap_or(*unset));
        if let Some(number) = number {
            if seen.contains(&number) {
                row.error("number", format!("there is already a work offset {number}"));
            }
            seen.push(number);
            let index = number as usize - 1;
            offsets.resize(offsets.len().max(index + 1), unset.clone());
            if let Some(slot) = offsets.get_mut(index) {
                *slot = values;
            }
        }
        row.finish();
    }
    offsets
}
