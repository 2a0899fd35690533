//! Lines by their direction: a missing coordinate, or the crossing of two lines.
//!
//! Points are those of the program, in its own frame. *Invariant:* a coordinate that the angle does not determine is
//! reported, never guessed. Facts: reference turning-cycles.md 7.2, siemens-cycles.md (ANG).

use counterpoint_channel::corner::OpenLine;
use counterpoint_channel::modal::group;
use counterpoint_channel::plane_points::{flat, forget_corners, plane_spot, put_flat};
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::{Element, Spot, cross, direction, plus};

use super::words::polar;
use super::{ProgrammedMove, compensated_plane};
use crate::context::ActionContext;
use crate::cutter::keep_back;

/// Sine of the angle below which lines count as parallel: one degree.
const PARALLEL: f64 = 0.017_452;

/// Largest distance of a programmed end from the line of its angle.
const OFF: f64 = 0.01;

/// The programmed end of a line with an angle: coded axes and target.
pub(crate) fn by_angle(act: &mut ActionContext<'_, '_>, coded: u8, mut target: Position) -> (u8, Position) {
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return (coded, target) };
    let (axes, angle) = (cutter.axes, cutter.asked.angle.take());
    let open = cutter.waiting.last().and_then(|waiting| waiting.open);
    if angle.is_none() && open.is_none() {
        return (coded, target);
    }
    let bits = axes.map(AxisSlot::bit);
    let [first, second] = bits.map(|bit| coded & bit != 0);
    let from = act.channel().state.place.programmed();
    let (start, end) = (flat(act.channel(), &from, axes), flat(act.channel(), &target, axes));
    match (open, angle) {
        (Some(open), Some(angle)) if first && second => {
            cross_lines(act, open, (end, direction(angle)), axes);
        }
        (Some(_), _) => {
            let text = format!(
                "the line before '{}' has no end: this block needs an angle and both coordinates of its end",
                act.channel().block_text()
            );
            act.diagnose(&diag::LINE_WITHOUT_END, text);
            forget_corners(act.channel_mut());
        }
        (None, Some(angle)) => {
            let along = direction(angle);
            let way = plus(end, start, -1.0);
            let solved = match (first, second) {
                (false, false) => {
                    let open = OpenLine { from, along };
                    if let Some(cutter) = act.channel_mut().state.place.cutter() {
                        cutter.asked.open = Some(open);
                    }
                    return (coded, target);
                }
                (true, true) => (cross(along, way).abs() <= OFF).then_some(end),
                (true, false) => (along[0].abs() > PARALLEL).then(|| plus(start, along, way[0] / along[0])),
                (false, true) => (along[1].abs() > PARALLEL).then(|| plus(start, along, way[1] / along[1])),
            };
            match solved {
                Some(_) if first && second => {}
                Some(spot) => {
                    let missing = usize::from(first);
                    put_flat(act.channel(), &mut target, (axes, missing), spot);
                    return (coded | bits[0] | bits[1], target);
                }
                None => not_computed(act, "the angle and the coordinates do not give its end"),
            }
        }
        (None, None) => {}
    }
    (coded, target)
}

/// Moves the pole of polar coordinates from a point, by the words of the block.
pub(crate) fn set_pole(act: &mut ActionContext<'_, '_>, from: Position) {
    let Some((_, axes)) = compensated_plane(act) else {
        let text = format!("no plane with both axes is active for the pole of '{}'", act.channel().block_text());
        act.diagnose(&diag::CORNER_REFUSED, text);
        return;
    };
    let mut pole = from;
    for axis in axes {
        let id = act.channel().state.place.layout.axes[axis].data;
        *pole.at_mut(axis) += act.take(id).map_or(0.0, |datum| datum.value);
    }
    if let Some([radius, angle]) = polar(act) {
        let spot = plus(flat(act.channel(), &pole, axes), direction(angle), radius);
        for at in [0, 1] {
            put_flat(act.channel(), &mut pole, (axes, at), spot);
        }
    }
    act.channel_mut().state.arcs.pole = pole;
}

fn not_computed(act: &mut ActionContext<'_, '_>, why: &str) {
    let text = format!("the line of '{}' is not computed: {why}", act.channel().block_text());
    act.diagnose(&diag::LINE_NOT_COMPUTED, text);
}

/// Ends the line that waits where it meets another one.
fn cross_lines(act: &mut ActionContext<'_, '_>, open: OpenLine, (end, along): (Spot, Spot), axes: [AxisSlot; 2]) {
    let relative = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE)
        || act.channel().block.words.iter().any(|word| word.incremental);
    let start = flat(act.channel(), &open.from, axes);
    let by = cross(open.along, along);
    if relative || by.abs() < PARALLEL {
        let why = if relative { "its end is incremental" } else { "it is parallel to the line before it" };
        not_computed(act, why);
        forget_corners(act.channel_mut());
        return;
    }
    let meets = plus(start, open.along, cross(plus(end, start, -1.0), along) / by);
    let mut point = open.from;
    for at in [0, 1] {
        put_flat(act.channel(), &mut point, (axes, at), meets);
    }
    let [from, to] = [open.from, point].map(|programmed| act.channel_mut().state.place.work_point(&programmed));
    let [first, last] = [from, to].map(|work| plane_spot(act.channel(), &work, axes));
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return };
    let Some(waiting) = cutter.waiting.last_mut() else { return };
    waiting.open = None;
    for (slot, value) in waiting.step.to.iter_mut().zip(&to) {
        *slot = *value;
    }
    let element = Element { from: first, to: last, arc: None };
    waiting.element = Some(element).filter(|element| element.length() > 1e-7);
    cutter.contour = to;
}

/// A line without an end waits for the next one.
pub(crate) fn wait_for_end(act: &mut ActionContext<'_, '_>, step: ProgrammedMove) {
    let corner = act.channel_mut().state.place.cutter().and_then(|cutter| cutter.asked.corner.take());
    keep_back(act, step, None, corner);
}
