//! Corners between the moves of a contour, with compensation and without.
//!
//! A move with a corner waits until the next one is known, as under compensation; without compensation the waiting is
//! that of a tool that stays on the contour. *Invariant:* the moves of a corner belong to the block that asked for it,
//! and come right after the move of that block. Facts: reference turning-cycles.md 7, siemens-cycles.md.

use counterpoint_channel::corner::{ContourRequest, CornerDirection, CornerRequest};
use counterpoint_channel::modal::group;
use counterpoint_event::event::FeedUnit;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_motion::contour::blend::{CornerBlend, TooLong, blend, blend_reduced};
use counterpoint_motion::contour::element::{Element, NOISE, Spot, plus};

use super::{CompensationStage, CutterCompensation, MoveShape, ProgrammedMove, WaitingMove, compensated_plane};
use crate::context::ActionContext;
use crate::cutter::moves::{along, next_element};
use crate::entry::CompensationEffect;

/// Moves of the plane wait from here on, where compensation does not make them wait; whether there is a plane.
pub(crate) fn take_part(act: &mut ActionContext<'_, '_>) -> bool {
    if act.channel().state.place.is_compensated() {
        return true;
    }
    let Some((_, axes)) = compensated_plane(act) else {
        let text =
            format!("no plane with both axes is active for the corner or angle of '{}'", act.channel().block_text());
        act.diagnose(&diag::CORNER_REFUSED, text);
        return false;
    };
    let new = CutterCompensation {
        side: 0.0,
        radius: 0.0,
        tip: [0.0; 2],
        axes,
        contour: act.channel().state.place.position,
        stage: CompensationStage::On,
        waiting: Vec::new(),
        idle: 0,
        seen: act.channel().at.blocks,
        ended: act.channel().at.line,
        suspended: false,
        plain: true,
        asked: ContourRequest::default(),
        smooth: None,
        resized: None,
    };
    act.channel_mut().state.place.frames().cutter = Some(Box::new(new));
    true
}

/// Effect of an action on corners: moves along the contour may wait, also while a spindle that only this channel uses
/// is commanded; any other action ends the waiting.
pub(crate) fn follow(act: &mut ActionContext<'_, '_>, contour: CompensationEffect) -> Acted {
    let rounds = act.channel().state.place.frames.as_deref().is_some_and(|frames| frames.rounding.is_some());
    let shared = act.channel().state.spindle.shared;
    if let Some(cutter) = act.channel_mut().state.place.cutter().filter(|cutter| cutter.plain) {
        let axes = cutter.axes;
        let stays = match contour {
            CompensationEffect::Waits => true,
            CompensationEffect::Follows => {
                !act.channel().block.flags.machine_frame
                    && compensated_plane(act).is_some_and(|(_, active)| active == axes)
            }
            CompensationEffect::Commands => !shared,
            CompensationEffect::Leaves | CompensationEffect::Ends => false,
        };
        if !stays {
            act.flush_lookahead()?;
            let plane = compensated_plane(act);
            match act.channel_mut().state.place.cutter() {
                // A path to the contour is still to come, in the plane that is active then.
                Some(cutter) if cutter.smooth.is_some() => {
                    if let Some((_, axes)) = plane {
                        cutter.axes = axes;
                    }
                }
                _ => act.channel_mut().state.place.forget_cutter(),
            }
        }
    }
    if rounds
        && contour == CompensationEffect::Follows
        && !act.channel().state.place.is_compensated()
        && !act.channel().block.flags.machine_frame
    {
        take_part(act);
    }
    Ok(())
}

/// Ends the waiting: without compensation and modal rounding, moves are plain again.
pub(crate) fn end(act: &mut ActionContext<'_, '_>) {
    let rounds = act.channel().state.place.frames.as_deref().is_some_and(|frames| frames.rounding.is_some());
    if !rounds
        && act
            .channel_mut()
            .state
            .place
            .cutter()
            .is_some_and(|cutter| cutter.plain && cutter.waiting.is_empty() && cutter.smooth.is_none())
    {
        act.channel_mut().state.place.forget_cutter();
    }
}

/// The corner at the end of a move: its own, or the modal one.
fn corner_at_end(act: &mut ActionContext<'_, '_>, rapid: bool) -> Option<CornerRequest> {
    let asked =
        act.channel_mut().state.place.cutter().map(|cutter| std::mem::take(&mut cutter.asked)).unwrap_or_default();
    let rounding = act.channel().state.place.frames.as_deref().and_then(|frames| frames.rounding);
    let modal = act.channel().state.remembered.value(data::CORNER_FEED_MODAL).filter(|feed| *feed > 0.0);
    let feed = asked.feed.or(modal);
    let all = rounding.map(|radius| CornerRequest { cut: CornerBlend::Round(radius), side: None, feed, modal: true });
    asked
        .corner
        .or_else(|| all.filter(|_| !rapid && act.channel().state.modal.code(group::MOTION) != Some(codes::RAPID)))
}

/// Puts corners between the moves that wait and between the last of them and a new one, which becomes shorter.
pub(crate) fn cut_corners(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove, element: &mut Element) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter().filter(|cutter| cutter.is_due()) else {
        return Ok(());
    };
    let waiting = std::mem::take(&mut cutter.waiting);
    let mut made: Vec<WaitingMove> = Vec::with_capacity(waiting.len() + 2);
    let mut due: Option<(usize, CornerRequest)> = None;
    for mut next in waiting {
        if let Some(second) = &mut next.element
            && let Some((at, corner)) = due.take()
        {
            cut_corner(act, &mut made, (at, corner), (&next.step, second));
        }
        if let Some(corner) = next.corner.take_if(|_| next.element.is_some()) {
            due = Some((made.len(), corner));
        }
        made.push(next);
    }
    if let Some((at, corner)) = due {
        cut_corner(act, &mut made, (at, corner), (step, element));
    }
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        cutter.waiting = made;
    }
    act.channel().check_stop()
}

/// Puts a corner after a move that waits.
fn cut_corner(
    act: &mut ActionContext<'_, '_>,
    made: &mut Vec<WaitingMove>,
    (at, corner): (usize, CornerRequest),
    next: (&ProgrammedMove, &mut Element),
) {
    let Some(before) = made.get_mut(at) else { return };
    let Some(mut first) = before.element else { return };
    let Some(between) = corner_element(act, corner, (&before.step, &mut first), next) else { return };
    let mut step = before.step.clone();
    if step.unit == FeedUnit::InverseTime {
        let feed = step.feed.map(|feed| feed * first.length());
        (step.feed, step.unit) = (feed, FeedUnit::PerMinute);
    }
    step.feed = corner.feed.or(step.feed);
    step.shape = match (between.arc, act.channel_mut().state.place.cutter()) {
        (Some(made), Some(cutter)) => MoveShape::Circle { made, axes: cutter.axes, turns: 0 },
        _ if matches!(step.shape, MoveShape::Rapid) => MoveShape::Rapid,
        _ => MoveShape::Linear,
    };
    // A corner may take the whole move.
    before.element = Some(first).filter(|first| first.length() >= NOISE);
    let after = WaitingMove { step, element: Some(between), ..before.clone() };
    made.insert(at + 1, after);
}

/// The element of a corner; none if there is no corner or it cannot be made, which is reported.
fn corner_element(
    act: &mut ActionContext<'_, '_>,
    corner: CornerRequest,
    (before, first): (&ProgrammedMove, &mut Element),
    (after, second): (&ProgrammedMove, &mut Element),
) -> Option<Element> {
    let rules = act.channel().env.machine.corners;
    let block = act.channel().block_text();
    if matches!(after.shape, MoveShape::Rapid) && !rules.rapid {
        if !corner.modal {
            let text = format!("the corner before '{block}' needs a move at feed after it");
            act.diagnose(&diag::CORNER_NEXT, text);
        }
        return None;
    }
    if let Some(side) = corner.side {
        check_side(act, side, (before, first), (after, second))?;
    }
    let made = match rules.reduces {
        true => Ok(blend_reduced(first, second, corner.cut)),
        false => blend(first, second, corner.cut).map(|made| (made, false)),
    };
    match made {
        Ok((made, false)) => made,
        Ok((made, true)) => {
            let text = format!("the corner before '{block}' is larger than its lines; it is made smaller");
            if !corner.modal {
                act.diagnose(&diag::CORNER_TOO_LONG, text);
            }
            made
        }
        Err(TooLong) => {
            let text = format!(
                "a corner of {} does not fit between the move before '{block}' and this one",
                counterpoint_lang::format::wildcard_text(corner.cut.size())
            );
            act.diagnose(&diag::CORNER_TOO_LONG, text);
            None
        }
    }
}

/// A corner with a direction is between lines parallel to axes, and the second one goes in that direction.
fn check_side(
    act: &mut ActionContext<'_, '_>,
    side: CornerDirection,
    (before, first): (&ProgrammedMove, &Element),
    (after, second): (&ProgrammedMove, &Element),
) -> Option<()> {
    let axes = act.channel_mut().state.place.cutter().map(|cutter| cutter.axes)?;
    let block = act.channel().block_text();
    let round = |step: &ProgrammedMove| matches!(step.shape, MoveShape::Circle { .. });
    if round(before) || round(after) {
        let text = format!("the corner before '{block}' is between straight moves only");
        act.diagnose(&diag::CORNER_NEXT, text);
        return None;
    }
    let along = |way: Spot| way.iter().position(|part| part.abs() > 1.0 - 1e-9);
    let (Some(one), Some(other)) = (along(first.end()), along(second.start())) else {
        let text = format!("the corner before '{block}' is between lines parallel to axes only");
        act.diagnose(&diag::CORNER_TAPER, text);
        return None;
    };
    let axis = axes.get(other).copied();
    let goes = second.start().get(other).is_some_and(|part| *part > 0.0);
    if one == other || goes != side.positive || side.axis.is_some() && side.axis != axis {
        let text = format!("'{block}' does not go where the corner before it goes");
        act.diagnose(&diag::CORNER_ALONE, text);
        return None;
    }
    Some(())
}

/// The corner at the end of the move of this block.
pub(crate) fn corner_of(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove) -> Option<CornerRequest> {
    corner_at_end(act, matches!(step.shape, MoveShape::Rapid))
}

/// A move without a corner at its end, where only corners make moves wait.
pub(crate) fn without_waiting(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove, element: &Element) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    cutter.contour = step.to;
    let cutter = cutter.clone();
    along(act, step, &cutter, element, element.to)?;
    end(act);
    Ok(())
}

/// A move that the corner before it has taken whole: its direction is that of the corner's end.
pub(crate) fn used_up(act: &mut ActionContext<'_, '_>, step: ProgrammedMove, element: &Element) -> Acted {
    let along = act.channel_mut().state.place.cutter().and_then(|cutter| {
        let last = cutter.waiting.iter().rev().find_map(|waiting| waiting.element)?;
        Some(last.end())
    });
    let along = along.unwrap_or([1.0, 0.0]);
    let next = Element { from: element.to, to: plus(element.to, along, 1.0), arc: None };
    next_element(act, Some(&next))?;
    let corner = corner_of(act, &step);
    if corner.is_some_and(|corner| !corner.modal) {
        let text = format!("the corner of '{}' has no line left before it", act.channel().block_text());
        act.diagnose(&diag::CORNER_TOO_LONG, text);
    }
    let ended = act.channel().at.line;
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        (cutter.contour, cutter.ended) = (step.to, ended);
        cutter.stage =
            if cutter.plain { CompensationStage::On } else { CompensationStage::Settled { corner: element.to, along } };
    }
    end(act);
    act.channel().check_stop()
}

/// A corner where compensation starts or ends.
pub(crate) fn corner_at_switch(act: &mut ActionContext<'_, '_>, what: &str) {
    let Some(asked) = act.channel_mut().state.place.cutter().map(|cutter| std::mem::take(&mut cutter.asked)) else {
        return;
    };
    if !asked.is_empty() {
        let text =
            format!("'{}' switches compensation {what} and has a corner or an angle", act.channel().block_text());
        act.diagnose(&diag::CORNER_AT_COMPENSATION, text);
    }
}
