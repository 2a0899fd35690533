//! Cylindrical interpolation: moves on the surface of a cylinder about a rotary axis.
//!
//! Facts: reference turning-cycles.md 10.2, siemens-cycles.md 2. Decisions: docs/emulation.md, "Cylindrical
//! interpolation". *Invariant:* the axes stay where they are when it begins and ends.

use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::AxisSlot;

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use counterpoint_channel::frame_transforms::PolarInterpolation;
use counterpoint_channel::modal::{group, plane};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::CYLINDER_ON], |act, _, _| on(act)),
    ActionEntry::of(&[codes::CYLINDER_MAP], |act, _, _| map(act)),
];

/// Rotary axes of the workpiece, each with the role of the linear axis that it turns about.
const TURNS_ABOUT: [(DataId, usize); 4] =
    [(data::AXIS_CT, 2), (data::AXIS_CT2, 2), (data::AXIS_BT, 1), (data::AXIS_AT, 0)];

/// Switches it on with the radius of the block, or off with radius 0.
fn on(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some((radius, rotary, cartesian)) = radius(act) else {
        let text = format!("'{}' gives no rotary axis and no radius of a cylinder", act.channel().block_text());
        act.diagnose(&diag::NO_CYLINDER, text);
        return Ok(());
    };
    if radius == 0.0 && !cartesian {
        return off(act);
    }
    begin(act, (radius, rotary, cartesian))
}

fn off(act: &mut ActionContext<'_, '_>) -> Acted {
    act.channel_mut().state.modal.activate(group::PART_INTERPOLATION, codes::CYLINDER_OFF, None);
    super::polar::off(act)
}

/// Switches it on for the linear and the rotary axis that the block names, off without any. The radius is that of the
/// block or the last one; without a linear axis the block only gives one.
fn map(act: &mut ActionContext<'_, '_>) -> Acted {
    let radius = act.take(data::CYLINDER_RADIUS).map(|datum| datum.value);
    let mut named = |id| act.channel().state.place.axis_of_data(id).filter(|_| act.take(id).is_some());
    let rotary = TURNS_ABOUT.into_iter().find_map(|(id, role)| Some((named(id)?, role)));
    let [x, y, z] = [data::AXIS_X, data::AXIS_Y, data::AXIS_Z].map(|id| named(id).is_some());
    if radius.is_none() && rotary.is_none() && !(x || y || z) {
        return off(act);
    }
    if let Some(radius) = radius.filter(|radius| *radius != 0.0) {
        act.channel_mut().state.others.cylinder = Some(radius);
    }
    if rotary.is_some() && !(x || y || z) {
        return Ok(());
    }
    let known = y && !x && !z && rotary.is_some_and(|(_, role)| role != 1);
    let Some(radius) = act.channel().state.others.cylinder.filter(|_| known) else {
        let text = format!(
            "no cylinder for '{}': only Y is mapped, onto A or C, with a radius of this block or of one before",
            act.channel().block_text()
        );
        act.diagnose(&diag::NO_CYLINDER, text);
        return Ok(());
    };
    // Words that cylindrical interpolation forbids are not forbidden here: its code stays off.
    begin(act, (radius, rotary, true))
}

fn begin(act: &mut ActionContext<'_, '_>, (radius, rotary, cartesian): Given) -> Acted {
    super::polar::not_tilted(act)?;
    let plane = act.channel().state.modal.code(group::PLANE).and_then(plane).map(|plane| [plane.first, plane.second]);
    let found = rotary.filter(|_| radius > 0.0 && radius.is_finite()).and_then(|(axis, role)| {
        let linear = act.channel().state.place.layout.cartesian.get(role).copied().flatten()?;
        // Coordinates are those of the plane whose second axis is the linear one, as Y and Z.
        let round_first =
            if cartesian { role == 2 } else { *plane.filter(|roles| roles.contains(&role))?.last()? == role };
        Some(PolarInterpolation::cylinder([linear, axis], radius, round_first, cartesian))
    });
    let Some(cylinder) = found else {
        let text = format!(
            "no cylinder for '{}': it needs a radius above 0, a rotary axis, the linear axis that it turns about, and a plane with that",
            act.channel().block_text()
        );
        act.diagnose(&diag::NO_CYLINDER, text);
        return Ok(());
    };
    act.channel_mut().state.place.frames().polar = Some(cylinder);
    act.channel_mut().state.place.frames_changed();
    super::cutter::plane_changed(act);
    act.channel_mut().emit(0, Kind::mode(format!("cylinder on r={radius}")));
    Ok(())
}

/// The radius, the rotary axis with the role of its linear axis, and whether words will be coordinates. The radius has
/// a word of its own, or it is the word of the axis.
type Given = (f64, Option<(AxisSlot, usize)>, bool);

fn radius(act: &mut ActionContext<'_, '_>) -> Option<Given> {
    let axes = TURNS_ABOUT.map(|(id, role)| (id, act.channel().state.place.axis_of_data(id).map(|axis| (axis, role))));
    if let Some(radius) = act.take(data::CYLINDER_RADIUS) {
        return Some((radius.value, axes.into_iter().find_map(|(_, axis)| axis), true));
    }
    // A word of an angle has no unit of length, but its value is a radius here.
    let unit = act.channel().unit_factor(Dimension::Length);
    let mut named = axes.into_iter().filter(|(_, axis)| axis.is_some());
    named.find_map(|(id, axis)| Some((act.take(id)?.value * unit, axis, false)))
}
