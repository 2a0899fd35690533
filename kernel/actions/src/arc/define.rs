//! Codes that define circles for other blocks: centre, radius, direction.
//!
//! Facts: reference control-emulator.md 6.1 (definition form as a code, direction as a separate code). Decisions: a
//! defined centre is a point and stays until another definition; a code of circles without a direction looks for one in
//! its block, then takes the last one.

use crate::context::ActionContext;
use counterpoint_channel::modal::group;
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::arc::{ArcDefinition, ArcForm};
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::DistanceMode;

/// Direction of a circle: that of its code, of another code in the block, or the last one.
pub(crate) fn direction(act: &mut ActionContext<'_, '_>, form: ArcForm) -> Option<bool> {
    let machine = act.channel().env.machine;
    let on_block = || {
        let ids = act.channel().block.pending.iter().map(|code| &machine.codes[code.row]);
        ids.map(|row| row.id).find_map(|id| match id {
            codes::INTERP_DEF_CLW => Some(true),
            codes::INTERP_DEF_CCLW => Some(false),
            _ => None,
        })
    };
    let clockwise = form.clockwise.or_else(on_block).or(act.channel().state.arcs.clockwise);
    act.channel_mut().state.arcs.clockwise = clockwise;
    clockwise
}

/// Takes a coordinate of a centre, as a radius value in the work frame.
pub(crate) fn coordinate(act: &mut ActionContext<'_, '_>, id: DataId, axis: AxisSlot) -> Option<f64> {
    let datum = act.take(id)?;
    let relative = datum.incremental
        || !datum.absolute
            && match act.channel().env.machine.arcs.center {
                DistanceMode::Incremental => true,
                DistanceMode::Absolute => false,
                DistanceMode::Mode => act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE),
            };
    let scale = act.channel().state.place.layout.axes[axis].scale;
    let of = |list: &Position| list.at(axis);
    Some(match relative {
        true => of(&act.channel().state.place.programmed()) * scale + datum.value,
        false => {
            let value = datum.value * act.axis_diameter_factor(axis);
            let shift =
                if act.channel().block.flags.machine_frame { act.channel().shift_in_machine_frame(axis) } else { 0.0 };
            (value - shift) * scale
        }
    })
}

/// A centre for the circles to come; without words only the form of the block's circle.
pub(crate) fn define_center(act: &mut ActionContext<'_, '_>) -> Acted {
    let mut center = [None; 3];
    for (role, id) in [data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z].into_iter().enumerate() {
        let axis = act.channel().state.place.layout.cartesian.get(role).copied().flatten();
        let value = match axis {
            Some(axis) => coordinate(act, id, axis),
            None => not_here(act, id),
        };
        if let Some(slot) = center.get_mut(role) {
            *slot = value;
        }
    }
    if center.iter().any(Option::is_some) {
        act.channel_mut().state.arcs.center = center;
        act.channel_mut().state.arcs.radius = None;
    }
    (act.channel_mut().state.arcs.by, act.channel_mut().state.arcs.block) =
        (ArcDefinition::Center, act.channel().at.blocks);
    Ok(())
}

fn not_here(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<f64> {
    if act.take(id).is_some() {
        let text =
            format!("channel {} has no axis for a word of '{}'", act.channel().at.channel, act.channel().block_text());
        act.diagnose(&diag::AXIS_NOT_IN_CHANNEL, text);
    }
    None
}

/// A radius for the circles to come; without a word only the form of the block's circle.
pub(crate) fn define_radius(act: &mut ActionContext<'_, '_>) -> Acted {
    if let Some(radius) = act.take(data::ARC_RADIUS) {
        act.channel_mut().state.arcs.radius = Some(radius.value);
        act.channel_mut().state.arcs.center = [None; 3];
    }
    (act.channel_mut().state.arcs.by, act.channel_mut().state.arcs.block) =
        (ArcDefinition::Radius, act.channel().at.blocks);
    Ok(())
}

/// A direction for circles whose code has none.
pub(crate) fn define_direction(act: &mut ActionContext<'_, '_>, clockwise: bool) -> Acted {
    act.channel_mut().state.arcs.clockwise = Some(clockwise);
    Ok(())
}
