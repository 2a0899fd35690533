//! `[[channels]]`: the paths of the control and the axes each one moves.
//!
//! Invariant: an axis that channels do not exchange belongs to one of them, and no two axes of a channel answer to the
//! same word.

use crate::index::{AxisId, AxisSlot, IdTable, SpindleId};
use crate::model::{Axis, Channel, Spindle};
use crate::toml::check::FindingCollector;
use crate::toml::node::{Node, TomlValue};
use crate::toml::section::TableReader;
use crate::toml::suggest::did_you_mean;
use counterpoint_event::MAX_AXES;

/// Most channels of a machine.
const MOST: usize = 99;

/// Reads the rows and sorts them by number.
pub(super) fn read(
    top: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    spindles: &IdTable<SpindleId, Spindle>,
    check: &FindingCollector,
) -> Vec<Channel> {
    top.require("channels", "at least one channel");
    let mut channels: Vec<Channel> = Vec::new();
    for mut row in top.rows("channels", "[[channels]]", MOST) {
        if let Some(channel) = read_row(&mut row, axes, spindles, check) {
            check_twins(&row, &channel, &channels, axes);
            channels.push(channel);
        }
        row.finish();
    }
    if channels.is_empty() && top.node("channels").is_some() {
        check.missing(top.place_of("channels"), "a machine needs at least one channel");
    }
    check_idle(top, &channels, axes, check);
    check_masters(top, &channels, axes, check);
    channels.sort_by_key(|channel| channel.number);
    channels
}

fn read_row(
    row: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    spindles: &IdTable<SpindleId, Spindle>,
    check: &FindingCollector,
) -> Option<Channel> {
    row.require("number", "a whole number from 1 to 99");
    let number = row.integer("number", 1..=99).map(|number| number as u16);
    let name = row.name("name", 32).map(str::to_owned);
    row.require("axes", "names of the channel's axes, in the order in which they are shown");
    let own = channel_axes(row, axes, check);
    let only = spindles.ids().next().filter(|_| spindles.len() == 1);
    let [spindle, rear, milling] = ["spindle", "rear", "milling"].map(|key| {
        let number = row.integer(key, 1..=99).map(|number| number as u16)?;
        let spindle = spindles.find(|spindle| spindle.number == number);
        if spindle.is_none() {
            check.missing(row.place_of(key), format!("no spindle has the number {number}"));
        }
        spindle
    });
    let polar = polar_axes(row, axes, &own, check);
    let lower = row.choice("side", &[("upper", false), ("lower", true)]).unwrap_or(false);
    let number = number?;
    let name = name.unwrap_or_else(|| format!("CHANNEL{number}"));
    Some(Channel { number, name, axes: own, spindle: spindle.or(only), rear, milling, polar, lower })
}

/// `polar = ["X1", "C1"]`: a linear and a rotary axis of the channel.
fn polar_axes(
    row: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    own: &IdTable<AxisSlot, AxisId>,
    check: &FindingCollector,
) -> Option<[AxisSlot; 2]> {
    let names = row.texts("polar")?;
    let found: Vec<AxisSlot> = names
        .iter()
        .filter_map(|(name, place)| {
            let slot = own.find(|axis| axes[*axis].name == *name);
            if slot.is_none() {
                check.missing(place, format!("the channel has no axis \"{}\"", name.escape_debug()));
            }
            slot
        })
        .collect();
    let rotary = |slot: AxisSlot| axes[own[slot]].role.is_rotary();
    match found.as_slice() {
        [linear, turning] if !rotary(*linear) && rotary(*turning) => Some([*linear, *turning]),
        _ if found.len() < names.len() => None,
        _ => {
            row.error("polar", "`polar` must be a linear and a rotary axis of the channel");
            None
        }
    }
}

fn channel_axes(
    row: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) -> IdTable<AxisSlot, AxisId> {
    let names = row.texts("axes").unwrap_or_default();
    if names.len() > MAX_AXES {
        row.error("axes", format!("a channel has at most {MAX_AXES} axes, not {}", names.len()));
    }
    let mut own: Vec<AxisId> = Vec::new();
    for (name, place) in names {
        let Some(axis) = axes.find(|axis| axis.name == name) else {
            let near = did_you_mean(name, axes.iter().map(|axis| axis.name.as_str()));
            check.missing(place, format!("no axis has the name \"{}\"{near}", name.escape_debug()));
            continue;
        };
        if own.contains(&axis) {
            check.error(place, format!("axis {name} is listed twice"));
        } else if let Some(twin) = own.iter().map(|other| &axes[*other]).find(|other| other.data == axes[axis].data) {
            check.error(place, format!("axes {} and {name} of one channel have the same `data`", twin.name));
        } else {
            own.push(axis);
        }
    }
    own.into_iter().collect()
}

/// Warns about axes that no channel has, unless a mistake may be the reason; those of a family cannot be taken away.
fn check_idle(top: &mut TableReader<'_>, channels: &[Channel], axes: &IdTable<AxisId, Axis>, check: &FindingCollector) {
    if check.has_errors() {
        return;
    }
    let Some(TomlValue::Array(rows)) = top.node("axes").map(|node| &node.value) else { return };
    for (id, axis) in axes.entries() {
        if channels.is_empty() || channels.iter().any(|channel| channel.axes.as_slice().contains(&id)) {
            continue;
        }
        let of_axis = |row: &&Node| matches!(&row.value, TomlValue::Table(row) if row.text("name") == Some(&axis.name));
        if let Some(row) = rows.iter().find(of_axis).filter(|row| row.place.file == top.place().file) {
            let text = format!("no channel has the axis {}, so nothing can move it; `axes` of [[channels]]", axis.name);
            check.idle(&row.place, text);
        }
    }
}

fn check_twins(row: &TableReader<'_>, channel: &Channel, others: &[Channel], axes: &IdTable<AxisId, Axis>) {
    for other in others {
        if other.number == channel.number {
            row.error("number", format!("there is already a channel {}", channel.number));
        } else if other.name == channel.name {
            row.error("name", format!("there is already a channel with the name \"{}\"", channel.name));
        }
        let shared = channel.axes.iter().filter(|axis| other.axes.as_slice().contains(axis));
        for axis in shared.map(|axis| &axes[*axis]).filter(|axis| axis.master.is_none()) {
            let text = format!(
                "axis {} already belongs to channel {}; `master` in its row of [[axes]] lets channels exchange it",
                axis.name, other.number
            );
            row.error("axes", text);
        }
    }
}

/// Axes that channels exchange: the one that has an axis at the start lists it, and so does another one.
fn check_masters(
    top: &mut TableReader<'_>,
    channels: &[Channel],
    axes: &IdTable<AxisId, Axis>,
    check: &FindingCollector,
) {
    let Some(TomlValue::Array(rows)) = top.node("axes").map(|node| &node.value) else { return };
    for (id, axis) in axes.entries() {
        let Some(master) = axis.master else { continue };
        let place = rows.iter().find_map(|row| match &row.value {
            TomlValue::Table(table) if table.text("name") == Some(&axis.name) => Some(&row.place),
            _ => None,
        });
        let Some(place) = place else { continue };
        let listing: Vec<u16> = channels
            .iter()
            .filter(|channel| channel.axes.as_slice().contains(&id))
            .map(|channel| channel.number)
            .collect();
        let name = &axis.name;
        if !listing.contains(&master) {
            check
                .error(place, format!("`master` of axis {name} is channel {master}, which does not list it in `axes`"));
        } else if listing.len() < 2 {
            check
                .warning(place, format!("`master` of axis {name} has no effect: only channel {master} lists the axis"));
        }
    }
}
