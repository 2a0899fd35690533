//! Threads along a contour with a name (Okuma G88): the passes that came before its code.
//!
//! Facts: reference okuma-osp.md 4. The tool goes at rapid to the start of the contour, along it first and then across.
//! It cuts each piece at its lead, and returns across and along to its previous position. *Invariant:* all pieces are
//! threads; a pass is the contour moved towards the side from which the tool came.

use counterpoint_channel::thread::Screw;
use counterpoint_channel::turning::LathePlane;
use counterpoint_event::event::FeedUnit;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::data;
use counterpoint_motion::arc as geometry;
use counterpoint_motion::contour::element::{Element, Spot};
use counterpoint_motion::turning::CycleMove;
use counterpoint_motion::turning::MoveSink as _;

use super::moves::{Cutting, round};
use crate::context::ActionContext;
use crate::cutter;
use crate::thread::cut_to_point;
use counterpoint_channel::circular_move::CircularMove;

/// One more pass.
pub(crate) fn pass(act: &mut ActionContext<'_, '_>) {
    let [depth, shift] =
        [data::TURN_PASS_DEPTH, data::TURN_PASS_SHIFT].map(|id| act.take(id).map_or(0.0, |datum| datum.value));
    act.channel_mut().state.others.turning.passes.push([depth, shift]);
}

/// Cuts all passes along the pieces of a contour.
pub(crate) fn cut(
    act: &mut ActionContext<'_, '_>,
    plane: &LathePlane,
    face: bool,
    (start, elements, screws): (Spot, &[Element], &[Option<Screw>]),
) -> Acted {
    let passes = std::mem::take(&mut act.channel_mut().state.others.turning.passes);
    let pieces: Option<Vec<(&Element, Screw)>> =
        elements.iter().zip(screws).map(|(element, screw)| Some((element, (*screw)?))).collect();
    let pieces = pieces.unwrap_or_default();
    let Some(([z, x], last)) = pieces.first().zip(pieces.last()).map(|((first, _), (last, _))| (first.from, last.to))
    else {
        let text =
            format!("the contour of '{}' may have threads only (G34, G35, G112, G113)", act.channel().block_text());
        return Err(act.alarm(&diag::CONTOUR_CODE, text));
    };
    let feed = (None, FeedUnit::PerRevolution);
    let outside = if face { start[0] >= z } else { start[1] >= x };
    let away = if outside { 1.0 } else { -1.0 };
    for [depth, shift] in passes {
        act.count_as_block()?;
        // Both are in the measure of the axis of the depth.
        let [of_z, of_x] = plane.scales;
        let off = if face { [away * depth * of_z, shift * of_z] } else { [shift * of_x, away * depth * of_x] };
        let at = |[a, b]: Spot| [a + off[0], b + off[1]];
        let rapid = |act: &mut ActionContext<'_, '_>, to: Spot| Cutting::new(act, plane, feed).go(CycleMove::Rapid(to));
        let begin = at([z, x]);
        rapid(act, if face { [start[0], begin[1]] } else { [begin[0], start[1]] })?;
        rapid(act, begin)?;
        for (element, screw) in &pieces {
            piece(act, plane, (element, at(element.to)), screw)?;
        }
        let end = at(last);
        rapid(act, if face { [start[0], end[1]] } else { [end[0], start[1]] })?;
        rapid(act, start)?;
    }
    cutter::after_thread(act);
    Ok(())
}

/// One piece of a pass, to its moved end.
fn piece(act: &mut ActionContext<'_, '_>, plane: &LathePlane, (element, to): (&Element, Spot), screw: &Screw) -> Acted {
    let from = act.channel().state.place.programmed();
    let target = plane.position(from, to);
    let coded = plane.moved(&from, &target);
    let Some(arc) = element.arc else { return cut_to_point(act, coded, target, screw) };
    let start = plane.point(&from);
    let center = [0, 1].map(|at: usize| {
        let of = |spot: &Spot| spot.get(at).copied().unwrap_or(0.0);
        of(&arc.center) + of(&start) - of(&element.from)
    });
    match geometry::by_center(start, plane.point(&target), center, arc.sweep < 0.0) {
        Ok(made) => {
            let (feed, unit) = (Some(screw.lead), FeedUnit::PerRevolution);
            let screw = Some(*screw);
            round(act, &CircularMove { made, coded, from, to: target, axes: plane.axes, turns: 0, feed, unit, screw })
        }
        Err(_) => cut_to_point(act, coded, target, screw),
    }
}
