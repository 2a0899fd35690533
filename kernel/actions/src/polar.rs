//! Polar interpolation: its codes, its words, and circles on the part, those of a cylinder too.
//!
//! Facts: reference control-emulator.md 6.8. Decisions: docs/emulation.md, "Polar interpolation" and "Cylindrical
//! interpolation". *Invariant:* events name the real axes; length and time are those on the part.

use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::axis_rates::at_rates;
use counterpoint_channel::frame_transforms::PolarInterpolation;
use counterpoint_channel::modal::{group, plane};
use counterpoint_channel::round_centre::way_round;
use counterpoint_event::event::{Kind, Motion, MotionKind};
use counterpoint_event::info::MachineUnit;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::arc as geometry;

use crate::context::{ActionContext, CircleSteps, StraightSteps};
use crate::entry::ActionEntry;
use crate::motion::{moved_axes, programmed_targets};
use crate::time::feed_seconds;
use counterpoint_channel::circular_move::CircularMove;
use counterpoint_channel::timed_path::TimedPath;
use counterpoint_motion::frame::circle::circle_in_plane;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::C2P_CART_ON], |act, _, _| on(act, true)),
    ActionEntry::of(&[codes::C2P_POLAR_ON], |act, _, _| on(act, false)),
    ActionEntry::of(&[codes::C2P_CART_OFF, codes::C2P_POLAR_OFF, codes::CYLINDER_OFF], |act, _, _| off(act)),
];

/// Switches it on: words are coordinates, or radius and angle.
pub(crate) fn on(act: &mut ActionContext<'_, '_>, cartesian: bool) -> Acted {
    if act.channel().state.place.polar().is_some_and(|polar| polar.cartesian == cartesian && !polar.is_cylinder()) {
        return Ok(());
    }
    not_tilted(act)?;
    let Some((linear, rotary)) = axes(act) else {
        let text = format!(
            "channel {} has no linear and rotary axis for polar interpolation of '{}'",
            act.channel().at.channel,
            act.channel().block_text()
        );
        act.diagnose(&diag::NO_POLAR_AXES, text);
        return Ok(());
    };
    act.channel_mut().state.place.frames().polar =
        Some(PolarInterpolation::new(&act.channel().state.place, linear, rotary, cartesian));
    act.channel_mut().state.place.frames_changed();
    super::cutter::plane_changed(act);
    act.channel_mut().emit(0, Kind::mode(format!("c2p {} on", form(cartesian))));
    Ok(())
}

/// In a tilted plane the linear axes follow the part, not the words one by one.
pub(crate) fn not_tilted(act: &mut ActionContext<'_, '_>) -> Acted {
    if act.channel().state.place.tilted().is_none() {
        return Ok(());
    }
    let text = format!("'{}' is not possible in a tilted plane", act.channel().block_text());
    Err(act.alarm(&diag::NO_POLAR_AXES, text))
}

/// Switches it off, that of a cylinder too; the axes stay where they are.
pub(crate) fn off(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(polar) = act.channel_mut().state.place.frames.as_deref_mut().and_then(|frames| frames.polar.take()) else {
        return Ok(());
    };
    act.channel_mut().state.place.frames_changed();
    super::cutter::plane_changed(act);
    let text =
        if polar.is_cylinder() { "cylinder off".to_owned() } else { format!("c2p {} off", form(polar.cartesian)) };
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}

fn form(cartesian: bool) -> &'static str {
    if cartesian { "cart" } else { "polar" }
}

/// The axes that the machine names for it, otherwise X and the first rotary axis of the workpiece.
fn axes(act: &ActionContext<'_, '_>) -> Option<(AxisSlot, AxisSlot)> {
    let channel =
        act.channel().env.machine.channels.iter().find(|channel| channel.number == act.channel().at.channel)?;
    if let Some([linear, rotary]) = channel.polar {
        return Some((linear, rotary));
    }
    let tables = [data::AXIS_CT, data::AXIS_CT2, data::AXIS_BT, data::AXIS_AT];
    let rotary = tables.into_iter().find_map(|id| act.channel().state.place.axis_of_data(id))?;
    Some((act.channel().state.place.layout.cartesian.first().copied().flatten()?, rotary))
}

/// A circle on the part. Its plane is that of the part, regardless of the active plane.
pub(crate) fn arc(act: &mut ActionContext<'_, '_>, polar: PolarInterpolation, clockwise: bool) -> Acted {
    let (feed, unit) = act.active_feed();
    let (coded, target) = programmed_targets(act);
    let radius = act.take(data::ARC_RADIUS).map(|d| d.value);
    let offsets = center_words(act, &polar).map(|id| id.and_then(|id| act.take(id)).map(|d| d.value));
    let turns = act.take(data::ARC_TURNS).map_or(0.0, |d| d.value);
    if coded == 0 && radius.is_none() && offsets.iter().all(Option::is_none) {
        return Ok(());
    }
    let (from, programmed) = (act.channel().state.place.contour(), act.channel().state.place.programmed());
    let mut to = act.channel_mut().state.place.work_point(&target);
    // Words that are coordinates tell a circle of the local frame.
    let spots = if polar.cartesian && !polar.is_cylinder() {
        [&programmed, &target].map(|point| act.channel().state.place.seen(point)).map(|[x, y, _]| [x, y])
    } else {
        [&from, &to].map(|point| polar.part(&act.channel().state.place, point))
    };
    let [start, end] = spots;
    let tolerance = if act.channel().env.machine.unit == MachineUnit::Inch { 0.01 / 25.4 } else { 0.01 };
    let made = match radius {
        Some(radius) => geometry::by_radius(start, end, radius, clockwise, tolerance),
        None => {
            let [i, j] = offsets.map(|offset| offset.unwrap_or(0.0));
            geometry::by_center(start, end, [start[0] + i, start[1] + j], clockwise)
        }
    };
    let made = match made {
        Ok(made) => made,
        Err(error) => {
            super::circular_move::not_made(act, error);
            return act.feed_to(coded, to, feed, unit);
        }
    };
    let off = made.end_error(end);
    if radius.is_none() && off > tolerance {
        let text = format!("the end is {off:.4} off the circle in '{}'", act.channel().block_text());
        act.diagnose(&diag::ARC_END_OFF, text);
    }
    let local =
        act.channel().state.place.frames.as_deref().filter(|_| polar.cartesian).map(|frames| *frames.local.map());
    if polar.is_cylinder() && !(local.is_none_or(|map| map.is_shift()) && in_plane(act, &polar)) {
        let text = format!(
            "the circle of '{}' is not in the plane of the cylinder's surface, or a frame turns, scales or mirrors it",
            act.channel().block_text()
        );
        act.diagnose(&diag::ARC_ON_CYLINDER, text);
        return Ok(());
    }
    let local = local.filter(|_| !polar.is_cylinder());
    let level = act.channel().state.place.seen(&programmed)[2];
    let Some(made) = local.map_or(Some(made), |map| circle_in_plane(&map, made, level)) else {
        let done = act.channel().becomes(&diag::ARC_SCALED, STRAIGHT);
        let text = format!("the circle of '{}' is under unequal scale factors, {done}", act.channel().block_text());
        act.diagnose(&diag::ARC_SCALED, text);
        return act.feed_to(coded, to, feed, unit);
    };
    let turns = if (0.0..=999.0).contains(&turns) { turns as u16 } else { 0 };
    let made = made.with_turns(turns);
    let spot = polar.part(&act.channel().state.place, &to);
    polar.reach(&act.channel().state.place, &mut to, spot, way_round(&made));
    act.circle_to(&CircularMove { made, coded, from, to, axes: polar.axes(), turns, feed, unit, screw: None })
}

/// The words of the centre of a circle, in the order of the plane. A cylinder whose words are those of its axes has
/// none: its circles have a radius.
fn center_words(act: &ActionContext<'_, '_>, polar: &PolarInterpolation) -> [Option<DataId>; 2] {
    if !polar.is_cylinder() {
        return [Some(data::ARC_CENTER_X), Some(data::ARC_CENTER_Y)];
    }
    let [x, _, z] = act.channel().state.place.layout.cartesian;
    let id = |axis| match Some(axis) {
        axis if axis == x => data::ARC_CENTER_X,
        axis if axis == z => data::ARC_CENTER_Z,
        // The way round counts as Y.
        _ => data::ARC_CENTER_Y,
    };
    polar.axes().map(|axis| polar.cartesian.then_some(id(axis)))
}

/// A circle of the part from where the axes are, which `circle.to` has gone round already.
#[cold]
pub(crate) fn circle_of_part(
    act: &mut ActionContext<'_, '_>,
    polar: PolarInterpolation,
    circle: &CircularMove,
) -> Acted {
    let CircularMove { made, coded, from, to, feed, unit, .. } = *circle;
    let changes = act.channel().feed_changes(&from, &to);
    let others =
        act.channel().state.place.layout.axes.ids().filter(|axis| *axis != polar.linear && *axis != polar.rotary);
    let rise = others.map(|axis| changes.at(axis) * changes.at(axis)).sum::<f64>();
    let length = (made.length() * made.length() + rise).sqrt();
    let path = TimedPath { from: &from, to: &to, length: made.length(), arc: None };
    let seconds = feed_seconds(act, &path, feed, unit)?;
    let seconds = at_rates(act.channel(), seconds, &from, &to, Some(&made));
    let moving = moved_axes(act.channel(), coded, &act.channel().state.place.changes(&from, &to))
        | polar.linear.bit()
        | polar.rotary.bit();
    let feed = (feed.unwrap_or(0.0), unit);
    if polar.is_cylinder() {
        let side = usize::from(polar.axes()[1] == polar.linear);
        act.check_swing(&to, polar.linear, made.turning_points(side))?;
    }
    let mut motion = Motion::straight(MotionKind::Linear, moving, [from, to], feed, length);
    if let Some(center) = polar.on_face(&act.channel().state.place, made.center) {
        (motion.center, motion.plane_axes) = (center, [polar.linear, polar.rotary].map(|axis| axis.index() as u8));
    }
    act.travel(seconds, &motion)
}

/// Whether the active plane is that of the surface. One whose words are those of its axes began in that plane.
pub(crate) fn in_plane(act: &ActionContext<'_, '_>, polar: &PolarInterpolation) -> bool {
    let Some(plane) = act.channel().state.modal.code(group::PLANE).and_then(plane) else { return false };
    let role = |axis: AxisSlot| {
        let y = if axis == polar.rotary { Some(1) } else { None };
        y.or_else(|| act.channel().state.place.layout.cartesian.iter().position(|own| *own == Some(axis)))
    };
    !polar.cartesian || polar.axes().map(role) == [Some(plane.first), Some(plane.second)]
}
