//! Rows of codes whose conditions are other words of the block (`with`, `without`).
//!
//! *Invariant:* of the rows of a word the first matching row acts, together with matching rows that have `also`.

use counterpoint_machine::index::CodeRowId;
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::Block;

use crate::channel_context::ChannelContext;
use crate::queued_codes::data_word;

/// Second pass over words whose rows depend on other words of the block.
pub fn categorise_conditional(channel: &mut ChannelContext<'_>) {
    let machine = channel.env.machine;
    for position in 0..channel.block.words.len() {
        let Some(word) = channel.block.words.get(position).copied() else { break };
        if word.used {
            continue;
        }
        let candidates = machine.tables.code(word.register, word.value);
        if candidates.is_empty() {
            continue;
        }
        let mut rows = candidates.iter().map(|&index| (index, &machine.codes[index]));
        let chosen = rows.find(|(_, row)| fits(&channel.block, row));
        match chosen {
            Some((index, row)) => {
                channel.block.use_word(position);
                channel.block.queue(index, row, word.value, false);
                while let Some((index, row)) = rows.find(|(_, row)| row.also && fits(&channel.block, row)) {
                    channel.block.queue(index, row, word.value, false);
                }
            }
            None => data_word(channel, position),
        }
    }
}

/// Whether the conditions of a row on other words of the block are met.
pub fn fits(block: &Block, row: &CodeRow) -> bool {
    let with = row.with.is_empty() || row.with.iter().any(|&r| block.has(r));
    with && row.without.iter().all(|&r| !block.has(r))
}

/// The row of the same text whose conditions are met, or this one.
#[cold]
pub fn fitting_text(channel: &ChannelContext<'_>, row: CodeRowId) -> CodeRowId {
    let machine = channel.env.machine;
    let same = |other: &&CodeRowId| machine.codes[**other].form == machine.codes[row].form;
    let rows = machine.tables.texts.iter().filter(same);
    rows.copied().find(|&other| fits(&channel.block, &machine.codes[other])).unwrap_or(row)
}
