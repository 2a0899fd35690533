//! Cutter and nose radius compensation: the tool goes beside the programmed contour.
//!
//! A move waits until the next move of its plane is known; events in between are held back with it (`held`), so that
//! the log keeps its order. Invariants: without a radius nothing of this exists; a held clock never runs past events
//! that other channels may see; every way out of compensation finishes the waiting move. Facts: reference
//! control-emulator.md 6.6. Decisions: docs/emulation.md, "Cutter radius".

pub(crate) mod angle;
mod around;
mod between;
mod corner;
mod held;
pub(crate) mod mirror;
pub(crate) mod moves;
pub(crate) mod resized;
pub(crate) mod smooth;
mod wall;
mod words;

pub(crate) use between::before;
pub(crate) use resized::resized;
pub(crate) use words::{code as corner_code, has_words, with_words};

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::corner::{ContourRequest, CornerRequest};
use counterpoint_channel::cutter::{CompensationStage, CutterCompensation, MoveShape, ProgrammedMove, WaitingMove};
use counterpoint_channel::modal::{group, plane};
use counterpoint_channel::plane_points::{forget_corners, plane_spot};
use counterpoint_channel::tool_radius::{cutter_radius, nose_tip};
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::{Element, NOISE, distance};

use crate::context::ActionContext;
use crate::cutter::angle::wait_for_end;
use crate::cutter::around::around_end;
use crate::cutter::between::count_zero_move;
use crate::cutter::corner::{corner_at_switch, corner_of, cut_corners, used_up, without_waiting};
use crate::cutter::moves::{come_to, last_move, next_element, on_contour, straight, take_distortion};
use crate::cutter::resized::resize;
use crate::cutter::smooth::{refuse_way, smooth_step};
use crate::time::check_feed;

/// Number of blocks after which a waiting move is completed in any case.
const LONGEST_WAIT: u64 = 1000;

/// A code that switches compensation: the next moves go beside the contour, or on it again.
pub(crate) fn switched(act: &mut ActionContext<'_, '_>, code: CodeId) -> Acted {
    if code == codes::COMP_DIAM_OFF {
        wall::at_wall(act)?;
    }
    act.flush_lookahead()?;
    let side = match code {
        codes::COMP_DIAM_LEFT => 1.0,
        codes::COMP_DIAM_RIGHT => -1.0,
        codes::COMP_3D_VECTOR => 0.0,
        _ => {
            leave(act);
            return Ok(());
        }
    };
    let number = act.channel().diameter_in_force().unwrap_or(0);
    let cancels = number == 0 && act.channel().env.machine.compensation.zero_cancels;
    if cancels && act.channel_mut().state.place.cutter().is_some_and(|cutter| !cutter.plain) {
        leave(act);
        return Ok(());
    }
    let radius = cutter_radius(act.channel(), number) + contour_allowance(act);
    act.channel().check_stop()?;
    if radius == 0.0 {
        no_radius(act, number);
        act.channel().check_stop()?;
    }
    if act.channel_mut().state.place.cutter().is_none_or(|cutter| cutter.plain) && radius == 0.0 {
        return Ok(());
    }
    let Some((plane_code, axes)) = compensated_plane(act) else {
        let text =
            format!("no plane with both axes is active for the compensation of '{}'", act.channel().block_text());
        act.diagnose(&diag::CUTTER_PLANE, text);
        return Ok(());
    };
    if around::frame_tilts(act, plane_code) {
        let text = format!(
            "'{}' compensates in the plane of a tilted frame (CUT2DF), which is not emulated; tilt by CYCLE800, or program CUT2D",
            act.channel().block_text()
        );
        act.diagnose(&diag::SIEMENS_STATE, text);
        return act.channel().check_stop();
    }
    wall::at_vector(act, plane_code, axes);
    let tip = nose_tip(act.channel(), number, plane_code);
    let contour = act.channel().state.place.contour();
    let side = if mirror::is_mirrored(act) { -side } else { side };
    let before = act.channel_mut().state.place.cutter().filter(|cutter| !cutter.stage.is_ending() && !cutter.plain);
    let kept = before.map(|_| CompensationStage::Turned);
    let new = CutterCompensation {
        side: if radius < 0.0 { -side } else { side },
        radius: radius.abs(),
        tip: tip.map(|part| part * radius.abs()),
        axes,
        contour,
        stage: kept.unwrap_or(CompensationStage::Start),
        waiting: Vec::new(),
        idle: 0,
        seen: act.channel().at.blocks,
        ended: act.channel().at.line,
        suspended: false,
        plain: false,
        asked: ContourRequest::default(),
        smooth: None,
        resized: None,
    };
    act.channel_mut().state.place.frames().cutter = Some(Box::new(new));
    Ok(())
}

/// The next move in the plane ends compensation.
fn leave(act: &mut ActionContext<'_, '_>) {
    if let Some(cutter) = act.channel_mut().state.place.cutter().filter(|cutter| !cutter.plain) {
        cutter.stage = match cutter.stage {
            CompensationStage::Settled { corner, along } | CompensationStage::Around { corner, along } => {
                CompensationStage::Ending(Some((corner, along)))
            }
            CompensationStage::Ending(known) => CompensationStage::Ending(known),
            _ => CompensationStage::Ending(None),
        };
    }
}

/// A cycle goes beside its contour with the nose of the tool, or on it again; without a radius it is the same.
pub(crate) fn beside(act: &mut ActionContext<'_, '_>, side: Option<f64>) -> Acted {
    let code = match side {
        None => codes::COMP_DIAM_OFF,
        Some(side) if side > 0.0 => codes::COMP_DIAM_LEFT,
        Some(_) => codes::COMP_DIAM_RIGHT,
    };
    let before = (act.channel().state.modal.code(group::DIAMETER), act.channel().state.modal.row(group::DIAMETER));
    act.channel_mut().state.modal.activate(group::DIAMETER, code, None);
    if side.is_none()
        || act.channel().diameter_in_force().is_some_and(|number| cutter_radius(act.channel(), number) > 0.0)
    {
        return switched(act, code);
    }
    if let (Some(code), row) = before {
        act.channel_mut().state.modal.activate(group::DIAMETER, code, row);
    }
    Ok(())
}

/// Allowance of the contour: that of the block, or the last one.
fn contour_allowance(act: &mut ActionContext<'_, '_>) -> f64 {
    if let Some(value) = act.take(data::CONTOUR_ALLOWANCE).map(|datum| datum.value) {
        act.channel_mut().state.remembered.remember(data::CONTOUR_ALLOWANCE, value);
    }
    act.channel().state.remembered.value(data::CONTOUR_ALLOWANCE).unwrap_or(0.0)
}

/// Says that compensation changes nothing: the control would continue the contour as well, the part would be wrong.
fn no_radius(act: &mut ActionContext<'_, '_>, number: u32) {
    let block = act.channel().block_text();
    if act.channel().env.machine.compensation.needs_tool && act.channel().state.place.tools.current == 0 {
        let text = format!("the compensation of '{block}' needs a tool; no tool is loaded");
        return act.diagnose(&diag::COMPENSATION_TOOL, text);
    }
    let text = if number == 0 {
        format!("no offset number is active for the compensation of '{block}', the tool moves on the contour")
    } else {
        let subject = crate::tool_offsets::in_words(act, number).unwrap_or_else(|| format!("offset {number}"));
        format!("{subject} has no radius for the compensation of '{block}', the tool moves on the contour")
    };
    act.diagnose(&diag::NO_RADIUS, text);
}

/// The active plane and its axes; under polar and cylindrical interpolation that of the part.
fn compensated_plane(act: &ActionContext<'_, '_>) -> Option<(CodeId, [AxisSlot; 2])> {
    if let Some(polar) = act.channel().state.place.polar() {
        return Some((codes::PLANE_XY, polar.axes()));
    }
    let code = act.channel().state.modal.code(group::PLANE)?;
    let plane = plane(code)?;
    let axis = |role: usize| act.channel().state.place.layout.cartesian.get(role).copied().flatten();
    Some((code, [axis(plane.first)?, axis(plane.second)?]))
}

/// Polar or cylindrical interpolation has been switched: another plane, in which compensation begins again.
pub(crate) fn plane_changed(act: &mut ActionContext<'_, '_>) {
    let number = act.channel().diameter_in_force().unwrap_or(0);
    let made = compensated_plane(act).map(|(code, axes)| (axes, nose_tip(act.channel(), number, code)));
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return };
    if !cutter.stage.is_ending() {
        cutter.stage = CompensationStage::Start;
    }
    let text = match made {
        Some((axes, tip)) => {
            (cutter.axes, cutter.tip) = (axes, tip.map(|part| part * cutter.radius));
            format!(
                "'{}' changes the plane while compensation is active; compensation starts again",
                act.channel().block_text()
            )
        }
        // Switched off already: the next move goes straight to its point.
        None if cutter.stage.is_ending() => {
            act.channel_mut().state.place.forget_cutter();
            return;
        }
        None => {
            act.channel_mut().state.place.forget_cutter();
            format!("no plane with both axes is left for compensation in '{}', it ends", act.channel().block_text())
        }
    };
    act.diagnose(&diag::CUTTER_PLANE, text);
}

/// Brings the tool back to the contour, straight at feed, for a move that goes without compensation.
pub(crate) fn to_contour(act: &mut ActionContext<'_, '_>, feed: Option<f64>, unit: FeedUnit) -> Acted {
    let to = act.channel().state.place.contour();
    if !act.channel().state.place.is_compensated() || to == act.channel().state.place.position {
        return Ok(());
    }
    let feed = (feed.filter(|_| unit != FeedUnit::InverseTime), unit);
    let shape = if feed.0.is_some() { MoveShape::Linear } else { MoveShape::Rapid };
    straight(act, &ProgrammedMove { shape, coded: 0, to, feed: feed.0, unit }, to)
}

/// Called after a thread, which goes without compensation: the next moves approach the contour again.
pub(crate) fn after_thread(act: &mut ActionContext<'_, '_>) {
    let position = act.channel().state.place.position;
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        (cutter.contour, cutter.stage) = (position, CompensationStage::Start);
    }
}

/// Keeps a move back, and all later events.
fn keep_back(
    act: &mut ActionContext<'_, '_>,
    step: ProgrammedMove,
    element: Option<Element>,
    corner: Option<CornerRequest>,
) {
    let ChannelContext { at, block: now, text, .. } = act.channel();
    let (place, block, clock, micro) = (at.block_place(), at.blocks, at.clock, at.micro);
    let (exact, end, text) = (now.flags.exact_stop, now.flags.end, text.edited.clone());
    let open = act.channel_mut().state.place.cutter().and_then(|cutter| cutter.asked.open.take());
    let smooth = act.channel_mut().state.place.cutter().and_then(|cutter| cutter.smooth.take());
    let first = element.is_some() || open.is_some() || smooth.is_some();
    if first {
        let since = act.channel().at.tag();
        act.channel_mut().emitter.hold(since);
    }
    let (events, spindle) = (act.channel().emitter.buffered(), act.channel().state.spindle);
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return };
    cutter.contour = step.to;
    if first {
        cutter.idle = 0;
    }
    cutter.waiting.push(WaitingMove {
        step,
        element,
        corner,
        open,
        smooth,
        place,
        block,
        clock,
        micro,
        exact,
        end,
        text,
        events,
        spindle,
    });
    act.channel_mut().block.flags.moved = true;
    act.note_effect();
}

/// Takes a move: it may wait for the next one.
pub(crate) fn compensate(act: &mut ActionContext<'_, '_>, step: ProgrammedMove) -> Acted {
    let last = last_move(act.channel(), &step);
    let done = take_step(act, step);
    act.channel_mut().state.arcs.last = last;
    done
}

/// Makes or keeps back a move.
fn take_step(act: &mut ActionContext<'_, '_>, step: ProgrammedMove) -> Acted {
    act.channel().check_stop()?;
    if !matches!(step.shape, MoveShape::Rapid) {
        check_feed(act, step.feed)?;
    }
    if act.channel().state.modal.code(group::DIAMETER) == Some(codes::COMP_3D_VECTOR) {
        return along_vector(act, step);
    }
    take_distortion(act);
    if act.block_has(data::CONTOUR_ALLOWANCE)
        && let Some(code) = act.channel().state.modal.code(group::DIAMETER)
        && code != codes::COMP_DIAM_OFF
    {
        switched(act, code)?;
    }
    let from = act.channel().state.place.contour();
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    if let Some(smooth) = cutter.smooth.take() {
        return smooth_step(act, step, smooth);
    }
    let (axes, stage, first) = (cutter.axes, cutter.stage, cutter.waiting.is_empty());
    if cutter.asked.open.is_some() && !stage.is_ending() && !cutter.suspended {
        wait_for_end(act, step);
        return Ok(());
    }
    if cutter.suspended {
        cutter.stage = CompensationStage::Start;
        cutter.contour = step.to;
        return on_contour(act, &step);
    }
    let Some(element) = element(act, &step, &from, axes) else { return out_of_plane(act, step) };
    act.channel().check_stop()?;
    let rapid = matches!(step.shape, MoveShape::Rapid);
    let round = matches!(step.shape, MoveShape::Circle { .. });
    let rules = act.channel().env.machine.compensation;
    match stage {
        CompensationStage::Ending(end) => {
            report_switch(act, &step, "off", (rapid && !rules.rapid, round && !rules.arcs));
            corner_at_switch(act, "off");
            act.channel().check_stop()?;
            around_end(act, &step, &element, end)?;
            act.channel_mut().state.place.forget_cutter();
            return on_contour(act, &step);
        }
        CompensationStage::Start if first => {
            report_switch(act, &step, "on", (rapid && !rules.rapid, round && !rules.arcs));
            if act.channel().env.machine.is_alarm(&diag::CORNER_AT_COMPENSATION) {
                corner_at_switch(act, "on");
            }
        }
        CompensationStage::Start
        | CompensationStage::On
        | CompensationStage::Turned
        | CompensationStage::Settled { .. }
        | CompensationStage::Around { .. } => {}
    }
    act.channel().check_stop()?;
    let mut element = element;
    cut_corners(act, &step, &mut element)?;
    if element.length() < NOISE {
        return used_up(act, step, &element);
    }
    next_element(act, Some(&element))?;
    come_to(act, &step, &element)?;
    resize(act, &step, &element)?;
    let corner = corner_of(act, &step);
    if corner.is_none() && act.channel_mut().state.place.cutter().is_some_and(|cutter| cutter.plain) {
        return without_waiting(act, &step, &element);
    }
    keep_back(act, step, Some(element), corner);
    Ok(())
}

/// Compensation is switched by a move that the machine does not take for it.
fn report_switch(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove, what: &str, (rapid, round): (bool, bool)) {
    let on = what == "on";
    let (facts, kind) = match (rapid, round, step.shape) {
        (true, ..) if on => (&diag::COMP_ON_RAPID, "a rapid move"),
        (true, ..) => (&diag::COMP_OFF_RAPID, "a rapid move"),
        (_, true, _) if on => (&diag::COMP_ON_ARC, "a circle"),
        (_, true, _) => (&diag::COMP_OFF_ARC, "a circle"),
        _ => return,
    };
    let text = format!("cutter compensation is switched {what} by {kind} in '{}'", act.channel().block_text());
    act.diagnose(facts, text);
}

/// The piece of the contour that a move makes in the plane; none if it stays on its spot.
fn element(
    act: &mut ActionContext<'_, '_>,
    step: &ProgrammedMove,
    from: &Position,
    axes: [AxisSlot; 2],
) -> Option<Element> {
    let [start, end] = [from, &step.to].map(|of| plane_spot(act.channel(), of, axes));
    match step.shape {
        MoveShape::Circle { made, axes: own, .. } if own == axes => {
            Some(Element { from: start, to: end, arc: Some(made) })
        }
        MoveShape::Circle { .. } => {
            let text =
                format!("the circle of '{}' is in another plane than its compensation", act.channel().block_text());
            act.diagnose(&diag::CUTTER_PLANE, text);
            (distance(start, end) > NOISE).then_some(Element { from: start, to: end, arc: None })
        }
        _ => (distance(start, end) > NOISE).then_some(Element { from: start, to: end, arc: None }),
    }
}

/// A move beside the plane: with a move that waits it waits too.
fn out_of_plane(act: &mut ActionContext<'_, '_>, step: ProgrammedMove) -> Acted {
    let stands = act.channel().state.place.position;
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    let due = cutter.is_due();
    if due && act.channel().env.machine.corners.dwell_only {
        act.flush_lookahead()?;
        return out_of_plane(act, step);
    }
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    if !cutter.waiting.is_empty() {
        count_zero_move(act.channel_mut(), &step);
        keep_back(act, step, None, None);
        return Ok(());
    }
    cutter.contour = step.to;
    let to = cutter.lifted(&step.to, &stands);
    straight(act, &step, to)?;
    corner::end(act);
    Ok(())
}

/// The vector form: every straight move ends beside its point, in the direction of the vector.
fn along_vector(act: &mut ActionContext<'_, '_>, step: ProgrammedMove) -> Acted {
    let words = [data::COMP_DIAM_P, data::COMP_DIAM_Q, data::COMP_DIAM_R].map(|id| act.take(id).map(|d| d.value));
    let vector = &mut act.channel_mut().state.place.compensation.vector;
    for (slot, word) in vector.iter_mut().zip(words) {
        *slot = word.filter(|value| value.is_finite()).unwrap_or(*slot);
    }
    let vector = *vector;
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    let mut to = step.to;
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    cutter.contour = step.to;
    let ending = cutter.stage.is_ending();
    let radius = if length.is_normal() && !ending { cutter.radius / length } else { 0.0 };
    for (role, part) in vector.into_iter().enumerate() {
        let axis = act.channel().state.place.layout.cartesian.get(role).copied().flatten();
        if let Some(axis) = axis {
            *to.at_mut(axis) += part * radius / act.channel().state.place.scale_of(role);
        }
    }
    if ending {
        act.channel_mut().state.place.forget_cutter();
    }
    straight(act, &step, to)
}

/// The program has ended: the waiting move is made, unless the job has been stopped.
pub(crate) fn end_compensation(act: &mut ActionContext<'_, '_>, halt: Halt) -> Halt {
    if !act.channel().state.place.is_compensated() {
        return halt;
    }
    let pending = act.channel_mut().state.place.cutter().and_then(|cutter| cutter.smooth.take());
    if pending.is_some()
        && matches!(halt, Halt::ProgramEnd(_))
        && let Err(stop) = refuse_way(act, "the program ends before the contour of a soft approach", 10740)
    {
        act.channel_mut().state.place.forget_cutter();
        return stop;
    }
    if matches!(halt, Halt::ProgramEnd(_) | Halt::Alarm) {
        // Blocks programmed before the alarm are executed.
        act.channel_mut().reports.alarms.stopping = false;
        if halt == Halt::Alarm {
            forget_corners(act.channel_mut());
        }
        let settled = act.flush_lookahead();
        act.channel_mut().state.place.forget_cutter();
        return settled.err().unwrap_or(halt);
    }
    held::release_held(act);
    act.channel_mut().state.place.forget_cutter();
    halt
}

/// A macro has made another code of compensation active.
pub(crate) fn switch_compensation(act: &mut ActionContext<'_, '_>) -> Acted {
    match act.channel().state.modal.code(group::DIAMETER) {
        Some(code) => switched(act, code),
        None => Ok(()),
    }
}

/// Finishes a move that has waited too long, or before a hole one with a corner at its end.
pub(crate) fn flush_due(act: &mut ActionContext<'_, '_>, hole: bool) -> Acted {
    let now = act.channel().at.blocks;
    let is_due = |waits: &WaitingMove| if hole { waits.corner.is_some() } else { now - waits.block > LONGEST_WAIT };
    let is_due = act.channel_mut().state.place.cutter().is_some_and(|cutter| cutter.waiting.iter().any(is_due));
    if is_due { act.flush_lookahead() } else { Ok(()) }
}
