//! Circles under a local frame.
//!
//! A circle that stays one in a plane of two axes is made as such, with the direction and radius that it has there; one
//! that leans between the axes goes in straight pieces. Facts: reference control-emulator.md 6.7. Decision: unequal
//! scales in the plane do not give a circle: that is reported, and the end is reached straight.

use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::modal::Plane;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_event::info::MachineUnit;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::index::BySlot;
use counterpoint_motion::arc as geometry;
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::circle::CircleSides;
use nalgebra::Vector3;

use crate::context::{ActionContext, CircleSteps};
use crate::motion::feed_to_point;
use counterpoint_channel::circular_move::CircularMove;

/// Most straight pieces of a circle.
const MOST_PIECES: f64 = 20_000.0;

/// Makes a circle whose points are those of the program.
pub(crate) fn circle(act: &mut ActionContext<'_, '_>, plane: Plane, circle: &CircularMove) -> Acted {
    let map = act.channel().state.place.frames.as_deref().map_or(Affine::SAME, |frames| *frames.local.map());
    let Some(sides) = CircleSides::under(&map, [plane.first, plane.second]) else {
        let done = act.channel().becomes(&diag::ARC_SCALED, STRAIGHT);
        let text = format!("the circle of '{}' is under unequal scale factors, {done}", act.channel().block_text());
        act.diagnose(&diag::ARC_SCALED, text);
        return feed_to_point(act, circle.coded, circle.to, circle.feed, circle.unit);
    };
    let work = act.channel().state.place.contour();
    match sides.roles() {
        Some(roles) => flat(act, &map, (plane, roles), (circle, sides.scale), work),
        None => leaning(act, plane, circle, sides.scale),
    }
}

/// A circle that lies in the plane of two axes.
fn flat(
    act: &mut ActionContext<'_, '_>,
    map: &Affine,
    (plane, roles): (Plane, [usize; 2]),
    (circle, scale): (&CircularMove, f64),
    from: Position,
) -> Acted {
    let axes = roles.map(|role| act.channel().state.place.layout.cartesian.get(role).copied().flatten());
    let [Some(first), Some(second)] = axes else { return Ok(()) };
    let to = act.channel_mut().state.place.work_point(&circle.to);
    let mut middle = act.channel().state.place.geometry(&circle.from);
    for (role, value) in [plane.first, plane.second].into_iter().zip(circle.made.center) {
        if let Some(slot) = middle.get_mut(role) {
            *slot = value;
        }
    }
    let pick = |point: Point| roles.map(|role| point.get(role).copied().unwrap_or(0.0));
    let center = pick(map.point(middle));
    let start = pick(act.channel().state.place.geometry(&from));
    // The other way round where the frame mirrors the plane.
    let unit = |role: usize| pick(map.direction(Vector3::ith(role, 1.0).into()));
    let ([a, b], [c, d]) = (unit(plane.first), unit(plane.second));
    let sweep = if a * d - b * c < 0.0 { -circle.made.sweep } else { circle.made.sweep };
    let made = geometry::PlaneArc {
        center,
        radius: circle.made.radius * scale,
        start_angle: libm::atan2(start[1] - center[1], start[0] - center[0]),
        sweep,
    };
    act.circle_to(&CircularMove { made, from, to, axes: [first, second], ..*circle })
}

/// A circle between the axes, in straight pieces that stay near to it.
fn leaning(act: &mut ActionContext<'_, '_>, plane: Plane, circle: &CircularMove, scale: f64) -> Acted {
    let near = match act.channel().env.machine.unit {
        MachineUnit::Mm => 0.001,
        MachineUnit::Inch => 0.001 / 25.4,
    };
    let made = &circle.made;
    let step = 2.0 * libm::acos((1.0 - near / (made.radius * scale)).clamp(-1.0, 1.0));
    let pieces = (made.sweep.abs() / step.max(1e-6)).ceil().clamp(1.0, MOST_PIECES);
    let count = pieces as u32;
    // Inverse time is that of the whole circle.
    let feed = if circle.unit == FeedUnit::InverseTime { circle.feed.map(|f| f * pieces) } else { circle.feed };
    for piece in 1..count {
        let share = f64::from(piece) / pieces;
        let mut target = circle.from;
        for (slot, to) in target.iter_mut().zip(circle.to) {
            *slot += (to - *slot) * share;
        }
        let angle = made.start_angle + made.sweep * share;
        let at = [made.center[0] + made.radius * libm::cos(angle), made.center[1] + made.radius * libm::sin(angle)];
        for ((axis, value), role) in circle.axes.into_iter().zip(at).zip([plane.first, plane.second]) {
            *target.at_mut(axis) = value / act.channel().state.place.scale_of(role);
        }
        feed_to_point(act, circle.coded, target, feed, circle.unit)?;
    }
    feed_to_point(act, circle.coded, circle.to, feed, circle.unit)
}
