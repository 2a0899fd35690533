//! What codes say about circles that other blocks make: centre, radius, direction.
//!
//! Facts: reference control-emulator.md 6.1 (definition form as a code, direction as a separate code). Decisions: a
//! defined centre is a point and stays until another definition; a code of circles without a direction looks for one on
//! its block, then takes the last one.

use crate::action::Action;
use crate::channel::Kernel;
use crate::diag;
use crate::machine::ident::kind::arc::{By, Form};
use crate::machine::ident::{DataId, codes, data};
use crate::machine::model::Heights;
use crate::state::modal::group;
use counterpoint_fault::Acted;

/// Direction of a circle: that of its code, of another code on the block, or the last one.
pub(super) fn direction(kernel: &mut Kernel<'_>, form: Form) -> Option<bool> {
    let on_block = || {
        let actions =
            kernel.channel.block.firings.iter().map(|firing| kernel.plan.actions.get(usize::from(firing.row)));
        actions.flatten().find_map(|action| match action {
            Some(Action::ArcDirection(clockwise)) => Some(*clockwise),
            _ => None,
        })
    };
    let clockwise = form.clockwise.or_else(on_block).or(kernel.channel.state.arcs.clockwise);
    kernel.channel.state.arcs.clockwise = clockwise;
    clockwise
}

/// Takes a coordinate of a centre, as a radius value in the work frame.
pub(super) fn coordinate(kernel: &mut Kernel<'_>, id: DataId, axis: usize) -> Option<f64> {
    let datum = kernel.take(id)?;
    let relative = datum.incremental
        || !datum.absolute
            && match kernel.channel.env.machine.arcs.center {
                Heights::Incremental => true,
                Heights::Absolute => false,
                Heights::Mode => kernel.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE),
            };
    let scale = kernel.channel.state.place.axes.get(axis).map_or(1.0, |a| a.scale);
    let of = |list: &[f64]| list.get(axis).copied().unwrap_or(0.0);
    Some(match relative {
        true => of(&kernel.channel.programmed()) * scale + datum.value,
        false => {
            let value = datum.value * kernel.factor_across(axis);
            let shift = if kernel.channel.block.machine_frame { of(&kernel.channel.state.place.shift) } else { 0.0 };
            (value - shift) * scale
        }
    })
}

/// A centre for the circles to come; without words only the form of the block's circle.
pub(crate) fn define_center(kernel: &mut Kernel<'_>) -> Acted {
    let mut center = [None; 3];
    for (role, id) in [data::ARC_CENTER_X, data::ARC_CENTER_Y, data::ARC_CENTER_Z].into_iter().enumerate() {
        let axis = kernel.channel.state.place.cartesian.get(role).copied().flatten();
        let value = match axis {
            Some(axis) => coordinate(kernel, id, usize::from(axis)),
            None => not_here(kernel, id),
        };
        if let Some(slot) = center.get_mut(role) {
            *slot = value;
        }
    }
    if center.iter().any(Option::is_some) {
        kernel.channel.state.arcs.center = center;
        kernel.channel.state.arcs.radius = None;
    }
    (kernel.channel.state.arcs.by, kernel.channel.state.arcs.block) = (By::Center, kernel.channel.at.blocks);
    Ok(())
}

fn not_here(kernel: &mut Kernel<'_>, id: DataId) -> Option<f64> {
    if kernel.take(id).is_some() {
        let text = format!("channel {} has no axis for a word of '{}'", kernel.channel.at.channel, kernel.block_text());
        kernel.diagnose(&diag::AXIS_NOT_IN_CHANNEL, text);
    }
    None
}

/// A radius for the circles to come; without a word only the form of the block's circle.
pub(crate) fn define_radius(kernel: &mut Kernel<'_>) -> Acted {
    if let Some(radius) = kernel.take(data::ARC_RADIUS) {
        kernel.channel.state.arcs.radius = Some(radius.value);
        kernel.channel.state.arcs.center = [None; 3];
    }
    (kernel.channel.state.arcs.by, kernel.channel.state.arcs.block) = (By::Radius, kernel.channel.at.blocks);
    Ok(())
}

/// A direction for circles whose code has none.
pub(crate) fn define_direction(kernel: &mut Kernel<'_>, clockwise: bool) -> Acted {
    kernel.channel.state.arcs.clockwise = Some(clockwise);
    Ok(())
}
