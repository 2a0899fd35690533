//! The tool goes back along its axis.
//!
//! *Invariant:* the path is that of the axes of the machine, regardless of the active frame. Facts: reference
//! heidenhain-cycles.md 6 (M140, MB of PLANE). Decisions: machines/heidenhain-milling/README.md.

use counterpoint_channel::modal::group;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::kinematics::unit;
use counterpoint_motion::frame::plane::UNITS;

use crate::context::{ActionContext, StraightSteps};
use crate::entry::ActionEntry;
use crate::motion::rapid_to;

/// A tool that is beyond the reference point by less than this is at it.
const ROUNDING: f64 = 1e-6;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[ActionEntry::of(&[codes::RETRACT_TOOL], |act, _, _| back(act))];

fn back(act: &mut ActionContext<'_, '_>) -> Acted {
    let rate = rate(act);
    let Some(way) = act.take(data::TILT_RETRACT).map(|datum| datum.value) else {
        let text = format!("the retraction of '{}' has no way, nothing is moved", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    retract(act, way, rate)
}

/// Feed of the block, none where the block or the mode is rapid.
pub(crate) fn rate(act: &mut ActionContext<'_, '_>) -> Rate {
    let rapid = act
        .channel()
        .block
        .pending
        .iter()
        .any(|pending| act.channel().env.machine.codes[pending.row].id == codes::RAPID)
        || act.channel().state.modal.code(group::MOTION) == Some(codes::RAPID);
    if rapid { None } else { Some(act.active_feed()) }
}

/// Direction from the tip to the spindle: that of the head, on a machine without rotary axes the normal of the plane.
fn along(act: &ActionContext<'_, '_>, machine: &Position) -> Option<Point> {
    if !act.channel().can_tilt() {
        let [x, y, z] = UNITS;
        return Some(match act.channel().state.modal.code(group::PLANE) {
            Some(codes::PLANE_ZX) => y,
            Some(codes::PLANE_YZ) => x,
            _ => z,
        });
    }
    let chain = act.channel().chain();
    unit(chain.head(|axis| machine.at(axis)).direction(chain.tool))
}

/// A feed with its unit; a rapid without one.
pub(crate) type Rate = Option<(Option<f64>, FeedUnit)>;

/// A move to a point of the work frame.
pub(crate) fn go(act: &mut ActionContext<'_, '_>, coded: u8, target: Position, rate: Rate) -> Acted {
    match rate {
        None => rapid_to(act, coded, target),
        Some((feed, unit)) => act.feed_to(coded, target, feed, unit),
    }
}

/// Retracts the tool along its axis; below zero up to the reference point of the axis that moves most, unless the tool is
/// beyond that, or to the end of travel.
pub(crate) fn retract(act: &mut ActionContext<'_, '_>, way: f64, rate: Rate) -> Acted {
    let mut machine = act.channel().state.place.machine_point(&act.channel().state.place.position);
    let Some(along) = along(act, &machine) else { return Ok(()) };
    let axes: Vec<(AxisSlot, f64)> = {
        let layout = &act.channel().state.place.layout;
        let of = |(axis, part): (&Option<AxisSlot>, f64)| axis.map(|axis| (axis, part / layout.axes[axis].scale));
        layout.cartesian.iter().zip(along).filter_map(of).filter(|(_, part)| part.abs() > 1e-9).collect()
    };
    let way = if way < 0.0 {
        let of = |(axis, part): &(AxisSlot, f64), end: f64| (end - machine.at(*axis)) / part;
        let ends = axes.iter().filter_map(|one @ (axis, part)| {
            let (low, high) = act.channel().state.place.layout.axes[*axis].limits?;
            Some(of(one, if *part > 0.0 { high } else { low }))
        });
        // The limits of a large machine are beyond the reference point of a smaller one, at which the axis ends.
        let steepest = axes.iter().max_by(|(_, one), (_, other)| one.abs().total_cmp(&other.abs()));
        let home = steepest
            .map(|one| of(one, act.channel().state.place.layout.axes[one.0].home))
            .filter(|way| *way > -ROUNDING);
        ends.chain(home).min_by(f64::total_cmp).unwrap_or(0.0).max(0.0)
    } else {
        way
    };
    for (axis, part) in &axes {
        *machine.at_mut(*axis) += part * way;
    }
    let coded = axes.iter().fold(0, |bits, (axis, _)| bits | axis.bit());
    let target = act.channel().state.place.way_of_machine(&machine);
    go(act, coded, target, rate)
}
