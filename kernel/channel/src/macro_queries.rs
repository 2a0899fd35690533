//! Queries of the pipeline and of actions about the memory of macros, and of macros about the current block.
//!
//! *Invariant:* nothing here runs a macro. Facts: reference control-emulator.md 4, 5.3.

use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_machine::macros::condition::BlockIdentifier;

use crate::channel_context::ChannelContext;
use crate::macros::runtime::Runtime;
use crate::text;

/// Whether the block may hold embedded code of this kind: 0 before, 1 after the pre-processor.
pub fn has_embedded(channel: &ChannelContext<'_>, macros: &Runtime, kind: usize) -> bool {
    let open = macros.variables.store.embedding.get(kind).map_or("", String::as_str);
    let Some(&first) = open.as_bytes().first() else { return false };
    let absent = channel.context.text.is_none() && text::is_line_without(channel, first);
    !absent && contains(&channel.text_bytes(), open.as_bytes())
}

/// Whether the block has messages, or comments and messages fire codes.
pub fn may_have_remarks(channel: &ChannelContext<'_>, macros: &Runtime) -> bool {
    !channel.block.messages.is_empty() || macros.remarks_fire(channel.context.preprocessed).contains(&true)
}

/// Whether a macro has put the position of an axis or the shape of an arc in the block.
pub fn adds_motion(channel: &ChannelContext<'_>) -> bool {
    channel.block.added.iter().any(|(id, _)| matches!(id.kind(), DataKind::Axis(_) | DataKind::Arc))
}

/// Whether data by which `$FCEDAC` fires the code of a group are in the block.
pub fn has_calling_data(channel: &ChannelContext<'_>, macros: &Runtime, group: u16) -> bool {
    let pairs = macros.modes.data_codes.as_slice();
    pairs.iter().any(|(id, of)| *of == group && block_has_data(channel, *id))
}

/// The first code macro for a code that is on, not running, and whose condition holds.
pub fn matching_code_macro(channel: &ChannelContext<'_>, macros: &Runtime, id: CodeId) -> Option<u16> {
    let defined = channel.env.machine.macros.as_deref()?;
    let list = defined.of_code(id);
    if list.is_empty() || !macros.hooks.matching {
        return None;
    }
    list.iter().find_map(|&at| {
        let named = &defined.codes[at];
        let may = macros.hooks.has_code(at) && !macros.calls.is_busy(named.code);
        let holds = || {
            named.condition.is_empty() || named.condition.holds(|item| block_has_identifier(channel, item, Some(id)))
        };
        (may && holds()).then_some(named.code)
    })
}

/// Whether an identifier is in the block; the code that acts counts as present.
pub fn block_has_identifier(channel: &ChannelContext<'_>, item: BlockIdentifier, fired: Option<CodeId>) -> bool {
    match item {
        BlockIdentifier::Code(id) => Some(id) == fired || block_has_code(channel, id),
        BlockIdentifier::Data(id) => block_has_data(channel, id),
    }
}

/// Whether a code that acts now or will act is in the block.
fn block_has_code(channel: &ChannelContext<'_>, id: CodeId) -> bool {
    waiting_code(channel, id).is_some()
}

/// Whether data are in the block.
pub fn block_has_data(channel: &ChannelContext<'_>, id: DataId) -> bool {
    let registers = channel.tables.data.registers_of[id];
    channel.block.present & registers != 0
        || channel.block.added.iter().any(|(other, _)| *other == id)
        || channel.acting.as_data.is_some_and(|handed| handed.id == id)
}

/// Position of a code that has not acted yet.
pub fn waiting_code(channel: &ChannelContext<'_>, id: CodeId) -> Option<usize> {
    let pending = channel.block.pending.iter().enumerate().skip(channel.block.next);
    let mut found = pending.filter(|(_, pending)| channel.env.machine.codes[pending.row].id == id);
    found.next().map(|(at, _)| at)
}

/// Register of the sequence numbers that the head of this channel has of its own.
pub fn own_sequence(channel: &ChannelContext<'_>) -> Option<RegisterId> {
    let own = usize::from(channel.env.kernel_number(channel.at.channel))
        .checked_sub(1)
        .and_then(|head| channel.tables.registers.head_sequences.get(head));
    own.copied().flatten()
}

/// Makes a code the active one of its group, without acting; returns the previous one.
pub fn activate_code(channel: &mut ChannelContext<'_>, id: CodeId) -> Option<CodeId> {
    let row = row_of_code(channel, id)?;
    let group = Some(channel.env.machine.codes[row].group).filter(|group| *group != 0)?;
    let before = channel.state.modal.code(group);
    channel.state.modal.activate(group, id, Some(row));
    channel.state.follow_cycle();
    channel.follow_spindle();
    channel.state.follow_clamps();
    before
}

/// The first row of a code that is switched on.
pub fn row_of_code(channel: &ChannelContext<'_>, id: CodeId) -> Option<CodeRowId> {
    channel.tables.rows_of_code[id]
}

/// Whether a text contains another text.
fn contains(text: &[u8], part: &[u8]) -> bool {
    let Some(at) = part.first().and_then(|first| memchr::memchr(*first, text)) else { return false };
    text.get(at..).is_some_and(|rest| memchr::memmem::find(rest, part).is_some())
}
