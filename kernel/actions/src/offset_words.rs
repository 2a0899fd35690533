//! Offset numbers without their codes, and places where length compensation ends.
//!
//! On controls of the Fanuc kind the number belongs to its word: H under G43 or G44 and D under G41 or G42 select
//! another offset in a block without the code. Facts: B-63844EN/02 14.1.1 and 14.1.2 (H, G28, G30, G53), parameters
//! 5001#6 and 5006#6; Haas 96-8000, G28. *Invariant:* a word that a code of the block takes is left to that code.

use counterpoint_event::event::{Kind, OffsetKind};
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::model::{LengthInMachineFrame, LengthThere};

use crate::context::ActionContext;
use counterpoint_channel::modal::group;

/// Selects the offsets whose numbers are in the block; `free`: registers whose words no code of the block takes, one
/// bit each.
pub(crate) fn select(act: &mut ActionContext<'_, '_>, free: u128) -> Acted {
    let has = |act: &ActionContext<'_, '_>, id| act.channel().block.has_any(act.registers_of(id) & free);
    if has(act, data::COMP_LENGTH) && act.channel().state.place.in_force.length_sign != 0.0 {
        let number = act.take(data::COMP_LENGTH).map_or(0, |_| act.channel().state.remembered.length());
        let sign = act.channel().state.place.in_force.length_sign;
        put_length(act, sign, number);
        let text = format!("comp length n={number}");
        act.channel_mut().emit(0, Kind::compensation(text, OffsetKind::Length, f64::from(number)));
        length_changed(act);
    }
    let Some(code) = act.channel().state.modal.code(group::DIAMETER) else { return Ok(()) };
    let side = match code {
        codes::COMP_DIAM_LEFT => "left",
        codes::COMP_DIAM_RIGHT => "right",
        _ => return Ok(()),
    };
    let queued = act
        .channel()
        .block
        .pending
        .iter()
        .any(|code| act.channel().env.machine.codes[code.row].group == group::DIAMETER);
    if queued || act.channel().is_turning() || !has(act, data::COMP_DIAM) {
        return Ok(());
    }
    let Some(number) = super::tool_offsets::take_diameter(act) else { return Ok(()) };
    super::cutter::resized(act, code)?;
    let text = format!("comp diam {side} n={}", counterpoint_lang::format::wildcard_text(number));
    act.channel_mut().emit(0, Kind::compensation(text, OffsetKind::Diameter, number));
    act.report_tool();
    Ok(())
}

/// Activates a length offset; the caller must then rebuild the frame.
pub(crate) fn put_length(act: &mut ActionContext<'_, '_>, sign: f64, number: u32) {
    let before = act.channel().state.place.in_force;
    if sign != 0.0 && (before.length_sign == 0.0 || before.length_number != number) {
        super::tool_offsets::missing_among_listed(act, number);
    }
    act.channel_mut().state.place.in_force.set_length(sign, number);
}

/// Makes a change of the length active. On machines where the axis of the tool moves by the change, its next move
/// includes the change. Exceptions are blocks with a code that takes the axis words itself (G28) or gives positions of
/// the machine frame (G53).
pub(crate) fn length_changed(act: &mut ActionContext<'_, '_>) {
    let machine = act.channel().env.machine;
    act.channel_mut().block.flags.travels = machine.compensation.length.moves
        && !act.channel().block.pending.iter().any(|code| {
            let row = &machine.codes[code.row];
            row.owns_axes || row.id == codes::POSITION_MACHINE
        });
    act.reframe();
    act.channel_mut().block.flags.travels = false;
}

/// Axes have come to a reference point.
pub(crate) fn at_reference(act: &mut ActionContext<'_, '_>, axes: u8) {
    match act.channel().env.machine.compensation.length.at_reference {
        LengthThere::Stays => {}
        LengthThere::Off => take_off(act, axes),
        LengthThere::Ends
            if act.channel().state.place.in_force.length_sign != 0.0 && act.channel().state.place.tip().is_none() =>
        {
            let machine = act.channel().env.machine;
            let row = machine.codes.entries().find(|(_, row)| row.enable && row.id == codes::COMP_LENGTH_OFF);
            if let Some((place, row)) = row {
                act.channel_mut().state.modal.activate(row.group, row.id, Some(place));
            }
            put_length(act, 0.0, 0);
            act.channel_mut().emit(0, Kind::mode("comp length off"));
            act.reframe();
        }
        LengthThere::Ends => {}
    }
}

/// Axes go to positions of the machine frame.
pub(crate) fn in_machine_frame(act: &mut ActionContext<'_, '_>, axes: u8) {
    if act.channel().env.machine.compensation.length.in_machine_frame == LengthInMachineFrame::Off {
        take_off(act, axes);
    }
}

fn take_off(act: &mut ActionContext<'_, '_>, axes: u8) {
    if act.channel().state.place.tip().is_none() && act.channel_mut().take_length_off(axes) {
        act.reframe();
    }
}

/// Length compensation that another code brings along.
pub(crate) fn length_on(act: &mut ActionContext<'_, '_>, number: u32) {
    put_length(act, 1.0, number);
    act.channel_mut()
        .emit(0, Kind::compensation(format!("comp length n={number}"), OffsetKind::Length, f64::from(number)));
    act.reframe();
}
