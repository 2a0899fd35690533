//! The work frame: presets, work offsets, tool offsets, length compensation.
//!
//! *Invariant:* changing the frame never moves the machine; only the programmed position changes.

use counterpoint_channel::modal::group;
use counterpoint_event::event::{Kind, OffsetKind};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisId, BySlot};
use counterpoint_program::block::PendingCode;

use super::offset_words::{in_machine_frame, length_changed, put_length};
use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect, entry_of_kind};
use crate::polar_words::without_polar_words;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::POSITION_MACHINE], |act, _, _| machine_frame(act)).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::POSITION_PRESET], |act, _, _| preset(act)),
    ActionEntry::of(&[codes::POSITION_PRESET_OFF], |act, _, _| preset_off(act)),
    ActionEntry::of(&[codes::COMP_WORKP_ON], |act, _, _| work_offset(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::COMP_WORKP_OFF], |act, _, _| work_offset_off(act)).contour(CompensationEffect::Waits),
    entry_of_kind!(CodeKind::Length { sign, set } => |act, _row, _code| length(act, sign.into(), set))
        .contour(CompensationEffect::Waits),
];

/// This block's positions are in the machine frame. In incremental mode the word is ignored: distances are distances in
/// any frame.
pub(crate) fn machine_frame(act: &mut ActionContext<'_, '_>) -> Acted {
    // The mode that the block says, wherever it says so, otherwise the active one.
    let code = |pending: &PendingCode| Some(&act.channel().env.machine.codes[pending.row]).filter(|row| row.enable);
    let rows = act.channel().block.pending.iter().rev().filter_map(code);
    let said = rows.filter(|row| row.group == group::POSITION).map(|row| row.id).next();
    let mode = said.or_else(|| act.channel().state.modal.code(group::POSITION));
    if mode == Some(codes::POSITION_RELATIVE) {
        let text = format!("machine coordinates are ignored in incremental mode in '{}'", act.channel().block_text());
        act.diagnose(&diag::MACHINE_INCREMENTAL, text);
        return Ok(());
    }
    let axes = act.channel().state.place.layout.axes.entries();
    let named = axes.filter(|(_, axis)| act.channel().block.has_any(act.registers_of(axis.data)));
    let named = named.fold(0, |slots, (slot, _)| slots | slot.bit());
    in_machine_frame(act, named);
    if !act.channel().state.others.couplings.is_empty() {
        act.added_to(named, "PS0364 machine coordinates of an axis to which moves are added")?;
    }
    act.channel_mut().block.flags.machine_frame = true;
    Ok(())
}

/// The position of the axes gets the programmed values.
pub(crate) fn preset(act: &mut ActionContext<'_, '_>) -> Acted {
    if act.channel().state.place.tilted().is_some() {
        let text = format!("a preset is not possible in a tilted plane, '{}' sets nothing", act.channel().block_text());
        return Err(act.alarm(&diag::FRAME_REFUSED, text));
    }
    if act.channel().env.machine.habits.preset_ends_shift && act.channel().state.place.frames.is_some() {
        let axes = act.channel().state.place.layout.axes.entries();
        let named = axes.filter(|(_, axis)| act.channel().block.has_any(act.registers_of(axis.data)));
        let named = named.fold(0, |slots, (slot, _)| slots | slot.bit());
        super::local::end_shift(act, named);
    }
    // Nothing turns: words are positions, also of axes whose words are angles.
    let angles = std::mem::take(&mut act.channel_mut().state.place.layout.angles);
    let (coded, target) = without_polar_words(act, |act| act.targets());
    act.channel_mut().state.place.layout.angles = angles;
    if coded == 0 {
        return Ok(());
    }
    let turned = act.channel().state.place.frames.is_some();
    let stands = act.channel().state.place.contour();
    for (index, value) in target.iter().enumerate() {
        if (turned || coded & (1 << index) != 0)
            && let (Some(preset), Some(position)) =
                (act.channel_mut().state.place.preset.get_mut(index), stands.get(index))
        {
            *preset += position - value;
        }
    }
    act.reframe();
    Ok(())
}

/// Ends presets and the local shift of the axes that the block names.
fn preset_off(act: &mut ActionContext<'_, '_>) -> Acted {
    let mut coded = 0_u8;
    for slot in act.channel().state.place.layout.axes.ids() {
        let id = act.channel().state.place.layout.axes[slot].data;
        if act.take(id).is_some() {
            coded |= slot.bit();
            *act.channel_mut().state.place.preset.at_mut(slot) = 0.0;
        }
    }
    super::local::end_shift(act, coded);
    act.reframe();
    act.channel_mut().emit(0, Kind::mode("preset off"));
    Ok(())
}

/// Selects a work offset.
pub(crate) fn work_offset(act: &mut ActionContext<'_, '_>) -> Acted {
    let number = act.take(data::COMP_WORKP).map_or(1.0, |d| d.value);
    let number = if (1.0..=999.0).contains(&number) { number as u32 } else { 0 };
    missing_work_offset(act, number);
    let before = std::mem::replace(&mut act.channel_mut().state.place.in_force.work_offset, number);
    super::local::exchange_shifts(act, before, number);
    act.channel_mut().emit(0, Kind::mode(format!("comp workp n={number}")));
    act.reframe();
    Ok(())
}

/// Cancels work offsets.
pub(crate) fn work_offset_off(act: &mut ActionContext<'_, '_>) -> Acted {
    act.channel_mut().state.place.in_force.work_offset = 0;
    act.channel_mut().emit(0, Kind::mode("comp workp off"));
    act.reframe();
    Ok(())
}

/// Tool length compensation of a type (1 to 4) with the H word; sign 0 cancels.
pub(crate) fn length(act: &mut ActionContext<'_, '_>, sign: f64, set: u8) -> Acted {
    let asks = sign != 0.0 || act.block_has(data::COMP_LENGTH);
    let number = if asks { act.take(data::COMP_LENGTH).map(|d| d.value) } else { None };
    let ends_tip = sign == 0.0 && act.channel().state.place.tip().is_some_and(|tip| tip.with_length);
    if ends_tip {
        super::tip::off(act)?;
    }
    let mode = if sign == 0.0 {
        put_length(act, 0.0, 0);
        Kind::mode("comp length off")
    } else {
        let number = number.filter(|n| (0.0..=999_999.0).contains(n)).map(|number| number as u32);
        let number = number.unwrap_or(act.channel().state.place.in_force.length_number);
        put_length(act, sign, number);
        act.channel_mut().state.place.compensation.set = set;
        let text = match set {
            1 => format!("comp length n={number}"),
            _ => format!("comp length n={number} set={set}"),
        };
        Kind::compensation(text, OffsetKind::Length, f64::from(number))
    };
    act.channel_mut().emit(0, mode);
    if ends_tip {
        act.reframe();
    } else {
        length_changed(act);
    }
    Ok(())
}

/// Reports a work offset that has no values, if the machine or its table of tools gives values to other work
/// offsets. Otherwise all are at the part zero, as G54 is.
pub(crate) fn missing_work_offset(act: &mut ActionContext<'_, '_>, number: u32) {
    let offsets = &act.channel().env.machine.work_offsets;
    let is_given = |(axis, value): (AxisId, &f64)| *value != act.channel().env.machine.axes[axis].positioning.part_zero;
    let known = offsets.iter().any(|values| values.entries().any(is_given));
    let set = act.channel().state.place.offsets.as_deref().is_some_and(|offsets| offsets.has_work(number));
    if known && number as usize > offsets.len() && !set {
        let text = format!(
            "work offset {number} has no values in machine {}; the part zero of the machine is used",
            act.channel().env.machine.name
        );
        act.diagnose(&diag::NO_OFFSET, text);
    }
}
