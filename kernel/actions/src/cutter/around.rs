//! Where compensation begins and ends: around the end of a contour (KONT), and in which plane (CUT2DF).
//!
//! Facts: function manual W1, chapter "approach and retraction behaviour": the tangent of the contour at its end
//! divides the plane. If the point is behind this tangent, the line to the point touches the circle of the tool's
//! radius about the end, and the tool goes around as at an outside corner. *Invariant:* in front of the contour nothing
//! here changes the path.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::modal::plane;
use counterpoint_channel::plane_points::spot_of;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_motion::contour::corner::CornerPath;
use counterpoint_motion::contour::element::{Element, NOISE, Spot, cross, distance, plus};

use super::{CutterCompensation, ProgrammedMove};
use crate::context::{ActionContext, AroundSteps};
use crate::cutter::moves::{cutter_offset, make_links};
use crate::cutter::smooth::refuse_way;

/// Compensation is that of the frame, and the local frame tilts its plane.
pub(crate) fn frame_tilts(act: &ActionContext<'_, '_>, plane_code: CodeId) -> bool {
    const PLANE: u16 = 148;
    if act.channel().state.modal.code(PLANE) != Some(codes::COMP_IN_FRAME) {
        return false;
    }
    let Some((frames, plane)) = act.channel().state.place.frames.as_deref().zip(plane(plane_code)) else {
        return false;
    };
    let normal = (0..3).find(|role| *role != plane.first && *role != plane.second).unwrap_or(2);
    let mut along = [0.0; 3];
    if let Some(slot) = along.get_mut(normal) {
        *slot = 1.0;
    }
    let [zero, along] = [[0.0; 3], along].map(|point| frames.local.to_work(point));
    (0..3).zip(zero.iter().zip(along)).any(|(role, (zero, along))| role != normal && (along - zero).abs() > 1e-9)
}

impl AroundSteps for ActionContext<'_, '_> {
    fn around_start(&mut self, element: &Element, next: &Element) -> Result<Option<CornerPath>, diag::Halt> {
        let Some(cutter) = self.channel_mut().state.place.cutter().cloned().filter(|_| goes_around(self.channel()))
        else {
            return Ok(None);
        };
        let (here, corner) = (spot_of(self.channel(), &cutter), element.to);
        let way = plus(corner, here, -1.0);
        if cross(next.start(), way) * cutter.side < NOISE {
            return Ok(None);
        }
        let Some(along) = tangent(self, &cutter, way, cutter.side, 10755)? else { return Ok(None) };
        let offset = cutter_offset(self.channel(), &cutter);
        let first = Element { from: plus(corner, along, -distance(here, corner)), to: corner, arc: None };
        Ok(Some(offset.between(&first, next, here)))
    }
}

/// The way around the end of a contour to a point behind it.
pub(crate) fn around_end(
    act: &mut ActionContext<'_, '_>,
    step: &ProgrammedMove,
    element: &Element,
    end: Option<(Spot, Spot)>,
) -> Acted {
    let Some((cutter, (corner, heading))) =
        act.channel_mut().state.place.cutter().cloned().filter(|_| goes_around(act.channel())).zip(end)
    else {
        return Ok(());
    };
    let way = plus(element.to, corner, -1.0);
    if cross(heading, way) * cutter.side > -NOISE {
        return Ok(());
    }
    let Some(along) = tangent(act, &cutter, way, -cutter.side, 10756)? else { return Ok(()) };
    let next = Element { from: corner, to: plus(corner, along, 1.0), arc: None };
    let links = cutter_offset(act.channel(), &cutter).outside(corner, heading, &next);
    let level = act.channel().state.place.position;
    make_links(act, (step, element), &cutter, &links, level)
}

/// Compensation goes around the ends of contours.
fn goes_around(channel: &ChannelContext<'_>) -> bool {
    const AROUND: u16 = 145;
    channel.state.modal.code(AROUND) == Some(codes::CONTOUR_AROUND)
}

/// Direction of the line over a path beside a corner that stays the radius away from it, turned to a side.
fn tangent(
    act: &mut ActionContext<'_, '_>,
    cutter: &CutterCompensation,
    way: Spot,
    side: f64,
    alarm: u32,
) -> Result<Option<Spot>, diag::Halt> {
    let length = distance(way, [0.0; 2]);
    if length < cutter.radius - NOISE {
        refuse_way(act, "the point behind the contour is nearer to its end than the radius of the tool", alarm)?;
        return Ok(None);
    }
    let turn = side * libm::asin((cutter.radius / length).min(1.0));
    let (sine, cosine) = libm::sincos(turn);
    let [x, y] = way.map(|part| part / length);
    Ok(Some([x * cosine - y * sine, x * sine + y * cosine]))
}
