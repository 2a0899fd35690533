//! Rotary axes in space: `vector` and `center` of `[[axes]]`, and `[kinematics]`.
//!
//! Invariant: a direction is not zero. Facts: reference control-emulator.md 6.8.

use crate::ident::DataId;
use crate::ident::kind::CodeKind;
use crate::ident::kind::data::DataKind;
use crate::index::{AxisId, IdTable};
use crate::model::paths::{DirectionDefault, Kinematics, Tilting};
use crate::model::{Axis, AxisRole, Channel};
use crate::rows::CodeRow;
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;
use counterpoint_motion::frame::kinematics::unit;
use counterpoint_motion::frame::orient::{PairChoice, TurnChoice};

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// Direction of an axis by its data: A, B and C turn about X, Y and Z.
fn usual(data: Option<DataId>) -> [f64; 3] {
    match data.map(DataId::kind) {
        Some(DataKind::Axis('A' | 'a')) => X,
        Some(DataKind::Axis('B' | 'b')) => Y,
        _ => Z,
    }
}

fn three(section: &mut TableReader<'_>, key: &'static str) -> Option<[f64; 3]> {
    section.numbers(key, 3..=3).and_then(|numbers| numbers.try_into().ok())
}

fn direction(section: &mut TableReader<'_>, key: &'static str) -> Option<[f64; 3]> {
    let given = three(section, key)?;
    if unit(given).is_none() {
        section.error(key, format!("`{key}` must be a direction, not [0, 0, 0]"));
        return None;
    }
    Some(given)
}

/// Direction and centre of an axis.
pub(super) fn read_axis(row: &mut TableReader<'_>, data: Option<DataId>, role: AxisRole) -> ([f64; 3], [f64; 3]) {
    let (vector, center) = (direction(row, "vector"), three(row, "center"));
    for (key, given) in [("vector", vector), ("center", center)] {
        if given.is_some() && !role.is_rotary() {
            row.error(key, format!("only a rotary axis has a `{key}`"));
        }
    }
    (vector.unwrap_or_else(|| usual(data)), center.unwrap_or_default())
}

/// Reads `[kinematics]`, and checks that tool tip control is possible where a code can switch it on.
pub(super) fn read(
    top: &mut TableReader<'_>,
    axes: &IdTable<AxisId, Axis>,
    channels: &[Channel],
    codes: &[CodeRow],
    check: &FindingCollector,
) -> Kinematics {
    let mut tool = Z;
    let mut missing = DirectionDefault::Keep;
    let mut tilting = Tilting::default();
    let mut asked = false;
    let place = top.place_of("channels").clone();
    if let Some(mut section) = top.table("kinematics", "[kinematics]") {
        let given = direction(&mut section, "tool");
        missing = section
            .choice("missing", &[("keep", DirectionDefault::Keep), ("zero", DirectionDefault::Zero)])
            .unwrap_or(missing);
        if let Some(mut section) = section.table("tilt", "[kinematics.tilt]") {
            tilting = read_tilting(&mut section);
            section.finish();
        }
        asked = given.is_some();
        tool = given.unwrap_or(Z);
        section.finish();
    }
    let orients = |row: &CodeRow| row.enable && matches!(row.id.kind(), CodeKind::TipFormat(_));
    let controls = |row: &CodeRow| row.enable && row.id.kind() == CodeKind::TipControl;
    if !asked && !codes.iter().any(|row| controls(row) || orients(row)) {
        return Kinematics { tool, missing, tilting };
    }
    // A machine that says nothing about its axes in space has no use for tool tip control.
    let described = |axis: &&Axis| axis.vector != usual(Some(axis.data)) || axis.center != [0.0; 3];
    for channel in channels {
        let own = channel.axes.iter().map(|axis| &axes[*axis]);
        let rotary: Vec<&Axis> = own.filter(|axis| axis.role.is_rotary()).take(2).collect();
        if !asked && !rotary.iter().any(described) {
            continue;
        }
        if let [first, second] = rotary.as_slice()
            && parallel(first.vector, second.vector)
        {
            let text = format!(
                "rotary axes {} and {} of channel {} turn about the same direction, tool tip control is impossible",
                first.name, second.name, channel.number
            );
            check.warning(&place, text);
        }
        if let [only] = rotary.as_slice()
            && codes.iter().any(orients)
            && parallel(only.vector, tool)
        {
            let text = format!(
                "the only rotary axis {} of channel {} turns about the tool, which never tilts",
                only.name, channel.number
            );
            check.warning(&place, text);
        }
    }
    Kinematics { tool, missing, tilting }
}

fn read_tilting(section: &mut TableReader<'_>) -> Tilting {
    let usual = Tilting::default();
    let (turns, ways) = (
        [("nearest", TurnChoice::Nearest), ("half", TurnChoice::Half)],
        [
            ("least", PairChoice::Least),
            ("least-positive", PairChoice::LeastLarger),
            ("axis-by-axis", PairChoice::AxisByAxis),
        ],
    );
    Tilting {
        assumed: section.choice("counts", &[("turned", false), ("defined", true)]).unwrap_or(usual.assumed),
        turns: section.choice("turns", &turns).unwrap_or(usual.turns),
        way: section.choice("way", &ways).unwrap_or(usual.way),
        larger: section.choice("side", &[("sign", false), ("value", true)]).unwrap_or(usual.larger),
        zero: section.choice("free", &[("stays", false), ("zero", true)]).unwrap_or(usual.zero),
        keeps_local: section.choice("local", &[("ends", false), ("stays", true)]).unwrap_or(usual.keeps_local),
    }
}

fn parallel(a: [f64; 3], b: [f64; 3]) -> bool {
    let along: f64 = unit(a).zip(unit(b)).map_or(1.0, |(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum());
    1.0 - along.abs() < 1e-9
}
