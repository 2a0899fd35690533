//! Arcs in space, by a point on their way.
//!
//! Facts: reference control-emulator.md 6.1 (through-point arc). Decision: the point is read as the end is: by position
//! mode, diameters on a diameter axis; an omitted coordinate is that of the start.

use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::axis_rates::at_rates;
use counterpoint_channel::modal::group;
use counterpoint_event::event::{Motion, MotionKind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::space::SpaceArc;
use counterpoint_results::geometry::spatial;

use super::check_radius;
use crate::context::{ActionContext, StraightSteps};
use crate::motion::moved_axes;
use crate::time::feed_seconds;
use counterpoint_channel::timed_path::TimedPath;

/// An arc by way of a point.
pub(crate) fn through(act: &mut ActionContext<'_, '_>) -> Acted {
    let (feed, unit) = act.active_feed();
    let (coded, target) = act.targets();
    let (said, via) = way_point(act);
    if coded == 0 && said == 0 {
        return Ok(());
    }
    if said == 0 {
        let text =
            format!("an arc in space needs a point on its way in '{}', it is straight", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return act.feed_to(coded, target, feed, unit);
    }
    if act.channel().state.place.polar().is_some() {
        let done = act.channel().becomes(&diag::ARC_PLANE, STRAIGHT);
        let text = format!(
            "an arc in space is not possible under polar interpolation in '{}', {done}",
            act.channel().block_text()
        );
        act.diagnose(&diag::ARC_PLANE, text);
        return act.feed_to(coded, target, feed, unit);
    }
    let via = act.channel_mut().state.place.work_point(&via);
    crate::cutter::to_contour(act, feed, unit)?;
    let from = act.channel().state.place.position;
    let info = act.channel().env.info;
    let axes = info.channel(act.channel().at.channel).map_or(&[][..], |channel| channel.axes.as_slice());
    let seen = spatial(axes);
    let [start, middle, end] = [from, via, target].map(|position| seen.point(&position));
    let circle = match SpaceArc::through(start, middle, end) {
        Ok(circle) => circle,
        Err(error) => {
            let done = act.channel().becomes(&diag::ARC_RADIUS, STRAIGHT);
            let text = format!("the arc cannot be made: {error} in '{}', {done}", act.channel().block_text());
            act.diagnose(&diag::ARC_RADIUS, text);
            return act.feed_to(coded, target, feed, unit);
        }
    };
    check_radius(act, circle.radius);
    let changes = act.channel().state.place.changes(&from, &target);
    let others = changes.iter().zip(&act.channel().state.place.layout.axes).enumerate();
    let rise: f64 = others.filter(|(at, (_, a))| !a.rotary && !seen.has(*at)).map(|(_, (c, _))| c * c).sum();
    // X swings as it would on a flat arc of its own reach.
    let (center, reach, start_angle) = circle.swing(0);
    let flat = PlaneArc { center: [center, 0.0], radius: reach, start_angle, sweep: circle.sweep };
    let path = TimedPath {
        from: &from,
        to: &target,
        length: circle.length(),
        arc: (reach > 1e-9).then_some((&flat, Some(0))),
    };
    let seconds = feed_seconds(act, &path, feed, unit)?;
    let seconds = at_rates(act.channel(), seconds, &from, &target, None);
    let swings = (0..3).filter(|&side| circle.swing(side).1 > 1e-9).filter_map(|side| seen.axis(side));
    let motion = Motion {
        kind: MotionKind::ArcSpace,
        moving: swings.fold(moved_axes(act.channel(), coded, &changes), |bits, axis| bits | 1 << axis),
        from,
        to: target,
        center: circle.bulge(start, end),
        plane_axes: [255; 2],
        turns: 0,
        feed: feed.unwrap_or(0.0),
        feed_unit: unit,
        length: (circle.length() * circle.length() + rise).sqrt(),
    };
    act.travel(seconds, &motion)?;
    crate::cutter::after_thread(act);
    Ok(())
}

/// Takes the point on the way: bits of the given coordinates, and the point.
fn way_point(act: &mut ActionContext<'_, '_>) -> (u8, Position) {
    let relative = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    let (mut said, mut via) = (0, act.channel().state.place.programmed());
    for (role, id) in [data::ARC_3D_POINT_X, data::ARC_3D_POINT_Y, data::ARC_3D_POINT_Z].into_iter().enumerate() {
        let Some(datum) = act.take(id) else { continue };
        let Some(axis) = act.channel().state.place.layout.cartesian.get(role).copied().flatten() else {
            let text = format!(
                "channel {} has no axis for a word of '{}'",
                act.channel().at.channel,
                act.channel().block_text()
            );
            act.diagnose(&diag::AXIS_NOT_IN_CHANNEL, text);
            continue;
        };
        let shift = act.channel().shift_in_machine_frame(axis);
        let slot = via.at_mut(axis);
        *slot = if datum.incremental || relative && !datum.absolute {
            *slot + datum.value
        } else if act.channel().block.flags.machine_frame {
            datum.value - shift
        } else {
            datum.value
        };
        said |= 1 << role;
    }
    (said, via)
}
