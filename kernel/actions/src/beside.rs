//! Moves the positioning axes that no move of their block has taken along.

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[ActionEntry::of(&[codes::AXES_BESIDE], |act, _, _| arrive(act))];

fn arrive(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(beside) = act.channel_mut().state.others.beside.take() else { return Ok(()) };
    match act.channel().state.move_beside(&beside) {
        Some(motion) => act.travel(beside.seconds, &motion),
        None => Ok(()),
    }
}
