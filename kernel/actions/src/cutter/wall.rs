//! Directions beside the codes of compensation.
//!
//! The code that starts compensation gives the vector at the end of its block. The code that ends it gives the
//! direction of the wall behind the contour. The last move then ends where its offset and the offset of the wall meet.
//!
//! Facts: operator's manuals of Fanuc controls, cutter compensation, cancel with I J K: the intersection counts inside
//! and outside; without one the move ends beside its own end. *Invariant:* no move is made to the wall itself.

use counterpoint_channel::modal::{group, plane};
use counterpoint_channel::plane_points::plane_spot;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::{Element, NOISE, Spot, cross, distance, plus};
use counterpoint_program::block::ContourEnd;

use super::compensated_plane;
use crate::context::ActionContext;
use crate::cutter::moves::next_element;

/// Length of the wall: longer than any tool is wide.
const LONG: f64 = 100_000.0;

/// Sine of the angle below which the wall and the last move count as parallel: they do not meet.
const PARALLEL: f64 = 1e-3;

/// Ends the move that waits at the wall whose direction is in the block.
pub(crate) fn at_wall(act: &mut ActionContext<'_, '_>) -> Acted {
    if !act.channel().env.machine.compensation.wall || act.channel().state.place.polar().is_some() {
        return Ok(());
    }
    // Beside a circle they are its centre.
    if is_round(act) {
        return Ok(());
    }
    let Some((code, axes)) = compensated_plane(act) else { return Ok(()) };
    let Some((from, along)) = direction(act, code, axes) else { return Ok(()) };
    let length = distance(along, [0.0; 2]);
    let Some(cutter) = act.channel_mut().state.place.cutter().filter(|cutter| !cutter.plain) else { return Ok(()) };
    let Some(last) = cutter.waiting.iter_mut().rfind(|waits| waits.element.is_some()) else { return Ok(()) };
    let heading = last.element.as_ref().map_or([0.0; 2], Element::end);
    if length < NOISE || cross(heading, along).abs() < length * PARALLEL {
        return Ok(());
    }
    last.end = ContourEnd::Sharp;
    let to = plus(from, along, LONG / length);
    next_element(act, Some(&Element { from, to, arc: None }))
}

/// The end of the last move in the plane, and the direction from the centre words of the block.
fn direction(act: &mut ActionContext<'_, '_>, code: CodeId, axes: [AxisSlot; 2]) -> Option<(Spot, Spot)> {
    let plane = plane(code)?;
    let words = plane.centers.map(|id| act.take(id).map_or(0.0, |datum| datum.value));
    let contour = act.channel().state.place.contour();
    // The direction is turned and mirrored with the points of the program.
    let mut beside = act.channel().state.place.program_point(&contour);
    for (axis, word) in axes.into_iter().zip(words) {
        let scale = act.channel().state.place.layout.axes[axis].scale;
        *beside.at_mut(axis) += word / scale;
    }
    let beside = act.channel_mut().state.place.work_point_aside(&beside);
    let [from, beside] = [contour, beside].map(|of| plane_spot(act.channel(), &of, axes));
    Some((from, plus(beside, from, -1.0)))
}

/// Ends the move of the block that switches compensation on perpendicular to the direction that the block gives.
pub(crate) fn at_vector(act: &mut ActionContext<'_, '_>, code: CodeId, axes: [AxisSlot; 2]) {
    if !act.channel().env.machine.compensation.vector
        || act.channel().state.place.polar().is_some()
        || !act.has_axis_word()
        || is_round(act)
    {
        return;
    }
    let Some((_, along)) = direction(act, code, axes) else { return };
    let length = distance(along, [0.0; 2]);
    if length > NOISE {
        act.channel_mut().block.flags.end = ContourEnd::Beside(along.map(|part| part / length));
    }
}

/// Whether the centre words belong to a circle of the block.
fn is_round(act: &ActionContext<'_, '_>) -> bool {
    let rows = act.channel().block.pending.iter().map(|pending| &act.channel().env.machine.codes[pending.row]);
    let written = rows.filter(|row| row.group == group::MOTION).map(|row| row.id).next_back();
    let motion = written.or_else(|| act.channel().state.modal.code(group::MOTION));
    !matches!(motion, Some(codes::RAPID | codes::INTERP_LINEAR))
}
