//! Which spindle of a channel is active: the front or the rear one when it turns the part, the milling one when it
//! mills.
//!
//! Facts: reference control-emulator.md 3.2, 6.3, system-variables.md 9. *Invariant:* the active spindle is the one that
//! `ActionContext::command_spindle` commands. Commands of the channel for its other spindles are kept here, unless another channel
//! can command them too.

use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};

use crate::context::ActionContext;
use crate::entry::ActionEntry;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::SPINDLE_CSS_ID], |act, _, _| driver_by_id(act)),
    ActionEntry::of(&[codes::SPINDLE_FRONT], |act, _, _| in_work(act, false)),
    ActionEntry::of(&[codes::SPINDLE_REAR], |act, _, _| in_work(act, true)),
    ActionEntry::of(&[codes::APPLY_TURN], |act, _, _| apply(act, false)),
    ActionEntry::of(&[codes::APPLY_MILL], |act, _, _| apply(act, true)),
];

/// `CODE_SPINDLE_FRONT`, `CODE_SPINDLE_REAR`: their group says which one it is.
pub(crate) fn in_work(act: &mut ActionContext<'_, '_>, rear: bool) -> Acted {
    if act.channel().acting.mode_changed {
        let text = if rear { "spindle rear" } else { "spindle front" };
        act.channel_mut().emit(0, Kind::mode(text));
    }
    act.channel_mut().follow_spindle();
    Ok(())
}

/// `CODE_APPLY_TURN`, `CODE_APPLY_MILL`.
pub(crate) fn apply(act: &mut ActionContext<'_, '_>, milling: bool) -> Acted {
    if act.channel().state.others.spindles.milling != milling {
        act.channel_mut().state.others.spindles.milling = milling;
        let text = if milling { "apply mill" } else { "apply turn" };
        act.channel_mut().emit(0, Kind::mode(text));
        act.channel_mut().follow_spindle();
    }
    Ok(())
}

/// Lets an action command a spindle of the channel: `number` 0 = by codes without a number.
pub(crate) fn commanded(
    act: &mut ActionContext<'_, '_>,
    number: u16,
    action: impl FnOnce(&mut ActionContext<'_, '_>) -> Acted,
) -> Acted {
    let id = if number == 0 {
        act.channel().plain_spindle()
    } else {
        let id = act.channel().env.machine.spindles.find(|spindle| spindle.number == number);
        if id.is_none() {
            let text = format!("the machine has no spindle {number} for '{}'", act.channel().block_text());
            act.diagnose(&diag::NO_SPINDLE, text);
            drop_data(act);
            return Ok(());
        }
        id
    };
    let before = act.channel().state.spindle.id;
    act.channel_mut().select_spindle(id);
    let done = action(act);
    act.channel_mut().select_spindle(before);
    done
}

/// The head that `CODE_SPINDLE_CSS_ID` names.
pub(crate) fn driver_by_id(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(id) = act.take(data::SPINDLE_CSS_ID).map(|d| d.value) else {
        let text = format!("no head is named in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    let known = act.channel().env.machine.channels.iter().find(|channel| f64::from(channel.number) == id);
    match known.map(|channel| channel.number) {
        Some(channel) => driver(act, channel),
        None => no_head(act, id),
    }
}

/// There is no such head to drive constant surface speed.
pub(crate) fn no_head(act: &mut ActionContext<'_, '_>, id: f64) -> Acted {
    let id = counterpoint_lang::format::wildcard_text(id);
    let text = format!("head {id} for constant surface speed not found in '{}'", act.channel().block_text());
    act.diagnose(&diag::NO_HEAD, text);
    Ok(())
}

/// Removes from the block the data that a code without a spindle would have used.
pub(crate) fn drop_data(act: &mut ActionContext<'_, '_>) {
    for id in [data::SPINDLE_ORIENT, data::SPINDLE_RPM, data::SPINDLE_CSS] {
        act.take(id);
    }
}

/// The channel whose X drives constant surface speed.
pub(crate) fn driver(act: &mut ActionContext<'_, '_>, channel: u16) -> Acted {
    if !act.channel().env.machine.channels.iter().any(|known| known.number == channel) {
        return no_head(act, f64::from(channel));
    }
    act.channel_mut().state.others.spindles.driver = Some(channel);
    act.command_spindle(|c| c.driver = channel)
}
