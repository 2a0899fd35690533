//! `[[axes]]`: the axes.
//!
//! Invariant: names are unique in the machine, and an axis starts inside its limits.

use super::defaults;
use super::names::NameRegistry;
use crate::ident::{self, DataId};
use crate::index::{AxisId, IdTable};
use crate::model::{Axis, AxisCoupling, AxisRole, Dynamics, FixedStop, ReferencePoints, RotaryPositioning};
use crate::rows::DataRow;
use crate::toml::section::TableReader;

/// Most axes of a machine.
const MOST: usize = 99;

/// Highest number by which programs name an axis.
const HIGHEST: i64 = 32_767;

/// Reads the rows in file order.
pub(super) fn read(top: &mut TableReader<'_>, names: &NameRegistry<'_>, data: &[DataRow]) -> IdTable<AxisId, Axis> {
    top.require("axes", "the axes of the machine");
    let mut axes: Vec<Axis> = Vec::new();
    for mut row in top.rows("axes", "[[axes]]", MOST) {
        if let Some(axis) = read_row(&mut row, names) {
            if axes.iter().any(|other| other.name == axis.name) {
                row.error("name", format!("there is already an axis with the name \"{}\"", axis.name));
            }
            let numbered =
                |other: &&Axis| other.coupling.number.is_some() && other.coupling.number == axis.coupling.number;
            if let Some(other) = axes.iter().find(numbered) {
                row.error("number", format!("axis {} has that number already", other.name));
            }
            if !data.iter().any(|row| row.enable && row.id == axis.data) {
                let id = ident::data_facts(axis.data).map_or("", |facts| facts.name);
                let text = format!("no word can move axis {}: no row of [[data]] has {id}", axis.name);
                names.check.warning(row.place(), text);
            }
            axes.push(axis);
        }
        row.finish();
    }
    axes.into_iter().collect()
}

fn read_row(row: &mut TableReader<'_>, names: &NameRegistry<'_>) -> Option<Axis> {
    row.require("name", "a name that no other axis of the machine has (X, X2, C1)");
    let name = row.name("name", 16);
    let bare = name.map(|name| name.trim_end_matches(|c: char| c.is_ascii_digit()));
    let letter = row.name("letter", 8).or(bare.filter(|bare| !bare.is_empty()).or(name));
    let data = axis_data(row, letter, names);
    let role = role(row).or(data.map(defaults::role)).unwrap_or(AxisRole::Linear);
    let diameter = row.flag("diameter").unwrap_or(false);
    if diameter && role.is_rotary() {
        row.error("diameter", "a rotary axis has no diameter");
    }
    row.require("rapid", "the rapid rate per minute");
    let rapid = row.above_zero("rapid").unwrap_or(1.0);
    let dynamics = dynamics(row);
    let home = row.number("home").unwrap_or(0.0);
    let positioning = positioning(row);
    if positioning.part_zero != 0.0 && role.is_rotary() {
        row.error("part_zero", "a rotary axis has no part zero");
    }
    let limits = limits(row, home);
    let (vector, center) = super::kinematics::read_axis(row, data, role);
    let turns = [
        ("position", RotaryPositioning::Position),
        ("shortest", RotaryPositioning::Shortest),
        ("sign", RotaryPositioning::Sign),
    ];
    let turn = row.choice("turn", &turns).unwrap_or(RotaryPositioning::Position);
    if turn != RotaryPositioning::Position && !role.is_rotary() {
        row.error("turn", "only a rotary axis takes the shortest way or the direction of a sign");
    }
    let master = row.integer("master", 1..=99).map(|number| number as u16);
    let coupling = AxisCoupling {
        number: row.integer("number", 1..=HIGHEST).map(|number| number as u16),
        mirrored: row.flag("mirrored").unwrap_or(false),
    };
    if coupling.mirrored && coupling.number.is_none() {
        row.error("mirrored", "`mirrored` is for axes that programs couple: the axis needs a `number`");
    }
    Some(Axis {
        name: name?.to_owned(),
        letter: letter?.to_owned(),
        data: data?,
        role,
        diameter,
        rapid,
        dynamics,
        home,
        positioning,
        limits,
        vector,
        center,
        turn,
        master,
        coupling,
    })
}

/// How fast the speed changes. Jerk and corners mean nothing where speeds change at once.
fn dynamics(row: &mut TableReader<'_>) -> Dynamics {
    let acceleration = row.above_zero("acceleration");
    let dynamics =
        Dynamics { acceleration, jerk: row.above_zero("jerk"), corner_speed: row.above_zero("corner_speed") };
    for (key, given) in [("jerk", dynamics.jerk.is_some()), ("corner_speed", dynamics.corner_speed.is_some())] {
        if given && acceleration.is_none() {
            row.error(key, format!("`{key}` needs the `acceleration` of the axis"));
        }
    }
    dynamics
}

fn axis_data(row: &mut TableReader<'_>, letter: Option<&str>, names: &NameRegistry<'_>) -> Option<DataId> {
    let Some(name) = row.text("data") else {
        let data = letter.and_then(defaults::axis_data);
        if letter.is_some() && data.is_none() {
            row.error("name", "[[axes]] needs `data` (REG_AXIS_…): the name alone does not say which axis it is");
        }
        return data;
    };
    let id = names.data(name, row.place_of("data"))?;
    if !id.kind().is_axis() {
        row.error("data", format!("`data` must be an axis identifier (REG_AXIS_…), not {name}"));
        return None;
    }
    Some(id)
}

fn role(row: &mut TableReader<'_>) -> Option<AxisRole> {
    let words = [
        ("X", AxisRole::X),
        ("Y", AxisRole::Y),
        ("Z", AxisRole::Z),
        ("linear", AxisRole::Linear),
        ("rotary", AxisRole::Rotary),
    ];
    row.choice("role", &words)
}

fn positioning(row: &mut TableReader<'_>) -> ReferencePoints {
    let points = row.numbers("references", 0..=3).unwrap_or_default();
    let mut points = points.into_iter();
    ReferencePoints {
        part_zero: row.number("part_zero").unwrap_or(0.0),
        references: [points.next(), points.next(), points.next()],
        floating: row.number("floating"),
        one_way: row.number("one_way").unwrap_or(0.0),
        stop: FixedStop::default(),
    }
}

fn limits(row: &mut TableReader<'_>, home: f64) -> Option<(f64, f64)> {
    let limits = row.numbers("limits", 2..=2)?;
    let [low, high] = limits.as_slice() else { return None };
    if low >= high {
        row.error("limits", format!("`limits` must be the smaller and the larger one, not {low} and {high}"));
        return None;
    }
    if !(*low..=*high).contains(&home) {
        row.error("limits", format!("`home` {home} is outside the limits {low} to {high}"));
    }
    Some((*low, *high))
}
