//! Clamps of axes, and whole turns that are removed from rotary axes.
//!
//! Facts: reference control-emulator.md 3.2, 6.1, 6.3. Invariant: `Place::clamped` is zero unless an axis is clamped,
//! so a motion only looks at that. Decision: a move of a clamped axis is reported and made nevertheless.

use crate::context::ActionContext;
use crate::entry::{ActionEntry, entry_of_kind};
use counterpoint_channel::clamps::Modulo;
use counterpoint_event::event::Kind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::ident::kind::CodeKind;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Clamp(axis, on) => |act, _row, _code| clamp(act, axis, on)),
    entry_of_kind!(CodeKind::Unwind(axis) => |act, _row, _code| unwind(act, axis)),
];

/// Clamps an axis or lets it go.
pub(crate) fn clamp(act: &mut ActionContext<'_, '_>, id: DataId, on: bool) -> Acted {
    let Some(axis) = act.channel().state.place.axis_of_data(id) else { return no_axis(act, id) };
    act.channel_mut().state.place.set_clamp(axis, on);
    let text = format!("{} {}", if on { "clamp" } else { "unclamp" }, act.channel().axis_name(axis));
    act.channel_mut().emit(0, Kind::mode(text));
    Ok(())
}

/// Takes whole turns off one rotary axis, or off all.
pub(crate) fn unwind(act: &mut ActionContext<'_, '_>, id: Option<DataId>) -> Acted {
    let Some(id) = id else {
        for axis in act.channel().state.place.layout.axes.ids() {
            if act.channel().state.place.layout.axes[axis].rotary {
                act.unwind_axis(axis, Modulo::Normal);
            }
        }
        return Ok(());
    };
    match act.channel().state.place.axis_of_data(id).filter(|axis| act.channel().state.place.layout.axes[*axis].rotary)
    {
        Some(axis) => act.unwind_axis(axis, Modulo::Normal),
        None => return no_axis(act, id),
    }
    Ok(())
}

fn no_axis(act: &mut ActionContext<'_, '_>, id: DataId) -> Acted {
    let text = format!(
        "channel {} has no axis of {} for '{}'",
        act.channel().at.channel,
        act.channel().env.machine.data_name(id),
        act.channel().block_text()
    );
    act.diagnose(&diag::AXIS_NOT_IN_CHANNEL, text);
    Ok(())
}
