//! Limits of the working area: G25 and G26 set them, and those of the speed; WALIMON and WALIMOF switch them.
//!
//! Facts: see `counterpoint_channel::area`. *Invariant:* no axis moves.

use counterpoint_fault::Acted;
use counterpoint_machine::ident::{codes, data};

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use crate::motion::take_axis;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::WORK_AREA_LOW], |act, _, _| limits(act, false)),
    ActionEntry::of(&[codes::WORK_AREA_HIGH], |act, _, _| limits(act, true)),
    ActionEntry::of(&[codes::WORK_AREA_ON], |act, _, _| switch(act, false)),
    ActionEntry::of(&[codes::WORK_AREA_OFF], |act, _, _| switch(act, true)),
];

fn limits(act: &mut ActionContext<'_, '_>, high: bool) -> Acted {
    for axis in act.channel().state.place.layout.axes.ids() {
        let Some(datum) = take_axis(act, axis).filter(|datum| datum.value.is_finite()) else { continue };
        if let Some(side) = act.channel_mut().work_area().side(axis, high) {
            side.limit = Some(datum.value);
        }
    }
    match act.take(data::SPINDLE_RPM_MAX).map(|datum| datum.value) {
        Some(limit) if high => act.command_spindle(|command| command.limit = limit),
        Some(least) => act.command_spindle(|command| command.least = least),
        None => Ok(()),
    }
}

fn switch(act: &mut ActionContext<'_, '_>, off: bool) -> Acted {
    // Without limits it is on.
    if off || act.channel().state.others.area.is_some() {
        act.channel_mut().work_area().off = off;
    }
    Ok(())
}
