//! The codes of a block that wait to act.
//!
//! Facts: reference control-emulator.md 2, 4.1. *Invariant:* a code acts by its order, and left to right among equals.

use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{DataId, codes};
use counterpoint_machine::index::{CodeRowId, DataRowId, RegisterId};
use counterpoint_machine::rows::{CodeForm, CodeRow, Modality};
use counterpoint_machine::{Machine, ident};
use counterpoint_program::block::PendingCode;

use crate::channel_context::{ChannelContext, Handed};
use crate::macro_queries::{adds_motion, has_calling_data};
use crate::macros::runtime::Runtime;
use crate::modal::group;

/// Treats a word that is not a code: data if a row knows its register, otherwise unknown text.
pub fn data_word(channel: &mut ChannelContext<'_>, position: usize) {
    let Some(word) = channel.block.words.get(position).copied() else { return };
    let known = !channel.env.machine.tables.data_of(word.register).is_empty();
    if Some(word.register) == channel.tables.registers.definition {
        channel.block.use_word(position);
    } else if known {
        channel.block.index_word(position);
    } else {
        channel.block.use_word(position);
        channel.block.unrecognised.push((word.start, word.end));
    }
}

/// Whether some of the data that fire a code remain; data taken meanwhile fire nothing.
#[cold]
pub fn still_fires(channel: &ChannelContext<'_>, macros: &Runtime, group: u16) -> bool {
    let moves = group == group::MOTION || group == group::CYCLE;
    moves && (channel.block.has_any(channel.tables.registers.motion) || adds_motion(channel))
        || has_calling_data(channel, macros, group)
}

/// Whether a code of a group has yet to act on this block.
pub fn group_queued(channel: &ChannelContext<'_>, group: u16) -> bool {
    channel.block.pending.iter().any(|f| channel.env.machine.codes[f.row].group == group)
}

/// Sorts the codes by order, left to right among equals (insertion sort: a block has few codes).
#[inline(always)]
pub fn sort_codes(channel: &mut ChannelContext<'_>) {
    let pending = &mut channel.block.pending;
    for end in 1..pending.len() {
        let mut at = end;
        while at > 0 && pending.get(at - 1).map(|f| f.order) > pending.get(at).map(|f| f.order) {
            pending.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// Steps before a code acts: it is remembered if it is a function, hands over its data, becomes active in its modal
/// group.
#[inline(always)]
pub fn enter_code(channel: &mut ChannelContext<'_>, row: &CodeRow, pending: PendingCode) {
    if !pending.modal
        && let CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } = row.form
        && Some(register) == channel.tables.registers.function
        && !matches!(row.id, codes::CALSUB_ID | codes::CALSUB_RETURN)
    {
        channel.state.remembered.remember_function(pending.value);
    }
    channel.acting.as_data = data_of_code(channel.env.machine, row, pending);
    channel.acting.mode_changed = channel.state.modal.code(row.group) != Some(row.id);
    match row.modality {
        Modality::NonModal if row.group != 0 && !pending.modal => channel.state.modal.refire_once(row.group),
        Modality::NonModal => {}
        Modality::Modal => channel.state.modal.activate(row.group, row.id, Some(pending.row)),
        Modality::Persistent => channel.state.modal.activate_persistent(row.group, row.id, Some(pending.row)),
    }
}

/// Loads the start state of the machine: these codes become active without acting. A form of the tool direction
/// among them is the one in which programs write directions.
pub fn initial_codes(channel: &mut ChannelContext<'_>) {
    for &id in &channel.env.machine.initial {
        let row = channel.env.machine.codes.entries().find(|(_, row)| row.id == id);
        if let Some((index, row)) = row {
            channel.state.modal.activate(row.group, id, Some(index));
        } else if let Some(facts) = ident::code_facts(id) {
            channel.state.modal.activate(facts.group, id, None);
        }
        if let CodeKind::TipFormat(format) = id.kind() {
            channel.state.others.tip.format = format;
        }
    }
    channel.state.secondary = channel.state.says_secondary();
}

/// Queues the active code of a group.
pub fn queue_modal(channel: &mut ChannelContext<'_>, group: u16) {
    if let Some(index) = channel.state.modal.row(group) {
        let row = &channel.env.machine.codes[index];
        let value = match row.form {
            CodeForm::RegisterAsData { min, .. } => min,
            _ => 0.0,
        };
        channel.block.queue(index, row, value, true);
    }
}

/// Value that a code hands over as data.
#[inline]
pub fn data_of_code(machine: &Machine, row: &CodeRow, pending: PendingCode) -> Option<Handed> {
    match row.form {
        CodeForm::RegisterAsData { register, data, .. } => {
            let raw = pending.value * row.mul + row.add;
            Some(Handed { id: data, raw, row: row_of_handed(machine, data, register) })
        }
        _ => None,
    }
}

/// The data row that takes a value of a code: the row of its register, or a row without a register.
fn row_of_handed(machine: &Machine, data: DataId, register: RegisterId) -> Option<DataRowId> {
    let of = |wanted| machine.tables.data(data).iter().copied().find(|&row| machine.data[row].register == wanted);
    of(Some(register)).or_else(|| of(None))
}

/// The literal text of a row of the code table.
pub fn literal_of<'a>(channel: &ChannelContext<'a>, row: CodeRowId) -> Option<&'a str> {
    match &channel.env.machine.codes[row].form {
        CodeForm::Text(text) => Some(text),
        _ => None,
    }
}
