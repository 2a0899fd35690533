//! Moves the positioning axes that no move of their block has taken along.

use crate::act::Act;
use crate::action::entry::Entry;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;

/// Codes with their actions.
pub(crate) const ENTRIES: &[Entry] = &[Entry::of(&[codes::AXES_BESIDE], |act, _, _| arrive(act))];

fn arrive(act: &mut Act<'_, '_>) -> Acted {
    let Some(beside) = act.channel_mut().state.others.beside.take() else { return Ok(()) };
    match act.channel().move_beside(&beside) {
        Some(motion) => act.travel(beside.seconds, &motion),
        None => Ok(()),
    }
}
