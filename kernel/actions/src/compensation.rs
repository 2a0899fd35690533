//! States of compensation: numbers, sets and directions of offsets, extended and dynamic fixtures, corners.
//!
//! Facts: reference control-emulator.md 6.6, system-variables.md 7. Decisions: docs/emulation.md, "Offsets".

use counterpoint_channel::compensation::number_of;
use counterpoint_event::event::{Kind, OffsetKind};
use counterpoint_fault::Acted;
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_program::block::ContourEnd;

use super::tool_offsets::take_diameter;
use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};
use crate::frame::missing_work_offset;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::COMP_EXTFIXT, codes::COMP_EXTFIXT_RANGE], |act, _, _| extended(act)),
    ActionEntry::of(&[codes::COMP_DYN_FIXT_ON], |act, _, _| dynamic(act, true)),
    ActionEntry::of(&[codes::COMP_DYN_FIXT_OFF], |act, _, _| dynamic(act, false)),
    ActionEntry::of(&[codes::COMP_CORNER_ARC], |act, _, _| corner(act, true)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::COMP_CORNER_LINEAR], |act, _, _| corner(act, false)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CONTOUR_ROUND], |act, _, _| round(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::COMP_3D_VECTOR], |act, _, _| vector(act)).contour(CompensationEffect::Waits),
];

/// An extended work offset: its register, in a range if the control has several.
pub(crate) fn extended(act: &mut ActionContext<'_, '_>) -> Acted {
    let range = whole(act, data::COMP_EXTFIXT_RANGE);
    let first = act.channel().env.machine.habits.first_extended.then_some(1);
    let Some(register) = whole(act, data::COMP_EXTFIXT_REG).or(first) else {
        let text = format!("an extended work offset needs its number in '{}'", act.channel().block_text());
        act.diagnose(&counterpoint_fault::DATA_MISSING, text);
        return Ok(());
    };
    let number = number_of(range.unwrap_or(1), register);
    missing_work_offset(act, number);
    let before = std::mem::replace(&mut act.channel_mut().state.place.in_force.work_offset, number);
    super::local::exchange_shifts(act, before, number);
    let text = match range {
        Some(range) => format!("comp extfixt n={range},{register}"),
        None => format!("comp extfixt n={register}"),
    };
    act.channel_mut().emit(0, Kind::mode(text));
    act.reframe();
    Ok(())
}

fn whole(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<u32> {
    act.take(id).map(|datum| datum.value).filter(|value| (0.0..=9999.0).contains(value)).map(|value| value as u32)
}

/// Dynamic fixture compensation.
pub(crate) fn dynamic(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    act.channel_mut().state.place.compensation.dynamic = on;
    super::mode::mode(act, if on { "comp dynfix on" } else { "comp dynfix off" })
}

/// Corners of compensated paths.
pub(crate) fn corner(act: &mut ActionContext<'_, '_>, arc: bool) -> Acted {
    act.channel_mut().state.place.compensation.corner = if arc { 2 } else { 1 };
    super::mode::mode(act, if arc { "comp corner arc" } else { "comp corner linear" })
}

/// The outside corner after the pending move is an arc.
fn round(act: &mut ActionContext<'_, '_>) -> Acted {
    let last = act
        .channel_mut()
        .state
        .place
        .cutter()
        .and_then(|cutter| cutter.waiting.iter_mut().rev().find(|waits| waits.element.is_some()));
    if let Some(waits) = last {
        waits.end = ContourEnd::Round;
    }
    Ok(())
}

/// The vector form of cutter compensation: number and direction.
pub(crate) fn vector(act: &mut ActionContext<'_, '_>) -> Acted {
    take_diameter(act);
    let words = [data::COMP_DIAM_P, data::COMP_DIAM_Q, data::COMP_DIAM_R].map(|id| act.take(id).map(|d| d.value));
    for (slot, word) in act.channel_mut().state.place.compensation.vector.iter_mut().zip(words) {
        *slot = word.filter(|value| value.is_finite()).unwrap_or(*slot);
    }
    let direction = act.channel().state.place.compensation.vector.map(wildcard_text).join(",");
    let number = act.channel().state.remembered.diameter();
    let text = format!("comp diam vector n={number} pqr={direction}");
    super::cutter::switched(act, codes::COMP_3D_VECTOR)?;
    act.channel_mut().emit(0, Kind::compensation(text, OffsetKind::Diameter, f64::from(number)));
    Ok(())
}
