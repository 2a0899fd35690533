//! Circles that continue in the direction of the last move.
//!
//! Facts: reference siemens-cycles.md (CT). *Invariant:* a circle that does not exist is reported, and its end reached
//! straight unless the channel stops.

use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::arc::LastMove;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::arc as geometry;
use counterpoint_motion::contour::tangent::Tangent;
use counterpoint_motion::contour::tangent::tangent as leads;

use super::{CircularMove, Flat, active_plane};
use crate::context::{ActionContext, CircleSteps};
use crate::motion::{feed_to_point, programmed_targets};
use crate::turned;

/// A circle to a point, in the direction in which the last move has ended.
pub(crate) fn tangent(act: &mut ActionContext<'_, '_>) -> Acted {
    let (feed, unit) = act.active_feed();
    let (coded, target) = programmed_targets(act);
    if coded == 0 {
        return Ok(());
    }
    let Some((plane, flat)) = active_plane(act) else {
        let text = format!("no plane with both axes is active for '{}'", act.channel().block_text());
        act.diagnose(&diag::ARC_PLANE, text);
        return Ok(());
    };
    let from = act.channel().state.place.programmed();
    let (start, end) = (flat.point(&from), flat.point(&target));
    let leads = heading(act, &flat).map(|heading| leads(start, heading, end));
    let (center, clockwise) = match leads {
        Some(Tangent::Line) => return feed_to_point(act, coded, target, feed, unit),
        Some(Tangent::Arc { center, clockwise, .. }) => (center, clockwise),
        Some(Tangent::Back) | None => {
            let why =
                if leads.is_some() { "its end lies straight behind" } else { "no move of the plane is before it" };
            let done = act.channel().becomes(&diag::TANGENT_IMPOSSIBLE, STRAIGHT);
            let text = format!("the circle of '{}' is not possible: {why}, {done}", act.channel().block_text());
            act.diagnose(&diag::TANGENT_IMPOSSIBLE, text);
            return feed_to_point(act, coded, target, feed, unit);
        }
    };
    let made = match geometry::by_center(start, end, center, clockwise) {
        Ok(made) => made,
        Err(error) => {
            super::not_made(act, error);
            return feed_to_point(act, coded, target, feed, unit);
        }
    };
    let circle = CircularMove { made, coded, from, to: target, axes: flat.axes, turns: 0, feed, unit, screw: None };
    if act.channel().state.place.frames.is_some() {
        turned::circle(act, plane, &circle)
    } else {
        act.circle_to(&circle)
    }
}

/// Direction of the last move at its end, as the program sees it, of length one.
fn heading(act: &ActionContext<'_, '_>, flat: &Flat) -> Option<[f64; 2]> {
    let here = act.channel().state.place.contour();
    let mut ahead = here;
    match act.channel().state.arcs.last? {
        LastMove::By(by) => ahead.iter_mut().zip(by).for_each(|(slot, by)| *slot += by),
        LastMove::Round { axes, center, turn } => {
            let scale = |axis: AxisSlot| act.channel().state.place.layout.axes[axis].scale;
            let [first, second] = axes;
            let [c, d] = center;
            let x = (here.at(first) - c) * scale(first);
            let y = (here.at(second) - d) * scale(second);
            *ahead.at_mut(first) -= y * turn / scale(first);
            *ahead.at_mut(second) += x * turn / scale(second);
        }
    }
    let [from, to] = [here, ahead].map(|work| flat.point(&act.channel().state.place.program_point(&work)));
    let by = [to[0] - from[0], to[1] - from[1]];
    let length = libm::hypot(by[0], by[1]);
    (length > 1e-9).then(|| by.map(|part| part / length))
}
