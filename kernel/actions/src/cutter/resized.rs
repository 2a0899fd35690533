//! A change of the offset value while compensation is active on the same side.
//!
//! The move of the block starts at the end point of the old radius and ends at the end point of the new radius
//! (B-63844EN/02 14.4.4, change of the offset amount). *Invariant:* the pending move does not change: its end is that
//! of the old radius.

use counterpoint_channel::cutter::{CompensationStage, ProgrammedMove};
use counterpoint_channel::modal::group;
use counterpoint_channel::tool_radius::{cutter_radius, nose_tip};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_motion::contour::corner::Link;
use counterpoint_motion::contour::element::Element;

use super::{before, compensated_plane, contour_allowance, no_radius, switched};
use crate::context::ActionContext;
use crate::cutter::moves::{cutter_offset, make_links};
use crate::entry::CompensationEffect;

/// The active number has changed while this code is active.
pub(crate) fn resized(act: &mut ActionContext<'_, '_>, code: CodeId) -> Acted {
    before(act, CompensationEffect::Waits, code)?;
    let number = act.channel().diameter_in_force().unwrap_or(0);
    let radius = cutter_radius(act.channel(), number) + contour_allowance(act);
    act.channel().check_stop()?;
    let plane = compensated_plane(act).map(|(plane, _)| plane);
    let tip = plane.map_or([0.0; 2], |plane| nose_tip(act.channel(), number, plane)).map(|part| part * radius);
    let begun = act.channel_mut().state.place.cutter().filter(|cutter| !cutter.plain && !cutter.suspended).is_some_and(
        |cutter| {
            !matches!(cutter.stage, CompensationStage::Ending(_) | CompensationStage::Turned)
                && (cutter.stage != CompensationStage::Start || !cutter.waiting.is_empty())
        },
    );
    let cancels = number == 0 && act.channel().env.machine.compensation.zero_cancels;
    if !begun || radius < 0.0 || cancels {
        return switched(act, code);
    }
    if radius == 0.0 {
        no_radius(act, number);
    }
    if let Some(cutter) = act.channel_mut().state.place.cutter() {
        cutter.resized = Some((radius, tip));
    }
    Ok(())
}

/// Another number is active, with or without compensation.
pub(crate) fn resize_compensation(act: &mut ActionContext<'_, '_>) -> Acted {
    match act.channel().state.modal.code(group::DIAMETER) {
        Some(code @ (codes::COMP_DIAM_LEFT | codes::COMP_DIAM_RIGHT)) => resized(act, code),
        _ => Ok(()),
    }
}

/// The radius that a number of the block has selected counts from the end of its move on; an arc begins beside its
/// start.
pub(crate) fn resize(act: &mut ActionContext<'_, '_>, step: &ProgrammedMove, element: &Element) -> Acted {
    let Some(cutter) = act.channel_mut().state.place.cutter() else { return Ok(()) };
    let Some((radius, tip)) = cutter.resized.take() else { return Ok(()) };
    (cutter.radius, cutter.tip) = (radius, tip);
    let cutter = cutter.clone();
    if element.arc.is_none() {
        return Ok(());
    }
    let start = cutter_offset(act.channel(), &cutter).at_start(element);
    make_links(act, (step, element), &cutter, &[Link::Line(start)], act.channel().state.place.position)
}
