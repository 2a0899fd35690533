//! Soft approach to a contour and retraction from it: a line or a part of a circle that is tangent to the contour, and
//! the path between it and the tool.
//!
//! P0 is the position from which the tool comes, P1 above P3 at the height of P0, P2 the end of the quick descent, P3
//! the start of the line or circle, P4 the contour; the path from the contour goes through them backwards. Facts:
//! programming manual, fundamentals, and function manual W1, chapter "smooth approach and retraction"; the points are
//! those of the tool's centre. *Invariant:* along the tool the path never turns back; a path that would is refused
//! before anything moves. Decisions: docs/emulation.md, "Cutter radius".

use std::f64::consts::PI;

use counterpoint_channel::arc::LastMove;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::modal::{feed_of, group, plane};
use counterpoint_channel::plane_points::{plane_spot, position_at, position_round, radial, spot_of};
use counterpoint_channel::smooth::{ApproachForm, ApproachSpeed, Lies, Smooth, ToolHeight};
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::contour::element::{Element, NOISE, Spot, angle, cross, distance, plus};

use super::{CompensationStage, CutterCompensation, MoveShape, ProgrammedMove, WaitingMove, corner};
use crate::context::{ActionContext, ApproachSteps};
use crate::cutter::keep_back;
use crate::cutter::moves::{cutter_offset, go_round, straight};
use crate::entry::{ActionEntry, CompensationEffect};
use crate::time::check_feed;
use counterpoint_channel::circular_move::CircularMove;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::SMOOTH_LINE_IN], |act, _, _| asked(act, ApproachForm::Line, false))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::SMOOTH_QUARTER_IN], |act, _, _| asked(act, ApproachForm::Quarter, false))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::SMOOTH_HALF_IN], |act, _, _| asked(act, ApproachForm::Half, false))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::SMOOTH_LINE_OUT], |act, _, _| asked(act, ApproachForm::Line, true))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::SMOOTH_QUARTER_OUT], |act, _, _| asked(act, ApproachForm::Quarter, true))
        .contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::SMOOTH_HALF_OUT], |act, _, _| asked(act, ApproachForm::Half, true))
        .contour(CompensationEffect::Waits),
];

/// Blocks without motion in the plane between the path and the contour (MD20202).
pub(crate) const LOOKED_THROUGH: u32 = 5;

/// Length by which the path along the tool may turn back (MD20204).
const TOLERANCE: f64 = 0.01;

/// A block asks for a path.
fn asked(act: &mut ActionContext<'_, '_>, form: ApproachForm, leaves: bool) -> Acted {
    act.flush_lookahead()?;
    if !corner::take_part(act) {
        return act.channel().check_stop();
    }
    let before = speed_before(act);
    let (id, unit) = feed_of(act.channel().state.modal.code(group::FEED));
    let own = if unit != FeedUnit::InverseTime && act.block_has(id) {
        let (feed, unit) = act.active_feed();
        Some(ApproachSpeed::Feed(feed, unit))
    } else {
        None
    };
    let feed = ApproachSpeed::Feed(act.channel().state.remembered.value(id), unit);
    let slow = [
        (data::SMOOTH_FEED, unit),
        (data::SMOOTH_FEED_UPM, FeedUnit::PerMinute),
        (data::SMOOTH_FEED_UPR, FeedUnit::PerRevolution),
    ];
    let slow = slow.map(|(id, unit)| act.take(id).map(|datum| ApproachSpeed::Feed(Some(datum.value), unit)));
    let level = level_of(act, [data::SMOOTH_LEVEL, data::SMOOTH_LEVEL_AT]);
    let retraction = level_of(act, [data::SMOOTH_RETRACTION, data::SMOOTH_RETRACTION_AT]);
    let lies = match act.channel().state.modal.code(LIES) {
        Some(codes::SMOOTH_SIDE_LEFT) => Lies::Left,
        Some(codes::SMOOTH_SIDE_RIGHT) => Lies::Right,
        Some(codes::SMOOTH_SIDE_POINT) => Lies::WithPoint,
        _ => Lies::WithTool,
    };
    let smooth = Smooth {
        leaves,
        form,
        lies,
        in_space: act.channel().state.modal.code(DEPTH) != Some(codes::SMOOTH_IN_PLANE),
        size: act.take(data::SMOOTH_SIZE).map_or(0.0, |datum| datum.value),
        level,
        retraction,
        slow: slow.into_iter().flatten().next(),
        before,
        own,
        feed,
        heading: if leaves { heading(act.channel_mut()) } else { None },
    };
    if act.channel_mut().state.place.cutter().is_some_and(|cutter| cutter.smooth.is_some()) {
        return refuse_way(act, "a way to the contour is asked for again before the contour has begun", 10743);
    }
    if leaves && !act.has_axis_word() {
        return smooth_retract(act, None, &smooth);
    }
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        cutter.smooth = Some(Box::new(smooth));
    }
    act.channel().check_stop()
}

/// Groups of the side and of the kind of descent.
const LIES: u16 = 146;
const DEPTH: u16 = 147;

/// Speed of the blocks before this one.
fn speed_before(act: &ActionContext<'_, '_>) -> ApproachSpeed {
    if act.channel().state.modal.code(group::MOTION) == Some(codes::RAPID) {
        return ApproachSpeed::Rapid;
    }
    let (id, unit) = feed_of(act.channel().state.modal.code(group::FEED));
    match act.channel().state.arcs.feed {
        // The block itself changes the type of the feed.
        Some((feed, last)) if last != unit && last != FeedUnit::Rapid => ApproachSpeed::Feed(Some(feed), last),
        _ => ApproachSpeed::Feed(act.channel().state.remembered.value(id), unit),
    }
}

fn level_of(act: &mut ActionContext<'_, '_>, [above, at]: [DataId; 2]) -> Option<ToolHeight> {
    let above = act.take(above).map(|datum| ToolHeight::Above(datum.value.abs()));
    let at = act.take(at).map(|datum| ToolHeight::At(datum.value));
    at.or(above)
}

/// Heights of a path along the tool: of the far end, of the end of the quick part, of the contour.
#[derive(Debug, Clone, Copy)]
struct ApproachHeights {
    axis: Option<AxisSlot>,
    far: f64,
    quick: f64,
    contour: f64,
}

/// Points of a way in the plane, and its circle.
#[derive(Debug, Clone, Copy)]
struct Touch {
    /// Where the line or circle begins or ends.
    far: Spot,
    /// Centre and side.
    circle: Option<(Spot, f64)>,
}

impl ApproachSteps for ActionContext<'_, '_> {
    fn smooth_approach(&mut self, waits: &WaitingMove, smooth: &Smooth, next: Option<&Element>) -> Acted {
        let Some(cutter) = self.channel_mut().state.place.cutter().cloned() else { return Ok(()) };
        let step = &waits.step;
        let Some(next) = next else {
            refuse_way(self, "no move of the plane follows the way to the contour", 10740)?;
            return straight(self, step, step.to);
        };
        let offset = cutter_offset(self.channel(), &cutter);
        let (at, here) = (offset.at_start(next), spot_of(self.channel(), &cutter));
        let touch = touch(self, smooth, &cutter, (at, next.start()), (Some(here), -1.0))?;
        let tool = axis_of_tool(self.channel());
        let stands = tool.map(|axis| self.channel().state.place.position.at(axis));
        let contour = tool.map_or(0.0, |axis| step.to.at(axis));
        let heights = heights(self, smooth, contour, stands)?;
        if let Some(cutter) = self.channel_mut().state.place.cutter() {
            cutter.stage = CompensationStage::On;
        }
        let Some((touch, heights)) = touch.zip(heights) else {
            let to = position_at(self.channel(), &cutter, &step.to, at);
            return straight(self, step, to);
        };
        let at_height = |height: f64| {
            let mut level = step.to;
            if let Some(axis) = heights.axis {
                *level.at_mut(axis) = height;
            }
            level
        };
        let [far, quick] = [heights.far, heights.quick].map(|height| {
            let level = at_height(height);
            position_at(self.channel(), &cutter, &level, touch.far)
        });
        let after = match (step.shape, smooth.own) {
            (MoveShape::Rapid, None) => ApproachSpeed::Rapid,
            (MoveShape::Rapid, Some(own)) => own,
            _ => ApproachSpeed::Feed(step.feed, step.unit),
        };
        part(self, step.coded, far, smooth.before)?;
        part(self, step.coded, quick, smooth.before)?;
        let slow = smooth.slow.unwrap_or(after);
        let speed = if smooth.in_space {
            slow
        } else {
            let level = at_height(heights.contour);
            let down = position_at(self.channel(), &cutter, &level, touch.far);
            part(self, step.coded, down, slow)?;
            after
        };
        let level = at_height(heights.contour);
        curve(self, (step.coded, &cutter, smooth), &touch, (level, at), speed)
    }
}

/// Reports why a path is not possible.
pub(crate) fn refuse_way(act: &mut ActionContext<'_, '_>, why: &str, alarm: u32) -> Acted {
    let text = format!("'{}': {why} (alarm {alarm})", act.channel().block_text());
    act.diagnose(&diag::CONTOUR_APPROACH, text);
    act.channel().check_stop()
}

/// Direction of the contour at its end.
fn heading(channel: &mut ChannelContext<'_>) -> Option<Spot> {
    let here = channel.state.place.contour();
    let last = channel.state.arcs.last;
    let cutter = channel.state.place.cutter()?;
    let axes = cutter.axes;
    match cutter.stage {
        CompensationStage::Settled { along, .. } | CompensationStage::Ending(Some((_, along))) => {
            return Some(along);
        }
        _ => {}
    }
    let way = match last? {
        LastMove::By(by) => axes.map(|axis| radial(channel, &by, axis)),
        LastMove::Round { axes: round, center, turn } if round == axes => {
            let center = [(axes[0], center[0]), (axes[1], center[1])]
                .map(|(axis, at)| at * channel.state.place.layout.axes[axis].scale);
            let [x, y] = plus(axes.map(|axis| radial(channel, &here, axis)), center, -1.0);
            [-y * turn, x * turn]
        }
        LastMove::Round { .. } => return None,
    };
    let length = distance(way, [0.0; 2]);
    (length > NOISE).then(|| way.map(|part| part / length))
}

/// Takes the move of a block while a path is requested.
pub(crate) fn smooth_step(act: &mut ActionContext<'_, '_>, step: ProgrammedMove, smooth: Box<Smooth>) -> Acted {
    if smooth.leaves {
        return smooth_retract(act, Some(&step), &smooth);
    }
    if matches!(step.shape, MoveShape::Circle { .. }) {
        return refuse_way(act, "the move that gives the beginning of the contour is a circle", 10745);
    }
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    let in_plane = cutter.axes.iter().any(|axis| step.coded & axis.bit() != 0);
    cutter.smooth = Some(smooth);
    if in_plane {
        keep_back(act, step, None, None);
    } else {
        // Only the height of the contour.
        cutter.contour = step.to;
        act.channel_mut().block.flags.moved = true;
    }
    act.channel().check_stop()
}

/// Axis along the tool.
fn axis_of_tool(channel: &ChannelContext<'_>) -> Option<AxisSlot> {
    let plane = channel.state.modal.code(group::PLANE).and_then(plane)?;
    let role = (0..3).find(|role| *role != plane.first && *role != plane.second)?;
    channel.state.place.layout.cartesian.get(role).copied().flatten()
}

/// A height as a coordinate.
fn height_of(channel: &mut ChannelContext<'_>, axis: AxisSlot, level: ToolHeight, (contour, up): (f64, f64)) -> f64 {
    match level {
        ToolHeight::Above(by) => contour + up * by,
        ToolHeight::At(at) => {
            let mut point = channel.state.place.programmed();
            *point.at_mut(axis) = at;
            channel.state.place.work_point(&point).at(axis)
        }
    }
}

/// Heights of a path; `far` is that of its far end where it is known. None if it was refused.
fn heights(
    act: &mut ActionContext<'_, '_>,
    smooth: &Smooth,
    contour: f64,
    far: Option<f64>,
) -> Result<Option<ApproachHeights>, diag::Halt> {
    let Some(axis) = axis_of_tool(act.channel()) else {
        return Ok(Some(ApproachHeights { axis: None, far: 0.0, quick: 0.0, contour: 0.0 }));
    };
    let up = if far.is_some_and(|far| far < contour) { -1.0 } else { 1.0 };
    let quick = smooth.level.map_or(contour, |level| height_of(act.channel_mut(), axis, level, (contour, up)));
    let first = smooth.retraction.map(|level| height_of(act.channel_mut(), axis, level, (contour, up)));
    let far = first.or(far).unwrap_or(quick);
    if (far - quick) * up < -TOLERANCE || (quick - contour) * up < -TOLERANCE {
        refuse_way(act, "the way along the tool turns back: DISCL is not between its far end and the contour", 10741)?;
        return Ok(None);
    }
    Ok(Some(ApproachHeights { axis: Some(axis), far, quick, contour }))
}

/// The line or circle at a point with a direction; `ahead` is 1 for the path from the contour, −1 for that to it.
/// None if it was refused.
fn touch(
    act: &mut ActionContext<'_, '_>,
    smooth: &Smooth,
    cutter: &CutterCompensation,
    (at, heading): (Spot, Spot),
    (point, ahead): (Option<Spot>, f64),
) -> Result<Option<Touch>, diag::Halt> {
    let size = smooth.size;
    if size <= 0.0 {
        refuse_way(act, "DISR is missing or not above 0", 10742)?;
        return Ok(None);
    }
    if smooth.form == ApproachForm::Line {
        return Ok(Some(Touch { far: plus(at, heading, ahead * (size + cutter.radius)), circle: None }));
    }
    if size < cutter.radius - NOISE {
        refuse_way(act, "DISR, the radius of the tool's centre, is below the radius of the tool", 10742)?;
        return Ok(None);
    }
    let side = match smooth.lies {
        Lies::Left => 1.0,
        Lies::Right => -1.0,
        Lies::WithTool if cutter.side != 0.0 => cutter.side,
        Lies::WithTool | Lies::WithPoint => match point {
            Some(point) if cross(heading, plus(point, at, -1.0)) < 0.0 => -1.0,
            Some(_) => 1.0,
            None => {
                refuse_way(act, "the block does not say to which side the tool leaves the contour", 10744)?;
                return Ok(None);
            }
        },
    };
    let across = [-heading[1] * side, heading[0] * side];
    let center = plus(at, across, size);
    let far = match smooth.form {
        ApproachForm::Half => plus(at, across, 2.0 * size),
        _ => plus(center, heading, ahead * size),
    };
    Ok(Some(Touch { far, circle: Some((center, side)) }))
}

/// A straight part of a path.
fn part(act: &mut ActionContext<'_, '_>, coded: u8, to: Position, speed: ApproachSpeed) -> Acted {
    if to == act.channel().state.place.position {
        return Ok(());
    }
    let step = match speed {
        ApproachSpeed::Rapid => {
            ProgrammedMove { shape: MoveShape::Rapid, coded, to, feed: None, unit: FeedUnit::Rapid }
        }
        ApproachSpeed::Feed(feed, unit) => {
            check_feed(act, feed)?;
            ProgrammedMove { shape: MoveShape::Linear, coded, to, feed, unit }
        }
    };
    straight(act, &step, to)
}

/// The line or circle of a path, to a point at a height.
fn curve(
    act: &mut ActionContext<'_, '_>,
    (coded, cutter, smooth): (u8, &CutterCompensation, &Smooth),
    touch: &Touch,
    (level, to): (Position, Spot),
    speed: ApproachSpeed,
) -> Acted {
    let Some((center, side)) = touch.circle else {
        let to = position_at(act.channel(), cutter, &level, to);
        return part(act, coded, to, speed);
    };
    let ((ApproachSpeed::Feed(feed, unit), _) | (ApproachSpeed::Rapid, ApproachSpeed::Feed(feed, unit))) =
        (speed, smooth.feed)
    else {
        return Ok(());
    };
    check_feed(act, feed)?;
    let here = spot_of(act.channel(), cutter);
    let sweep = if smooth.form == ApproachForm::Half { PI } else { PI / 2.0 };
    let made = PlaneArc {
        center: plus(center, cutter.tip, -1.0),
        radius: smooth.size,
        start_angle: angle(center, here),
        sweep: side * sweep,
    };
    let to = position_round(act.channel(), cutter, &level, to, &made);
    let from = act.channel().state.place.position;
    go_round(act, &CircularMove { made, coded, from, to, axes: cutter.axes, turns: 0, feed, unit, screw: None })
}

/// Makes the path from a contour; the step, if there is one, gives its end.
fn smooth_retract(act: &mut ActionContext<'_, '_>, step: Option<&ProgrammedMove>, smooth: &Smooth) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter().cloned() else { return Ok(()) };
    let Some(heading) = smooth.heading else {
        refuse_way(act, "no move of the plane is before it, so the contour has no direction", 10747)?;
        left_contour(act);
        return Ok(());
    };
    let here = act.channel().state.place.position;
    let coded = step.map_or(0, |step| step.coded);
    let in_plane = cutter.axes.iter().any(|axis| coded & axis.bit() != 0);
    let end =
        step.filter(|_| in_plane).map(|step| plus(plane_spot(act.channel(), &step.to, cutter.axes), cutter.tip, 1.0));
    let at = spot_of(act.channel(), &cutter);
    let touch = touch(act, smooth, &cutter, (at, heading), (end, 1.0))?;
    let tool = axis_of_tool(act.channel());
    let contour = tool.map_or(0.0, |axis| here.at(axis));
    let far = tool.zip(step).filter(|(axis, _)| coded & axis.bit() != 0).map(|(axis, step)| step.to.at(axis));
    let heights = heights(act, smooth, contour, far)?;
    let Some((touch, heights)) = touch.zip(heights) else {
        if let Some(step) = step {
            straight(act, step, step.to)?;
        }
        left_contour(act);
        return Ok(());
    };
    let base = step.map_or(here, |step| cutter.lifted(&step.to, &here));
    let at_height = |height: f64| {
        let mut level = base;
        if let Some(axis) = heights.axis {
            *level.at_mut(axis) = height;
        }
        level
    };
    let old = match smooth.before {
        // The contour has had a feed.
        ApproachSpeed::Rapid => smooth.feed,
        feed => feed,
    };
    let slow = smooth.slow.unwrap_or(old);
    if smooth.in_space {
        let level = at_height(heights.quick);
        curve(act, (coded, &cutter, smooth), &touch, (level, touch.far), slow)?;
    } else {
        let level = at_height(heights.contour);
        curve(act, (coded, &cutter, smooth), &touch, (level, touch.far), old)?;
        let level = at_height(heights.quick);
        let up = position_at(act.channel(), &cutter, &level, touch.far);
        part(act, coded, up, slow)?;
    }
    if let Some(step) = step {
        let after = match (step.shape, smooth.own) {
            (_, Some(own)) => own,
            (MoveShape::Rapid, None) => ApproachSpeed::Rapid,
            _ => old,
        };
        let level = at_height(heights.far);
        let up = position_at(act.channel(), &cutter, &level, touch.far);
        part(act, coded, up, after)?;
        if in_plane {
            let mut to = step.to;
            if let Some(axis) = heights.axis {
                *to.at_mut(axis) = far.unwrap_or(heights.far);
            }
            part(act, coded, to, after)?;
        }
    }
    left_contour(act);
    act.channel_mut().block.flags.moved = true;
    act.channel().check_stop()
}

/// Records that the tool has left the contour: its position is the programmed one.
fn left_contour(act: &mut ActionContext<'_, '_>) {
    let position = act.channel().state.place.position;
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return };
    (cutter.contour, cutter.smooth) = (position, None);
    if cutter.stage.is_ending() {
        act.channel_mut().state.place.forget_cutter();
    } else if cutter.plain {
        corner::end(act);
    } else {
        cutter.stage = CompensationStage::Start;
    }
}
