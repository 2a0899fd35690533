//! Stage *codes*, on machines where an axis moves by a change of the length: adds the move of that axis.
//!
//! Facts: parameter 5006#6 of Fanuc controls at 0; B-63844EN/02 14.1.1 (a block without the axis moves it by the
//! offset). Decisions: docs/emulation.md, "Offsets". *Invariant:* a programmed word for the axis does not change.
//! Without such a word, a block with a straight move gets a distance of 0, to which the change of the length is added.

use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::BySlot;
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::Word;

use crate::channel_context::ChannelContext;
use crate::modal::group;
use crate::offset_tables::BASE;

/// Moves the axis of the tool if a code or a number of the block changes the length and no word moves the axis.
#[cold]
pub fn length_words(channel: &mut ChannelContext<'_>) {
    let Some(length) = length_after(channel) else { return };
    let Some(slot) = channel.state.place.layout.cartesian.get(2).copied().flatten() else { return };
    let id = channel.state.place.layout.axes[slot].data;
    let stays = length == channel.tool_shift().at(slot);
    let Some(source) = channel.tables.sources_of(id).first() else { return };
    if stays || channel.block.has_any(channel.tables.registers_of(id)) || !moves_straight(channel) {
        return;
    }
    let place = channel.block.words.len();
    channel.block.push(Word {
        register: source.register,
        incremental: true,
        used: false,
        made: false,
        value: 0.0,
        start: 0,
        end: 0,
    });
    channel.block.index_word(place);
}

/// The length that a code or a number of the block makes active.
fn length_after(channel: &ChannelContext<'_>) -> Option<f64> {
    let machine = channel.env.machine;
    let in_force = channel.state.place.in_force;
    let said = channel.block.pending.iter().rev().find_map(|code| match machine.codes[code.row].id.kind() {
        CodeKind::Length { sign, .. } => Some(f64::from(sign)),
        _ => None,
    });
    let word = channel.tables.sources_of(data::COMP_LENGTH).iter().find_map(|of| channel.block.look(of.register));
    let sign = said.or_else(|| {
        word.filter(|_| in_force.length_sign != 0.0 && number_is_free(channel)).map(|_| in_force.length_sign)
    })?;
    if sign == 0.0 && channel.state.place.tip().is_some_and(|tip| tip.with_length) {
        return None;
    }
    let slot = channel.state.place.layout.cartesian.get(2).copied().flatten()?;
    let number = word.map_or(channel.state.remembered.length(), |word| word.value as u32);
    Some(if number == BASE { 0.0 } else { sign * channel.worn_length(number).at(slot) })
}

/// Whether no code of the block takes the number of a length for itself.
fn number_is_free(channel: &ChannelContext<'_>) -> bool {
    let takers = &channel.tables.rules.number_takers;
    let taken = channel.block.pending.iter().fold(0, |bits, pending| bits | takers[pending.row]);
    channel.block.has_any(channel.tables.registers.length & !taken)
}

/// Whether the block has a straight move: no arc, no cycle, no code that has the axis words for itself.
fn moves_straight(channel: &ChannelContext<'_>) -> bool {
    let machine = channel.env.machine;
    let rows = || channel.block.pending.iter().map(|code| &machine.codes[code.row]);
    let leaves = |row: &CodeRow| row.owns_axes || row.id == codes::POSITION_MACHINE;
    let queued = |group| rows().rev().find(|row| row.group == group).map(|row| row.id);
    let active = |group| queued(group).or_else(|| channel.state.modal.code(group));
    !rows().any(leaves)
        && active(group::CYCLE).is_none_or(|code| code == codes::CYCLE_OFF)
        && active(group::MOTION).is_some_and(|code| matches!(code, codes::RAPID | codes::INTERP_LINEAR))
}
