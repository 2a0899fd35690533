//! The moves of the tool beside a contour.
//!
//! *Invariant:* every move is an ordinary motion, made from the tool's position; `Place::position` is that of the
//! tool's centre (on a lathe of the imaginary tip). The feed is that of this point.

use std::f64::consts::TAU;

use counterpoint_channel::arc::LastMove;
use counterpoint_channel::axis_rates::edge_feed;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::cutter::{CompensationStage, WaitingMove};
use counterpoint_channel::plane_points::{missing_side, position_at, position_round, spot_of};
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::data;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::CornerShape;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::contour::corner;
use counterpoint_motion::contour::corner::{CornerPath, Link, Offset};
use counterpoint_motion::contour::element::{Element, NOISE, Spot, angle, beside, distance, plus};
use counterpoint_program::block::ContourEnd;

use super::held::HeldShift;
use super::{CutterCompensation, MoveShape, ProgrammedMove};
use crate::context::{ActionContext, ApproachSteps, AroundSteps, CircleSteps, StraightSteps};
use crate::cutter::held::{go_to, put_back_events};
use counterpoint_channel::circular_move::CircularMove;

/// A move as programmed, for circles that continue its direction.
pub(crate) fn last_move(channel: &ChannelContext<'_>, step: &ProgrammedMove) -> Option<LastMove> {
    let MoveShape::Circle { made, axes, .. } = step.shape else {
        let mut by = step.to;
        by.iter_mut().zip(channel.state.place.contour()).for_each(|(to, from)| *to -= from);
        return Some(LastMove::By(by));
    };
    let scale = |axis: AxisSlot| channel.state.place.layout.axes[axis].scale;
    let [first, second] = axes;
    let center = [made.center[0] / scale(first), made.center[1] / scale(second)];
    Some(LastMove::Round { axes, center, turn: made.sweep.signum() })
}

pub(crate) fn cutter_offset(channel: &ChannelContext<'_>, cutter: &CutterCompensation) -> Offset {
    let limit = libm::cos(channel.env.machine.compensation.corner_angle.to_radians());
    let shape = channel.env.machine.compensation.corner_shape.map(|shape| corner_thresholds(channel, shape));
    Offset { side: cutter.side, radius: cutter.radius, corner: channel.state.place.compensation.corner, limit, shape }
}

/// Takes the distortion of round corners from the block.
pub(crate) fn take_distortion(act: &mut ActionContext<'_, '_>) {
    if act.block_has(data::CONTOUR_DISTORTION)
        && let Some(value) = act.take(data::CONTOUR_DISTORTION).map(|datum| datum.value)
    {
        act.channel_mut().state.remembered.remember(data::CONTOUR_DISTORTION, value);
    }
}

/// Limits of outside corners, with the distortion that the program has set.
fn corner_thresholds(channel: &ChannelContext<'_>, limits: CornerShape) -> corner::CornerThresholds {
    let asked = channel.state.remembered.value(data::CONTOUR_DISTORTION).unwrap_or(0.0);
    let [sharp, flat] = [limits.sharp, limits.flat].map(|turn| libm::cos(turn.to_radians()));
    corner::CornerThresholds { sharp, flat, distortion: asked.clamp(0.0, limits.distortion) / 100.0 }
}

/// A move to its programmed point, without compensation.
pub(crate) fn on_contour(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove) -> Acted {
    straight(act, step, step.to)
}

/// A straight move of a step to a point.
pub(crate) fn straight(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove, to: Position) -> Acted {
    without_cutter(act, |act| match step.shape {
        MoveShape::Rapid => act.rapid_within(step.coded, to, step.feed),
        MoveShape::Linear | MoveShape::Circle { .. } => act.feed_to(step.coded, to, step.feed, step.unit),
    })
}

/// Carries moves out while compensation does not take them.
fn without_cutter<R>(act: &mut ActionContext<'_, '_>, work: impl FnOnce(&mut ActionContext<'_, '_>) -> R) -> R {
    let cutter = act.channel_mut().state.place.frames().cutter.take();
    let result = work(act);
    if cutter.is_some() {
        act.channel_mut().state.place.frames().cutter = cutter;
    }
    result
}

/// Where a piece begins after one that did not know it: around the corner, or straight.
pub(crate) fn come_to(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove, element: &Element) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter().cloned() else { return Ok(()) };
    let offset = cutter_offset(act.channel(), &cutter);
    let links = match cutter.stage {
        CompensationStage::Start => {
            if matches!(step.shape, MoveShape::Circle { .. }) {
                vec![Link::Line(offset.at_start(element))]
            } else {
                return Ok(());
            }
        }
        CompensationStage::Settled { corner, along } => {
            let start = offset.at_start(element);
            let turn = counterpoint_motion::contour::element::cross(along, element.start()) * cutter.side;
            if distance(spot_of(act.channel(), &cutter), start) < NOISE {
                Vec::new()
            } else if turn > 0.0 {
                report_overcut(act, cutter.ended);
                vec![Link::Line(start)]
            } else {
                offset.outside(corner, along, element)
            }
        }
        CompensationStage::Around { corner, along } => Offset { corner: 2, ..offset }.outside(corner, along, element),
        CompensationStage::Turned => vec![Link::Line(offset.at_start(element))],
        CompensationStage::On | CompensationStage::Ending(_) => return Ok(()),
    };
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        cutter.stage = CompensationStage::On;
    }
    make_links(act, (step, element), &cutter, &links, act.channel().state.place.position)
}

/// Finishes the waiting move, now that the next piece is known (or will not be).
pub(crate) fn next_element(act: &mut ActionContext<'_, '_>, next: Option<&Element>) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter().filter(|cutter| !cutter.waiting.is_empty()) else {
        return Ok(());
    };
    let waiting = std::mem::take(&mut cutter.waiting);
    cutter.idle = 0;
    let mut begun = cutter.stage;
    let (now, exact_stop) = ((act.channel().at.clock, act.channel().at.micro), act.channel().block.flags.exact_stop);
    let place = act.channel().at.block_place();
    let (edited, spindle) = (act.channel().text.edited.clone(), act.channel().state.spindle);
    let mut events = act.channel_mut().emitter.release().into_iter();
    let (mut shift, mut out) = (HeldShift::default(), 0_usize);
    let (mut result, mut missing) = (Ok(()), None);
    for (at, waits) in waiting.iter().enumerate() {
        let next = waiting.iter().skip(at + 1).find_map(|later| later.element.as_ref()).or(next);
        put_back_events(act.channel_mut(), &mut events, waits.events.saturating_sub(out), shift);
        out = out.max(waits.events);
        go_to(act.channel_mut(), waits, shift);
        let before = act.channel().at.clock;
        act.channel_mut().state.spindle = waits.spindle;
        if result.is_ok() {
            missing = missing.or_else(|| missing_side(act.channel(), waits));
            result = make(act, waits, begun, next);
            begun = match act.channel_mut().state.place.cutter().map(|cutter| cutter.stage) {
                Some(stage @ CompensationStage::Around { .. }) => stage,
                _ if waits.element.is_some() || waits.smooth.is_some() => CompensationStage::On,
                _ => begun,
            };
        }
        let at = &act.channel().at;
        shift.add(before, (at.clock, at.micro));
    }
    put_back_events(act.channel_mut(), &mut events, usize::MAX, shift);
    act.channel_mut().state.spindle = spindle;
    (act.channel_mut().at.clock, act.channel_mut().at.micro) = shift.of(now);
    act.channel_mut().block.flags.exact_stop = exact_stop;
    act.channel_mut().at.go_to(place);
    act.channel_mut().text.edited = edited;
    if let Some((facts, text)) = missing.filter(|_| result.is_ok()) {
        act.diagnose(facts, text);
        return act.channel().check_stop();
    }
    result
}

/// Makes a move that has waited.
fn make(
    act: &mut ActionContext<'_, '_>,
    waits: &WaitingMove,
    begun: CompensationStage,
    next: Option<&Element>,
) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter().cloned() else { return Ok(()) };
    if let Some(smooth) = &waits.smooth {
        return act.smooth_approach(waits, smooth, next);
    }
    let (step, offset) = (&waits.step, cutter_offset(act.channel(), &cutter));
    let Some(element) = &waits.element else {
        let to = cutter.lifted(&step.to, &act.channel().state.place.position);
        return straight(act, step, to);
    };
    if matches!(begun, CompensationStage::Around { .. }) {
        come_to(act, step, element)?;
    }
    let stage = match next {
        Some(_) => CompensationStage::On,
        None => CompensationStage::Settled { corner: element.to, along: element.end() },
    };
    let ended = act.channel().at.line;
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        (cutter.stage, cutter.ended) = (stage, ended);
    }
    if begun == CompensationStage::Start && !matches!(step.shape, MoveShape::Circle { .. }) {
        if let Some(next) = next
            && let Some(corner) = act.around_start(element, next)?
        {
            let to = position_at(act.channel(), &cutter, &step.to, corner.end);
            straight(act, step, to)?;
            let level = act.channel().state.place.position;
            return make_links(act, (step, element), &cutter, &corner.links, level);
        }
        let end = match (waits.end, next) {
            (ContourEnd::Beside(along), _) => beside(element.to, along, cutter.side, cutter.radius),
            (_, Some(next)) => offset.at_start(next),
            (_, None) => offset.at_end(element),
        };
        let to = position_at(act.channel(), &cutter, &step.to, end);
        straight(act, step, to)?;
        let links: Vec<_> = next.and_then(|next| arc_start(waits.end, &offset, next)).into_iter().collect();
        return make_links(act, (step, element), &cutter, &links, to);
    }
    let here = spot_of(act.channel(), &cutter);
    let corner = match next {
        Some(next) if circle_follows(act.channel(), waits, &offset, (element, next)) => {
            if let Some(cutter) = act.channel_mut().state.place.cutter() {
                cutter.stage = CompensationStage::Around { corner: element.to, along: element.end() };
            }
            let hurts = element.is_smaller(cutter.side, cutter.radius);
            CornerPath { end: offset.at_end(element), links: Vec::new(), hurts }
        }
        Some(next) if let ContourEnd::Beside(along) = waits.end => {
            let links = arc_start(waits.end, &offset, next).into_iter().collect();
            CornerPath { end: beside(element.to, along, cutter.side, cutter.radius), links, hurts: false }
        }
        Some(next) if waits.end == ContourEnd::Open => {
            CornerPath { end: offset.at_end(element), links: vec![Link::Line(offset.at_start(next))], hurts: false }
        }
        Some(next) if let ContourEnd::Extended(by) = waits.end => offset.extended(element, next, here, by),
        Some(next) if waits.end == ContourEnd::Round => Offset { corner: 2, ..offset }.between(element, next, here),
        Some(next) if waits.end == ContourEnd::Sharp => Offset { corner: 1, ..offset }.between(element, next, here),
        Some(next) => offset.between(element, next, here),
        None => {
            let hurts = element.is_smaller(cutter.side, cutter.radius);
            CornerPath { end: offset.at_end(element), links: Vec::new(), hurts }
        }
    };
    if corner.hurts {
        let text = format!(
            "the tool of radius {} does not fit into the contour at the end of '{}'",
            counterpoint_lang::format::wildcard_text(cutter.radius),
            act.channel().block_text()
        );
        act.diagnose(&diag::CUTTER_INTERFERENCE, text);
    }
    along(act, step, &cutter, element, corner.end)?;
    let to = act.channel().state.place.position;
    make_links(act, (step, element), &cutter, &corner.links, to)
}

/// Whether the circle around the end of a piece belongs to the move after it.
fn circle_follows(
    channel: &ChannelContext<'_>,
    waits: &WaitingMove,
    offset: &Offset,
    (first, second): (&Element, &Element),
) -> bool {
    channel.env.machine.compensation.corner_after && waits.end == ContourEnd::Meets && offset.goes_around(first, second)
}

/// Along the offset of a piece to a point of it.
pub(crate) fn along(
    act: &mut ActionContext<'_, '_>,
    step: &ProgrammedMove,
    cutter: &CutterCompensation,
    element: &Element,
    end: Spot,
) -> Acted {
    let to = position_at(act.channel(), cutter, &step.to, end);
    let (Some(arc), MoveShape::Circle { axes, turns, .. }) = (&element.arc, step.shape) else {
        return straight(act, step, to);
    };
    let Some(radius) = element.offset_radius(cutter.side, cutter.radius) else { return straight(act, step, to) };
    let here = spot_of(act.channel(), cutter);
    let start_angle = angle(arc.center, here);
    let turn = arc.sweep.signum();
    let way = ((angle(arc.center, end) - start_angle) * turn).rem_euclid(TAU);
    // A whole circle, or nothing of one.
    let near = way < 1e-9 || TAU - way < 1e-9;
    let whole = f64::from(turns) * TAU;
    let part = arc.sweep.abs() - whole;
    let way = if near && part > TAU / 2.0 {
        TAU
    } else if near {
        0.0
    } else {
        way
    };
    if way + whole < 1e-12 {
        return straight(act, step, to);
    }
    let made =
        PlaneArc { center: plus(arc.center, cutter.tip, -1.0), radius, start_angle, sweep: turn * (way + whole) };
    let to = position_round(act.channel(), cutter, &step.to, end, &made);
    let ProgrammedMove { coded, unit, .. } = *step;
    let feed = edge_feed(act.channel(), step.feed, unit, radius / arc.radius);
    go_round(
        act,
        &CircularMove {
            made,
            coded,
            from: act.channel().state.place.position,
            to,
            axes,
            turns,
            feed,
            unit,
            screw: None,
        },
    )
}

pub(crate) fn go_round(act: &mut ActionContext<'_, '_>, circle: &CircularMove) -> Acted {
    without_cutter(act, |act| act.circle_to(circle))
}

/// The moves around a corner, the axes beside the plane standing.
pub(crate) fn make_links(
    act: &mut ActionContext<'_, '_>,
    (step, element): (&ProgrammedMove, &Element),
    cutter: &CutterCompensation,
    links: &[Link],
    level: Position,
) -> Acted {
    let length = element.length();
    for link in links {
        match *link {
            Link::Line(spot) => {
                let to = position_at(act.channel(), cutter, &level, spot);
                make_link(act, step, length, to, None)?;
            }
            Link::Round { to: spot, center, clockwise } => {
                let here = spot_of(act.channel(), cutter);
                let turn = if clockwise { -1.0 } else { 1.0 };
                let (start_angle, radius) = (angle(center, here), distance(center, spot));
                let sweep = ((angle(center, spot) - start_angle) * turn).rem_euclid(TAU) * turn;
                let center = plus(center, cutter.tip, -1.0);
                let made = PlaneArc { center, radius, start_angle, sweep };
                let to = position_round(act.channel(), cutter, &level, spot, &made);
                make_link(act, step, length, to, Some((made, cutter.axes)))?;
            }
        }
    }
    Ok(())
}

/// Feed per minute of a circle around a corner between rapid moves: the rate of the slower axis of the plane.
fn rapid_round(channel: &ChannelContext<'_>, axes: [AxisSlot; 2], limit: Option<f64>) -> Option<f64> {
    let rates = axes.map(|axis| channel.state.place.layout.axes[axis].rapid * 60.0);
    let rate = rates.into_iter().chain(limit).fold(f64::INFINITY, f64::min);
    Some(rate).filter(|rate| rate.is_finite())
}

/// A move around a corner has the feed of its block; under inverse time the speed that the block has on the
/// contour.
fn make_link(
    act: &mut ActionContext<'_, '_>,
    step: &ProgrammedMove,
    length: f64,
    to: Position,
    round: Option<(PlaneArc, [AxisSlot; 2])>,
) -> Acted {
    let (feed, unit) = match step.unit {
        FeedUnit::InverseTime => (step.feed.map(|feed| feed * length), FeedUnit::PerMinute),
        unit => (step.feed, unit),
    };
    match (round, step.shape) {
        (Some((made, axes)), shape) => {
            let from = act.channel().state.place.position;
            let (feed, unit) = match shape {
                MoveShape::Rapid => (rapid_round(act.channel(), axes, feed), FeedUnit::PerMinute),
                _ => (feed, unit),
            };
            go_round(act, &CircularMove { made, coded: 0, from, to, axes, turns: 0, feed, unit, screw: None })
        }
        _ => straight(act, &ProgrammedMove { feed, unit, ..step.clone() }, to),
    }
}

/// The start of the offset of an arc, from the vector that the program gives.
fn arc_start(end: ContourEnd, offset: &Offset, next: &Element) -> Option<Link> {
    let given = matches!(end, ContourEnd::Beside(_)) && next.arc.is_some();
    given.then(|| Link::Line(offset.at_start(next)))
}

/// Reports an inside corner whose first move did not know the second move.
fn report_overcut(act: &mut ActionContext<'_, '_>, ended: u32) {
    let text = format!(
        "the tool has cut into the inside corner before '{}': the move of line {ended} ended at right angles to its \
         end, because the control did not read ahead to this block",
        act.channel().block_text()
    );
    act.diagnose(&diag::CORNER_OVERCUT, text);
}
