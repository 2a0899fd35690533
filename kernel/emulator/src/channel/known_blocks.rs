//! Blocks that only lead the flow of the program on, kept by line: a call by number, a return, a head without anything
//! else.
//!
//! Such a block that comes again does the same without its text. *Invariant:* a block is kept only if nothing but where
//! the program continues depended on it: it has no words besides those of the call, no message, no mark of optional
//! skip; it is used only where nothing acts that each block may meet (a modal call, a code that acts again, paths
//! beside a contour).

use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_channel::kept_blocks::{KnownBlock, Leads};
use counterpoint_event::event::FileId;
use counterpoint_machine::ident::data;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::rows::Modality;
use counterpoint_machine::tables::form_range;

use crate::channel::custom_macro::code_calls::calls_by_words;
use crate::channel::plan::ExecutionPlan;
use crate::channel::refusals::is_block_never_refused;

/// The kept block of this line, where nothing acts that each block may meet.
#[inline(always)]
pub(crate) fn leads_on(
    plan: &ExecutionPlan,
    channel: &ChannelContext<'_>,
    flow: &ProgramFlow,
    line: (FileId, u32),
) -> Option<KnownBlock> {
    let known = *flow.known.blocks.get(line)?;
    let alone = flow.modal.is_empty()
        && channel.state.modal.refires.is_empty()
        && channel.state.place.frames.is_none()
        && !flow.watched;
    (alone && known.of_contour == plan.actions.reads_contour()).then_some(known)
}

/// Executes a kept block, up to its request at the end.
#[inline(always)]
pub(crate) fn execute_known_block(channel: &mut ChannelContext<'_>, flow: &mut ProgramFlow, known: &KnownBlock) {
    channel.block.clear();
    channel.block.sequence = known.sequence;
    flow.pending = match known.leads {
        Leads::On => None,
        Leads::Return => Some(Pending::Return(None)),
        Leads::Call { program, passes } => {
            Some(Pending::Call { what: Callee::Program(program), passes, arguments: None, by: None })
        }
    };
}

/// Whether the block, whose words have acted, calls or returns, or has no code.
#[inline(always)]
pub(crate) fn may_only_lead_on(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> bool {
    flow.pending.is_some() || channel.block.pending.is_empty()
}

/// Keeps the block if it only continued the flow of the program. Its words have acted.
#[inline(never)]
pub(crate) fn keep_block(plan: &ExecutionPlan, channel: &ChannelContext<'_>, flow: &mut ProgramFlow, text: &[u8]) {
    let block = &channel.block;
    if flow.watched
        || channel.env.options.lint
        || channel.env.trace.is_some()
        || channel.text.edited.is_some()
        || block.words.len() > 3
        || block.has_leftovers()
        || block.has_remarks()
        || block.line_up.is_some()
        || !(block.texts.is_empty() && block.messages.is_empty() && block.added.is_empty())
        || text.contains(&b'/')
    {
        return;
    }
    let leads = match (&flow.pending, block.pending.as_slice()) {
        (None, []) if is_head_alone(channel, text) => Leads::On,
        (Some(Pending::Return(None)), [_]) if has_only_words_of_call(channel) => Leads::Return,
        (Some(Pending::Call { what: Callee::Program(program), passes, arguments: None, by: None }), [_])
            if has_only_words_of_call(channel) =>
        {
            Leads::Call { program: *program, passes: *passes }
        }
        _ => return,
    };
    let line = (channel.at.file, channel.at.line);
    let known = KnownBlock { line, of_contour: plan.actions.reads_contour(), leads, sequence: block.sequence };
    let places = &mut flow.known.blocks.0;
    let place = line.1 as usize % places.len();
    if let Some(slot) = places.get_mut(place) {
        *slot = Some(known);
    }
}

/// Whether the text is the number of a program, at most with a comment after it. Words that have been removed may
/// have had any effect.
fn is_head_alone(channel: &ChannelContext<'_>, text: &[u8]) -> bool {
    let [word] = channel.block.words.as_slice() else { return false };
    let before = text.get(..word.start as usize).unwrap_or_default();
    let after = text.get(word.end as usize..).unwrap_or_default().trim_ascii();
    let comment = matches!(after, [b'(', inner @ .., b')'] if !inner.contains(&b')'));
    Some(word.register) == channel.tables.registers.definition
        && before.trim_ascii().is_empty()
        && (after.is_empty() || comment)
}

/// Whether the block is a code that takes no time and changes no mode, with the number of a program and of passes.
fn has_only_words_of_call(channel: &ChannelContext<'_>) -> bool {
    let machine = channel.env.machine;
    let [pending] = channel.block.pending.as_slice() else { return false };
    let row = &machine.codes[pending.row];
    let of_call = |register: RegisterId| {
        let rows = machine.tables.data_of(register).iter().map(|&row| machine.data[row].id);
        form_range(&row.form).is_some_and(|(own, ..)| own == register)
            || rows.into_iter().any(|id| matches!(id, data::CALSUB_ID | data::CALSUB_REPEAT))
    };
    let plain = !pending.modal && row.process && row.modality == Modality::NonModal && row.group == 0;
    plain
        && row.seconds == 0.0
        && channel.block.words.iter().all(|word| word.used && of_call(word.register))
        && !calls_by_words(channel)
        && is_block_never_refused(channel)
}
