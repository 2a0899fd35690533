//! Areas that the program sets and that the tool must not enter, or must not leave.
//!
//! Facts: Fanuc operator's manuals, stored stroke check 2 (G22 X Y Z I J K, G23); Okuma programmable stroke limits.
//! *Invariant:* the code moves nothing; limits without a word keep their previous values.

use counterpoint_fault::Acted;
use counterpoint_machine::habits::Forbidden;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_channel::stored::StoredArea;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::STORED_LIMIT_ON], |act, _, _| switch(act, true)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::STORED_LIMIT_OFF], |act, _, _| switch(act, false)).contour(CompensationEffect::Waits),
];

/// Sets the area and switches it on, or off.
fn switch(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    let habits = act.channel().env.machine.habits.stored_limits;
    let mut area = act.channel().state.place.stored.as_deref().copied().unwrap_or_default();
    if on {
        let ids = [
            [data::STORED_LIMIT_X, data::STORED_LIMIT_END_X],
            [data::STORED_LIMIT_Y, data::STORED_LIMIT_END_Y],
            [data::STORED_LIMIT_Z, data::STORED_LIMIT_END_Z],
        ];
        for (role, [high, low]) in ids.into_iter().enumerate() {
            let Some(axis) = act.channel().state.place.layout.cartesian.get(role).copied().flatten() else { continue };
            let shift = if habits.in_work_frame { act.channel().state.place.shift.at(axis) } else { 0.0 };
            let said = [low, high].map(|id| act.take(id).map(|datum| datum.value + shift));
            let Some(ends) = area.ends.get_mut(role) else { continue };
            for (end, said) in ends.iter_mut().zip(said) {
                *end = said.or(*end);
            }
            if let [Some(low), Some(high)] = *ends
                && low > high
            {
                *ends = [Some(high), Some(low)];
            }
        }
    }
    area.on = on;
    area.keep_out = habits.forbidden == Forbidden::Inside;
    let place = &mut act.channel_mut().state.place;
    place.stored = (area != StoredArea::default()).then(|| Box::new(area));
    place.layout.bounds.limited = on || place.layout.axes.iter().any(|axis| axis.limits.is_some());
    Ok(())
}
