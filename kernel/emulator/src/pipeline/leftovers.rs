//! Stage *leftovers*: words that are still in the block after all its codes have acted.
//!
//! Facts: reference control-emulator.md 1.3 (unused data), 2.2 step 12.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_channel::unknown_words::{channel_has, left_name};
use counterpoint_channel::word_values::word_number;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::data;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::index::RegisterId;
use counterpoint_program::block::irregular;

use crate::channel::{Kernel, refusals};
use crate::pipeline::beside_motion;

impl Kernel<'_> {
    /// Remembers modal values, diagnoses the rest.
    #[inline(always)]
    pub(crate) fn leftovers(&mut self) -> Acted {
        // A speed word left is a data word left.
        if self.channel.block.has_leftovers() || self.channel.block.has_remarks() { left_over(self) } else { Ok(()) }
    }
}

#[inline(never)]
fn left_over(kernel: &mut Kernel<'_>) -> Acted {
    if kernel.channel.block.has_any(kernel.channel.tables.registers.speed) {
        (kernel.plan.actions.speed_word)(kernel)?;
    }
    if kernel.channel.block.has_leftovers() {
        for position in 0..kernel.channel.block.words.len() {
            let Some(word) = kernel.channel.block.words.get(position).copied() else { break };
            if !word.used {
                leftover_word(kernel, (position, word.register), word.value, (word.start, word.end));
            }
        }
    }
    if !kernel.channel.block.has_remarks() {
        return Ok(());
    }
    left_name(&mut kernel.channel);
    if !kernel.channel.block.unrecognised.is_empty() {
        kernel.unknown_text()?;
    }
    if kernel.channel.block.flags.irregular & irregular::OPEN_COMMENT != 0
        && !kernel.channel.env.machine.format.long_comments
    {
        let text = format!("a comment or message is not closed in '{}'", kernel.channel.block_text());
        kernel.diagnose(&diag::COMMENT_OPEN, text);
    }
    if kernel.channel.block.flags.irregular & irregular::DIGITS != 0 {
        let text = format!("a number has more digits than its register's format in '{}'", kernel.channel.block_text());
        kernel.diagnose(&diag::TOO_MANY_DIGITS, text);
    }
    if kernel.channel.block.flags.irregular & irregular::BYTES != 0 {
        let text = format!("control characters in line {} are ignored", kernel.channel.at.line);
        kernel.diagnose(&diag::BAD_BYTES, text);
    }
    Ok(())
}

/// A word that a later one of its address replaces.
#[cold]
fn word_twice(kernel: &mut Kernel<'_>, span: (u32, u32), last: (u32, u32)) {
    let [word, last] = [span, last].map(|span| kernel.channel.span_text(span));
    let text = format!("{word} has no effect: {last} comes later in '{}'", kernel.channel.block_text());
    let counts = kernel.channel.env.machine.habits.last_of_address;
    kernel.diagnose(if counts { &diag::WORD_TWICE } else { &diag::DATA_NOT_USED }, text);
}

fn leftover_word(kernel: &mut Kernel<'_>, (position, register): (usize, RegisterId), value: f64, span: (u32, u32)) {
    let machine = kernel.channel.env.machine;
    let mut rows = kernel.channel.block.pending.iter().map(|pending| &machine.codes[pending.row]);
    if rows.any(|row| row.ignores.contains(&register))
        || beside_motion::belongs_to_dropped_cycle(&kernel.channel, register)
    {
        return;
    }
    let rows = machine.tables.data_of(register);
    // Several words with different targets (H functions of Siemens) do not replace each other.
    if !rows.is_empty() && rows.iter().all(|&row| kernel.channel.tables.data.ignore[row]) {
        return;
    }
    if let Some(last) = later_word(&kernel.channel, register, position) {
        return word_twice(kernel, span, last);
    }
    let (feed, _) = feed_of(kernel.channel.state.modal.code(group::FEED));
    let mut known = false;
    let (mut axis, mut direction) = (false, false);
    for &index in rows {
        let row = &machine.data[index];
        // A label that no call takes marks its block; the sequence number of a head tells and does nothing.
        if matches!(row.id, data::LABEL | data::SEQNO_MAIN | data::SEQNO_SIDE)
            || kernel.channel.tables.data.ignore[index]
        {
            known = true;
            continue;
        }
        let is_axis = row.id.kind().is_axis();
        axis |= is_axis;
        direction |= row.id.kind() == DataKind::Orientation;
        let other_feed = matches!(row.id, data::FEED_UPM | data::FEED_UPR | data::FEED_1T) && row.id != feed;
        if row.modal && !is_axis && !other_feed {
            let mut sources = kernel.channel.tables.sources_of(row.id).iter();
            let counting = sources.find(|source| source.row == index && source.one.is_some());
            let word = kernel.channel.block.words.get(position).filter(|_| counting.is_some());
            let value = counting.zip(word).map_or(value, |(source, word)| word_number(&kernel.channel, source, word));
            let value = (value * row.mul + row.add) * kernel.channel.unit_factor(row.dimension);
            kernel.channel.state.remembered.remember(row.id, value);
            known = true;
        } else if row.modal && other_feed {
            known = true;
        }
    }
    if known {
        return;
    }
    let word = kernel.channel.span_text(span);
    let block = kernel.channel.block_text();
    if axis && !channel_has(&kernel.channel, register) {
        kernel.diagnose(
            &diag::AXIS_NOT_IN_CHANNEL,
            format!("{} for {word} in '{block}'; the word is ignored", refusals::no_such_axis(&kernel.channel)),
        );
    } else if axis && kernel.channel.state.modal.code(group::MOTION).is_none() {
        kernel.diagnose(&diag::NO_MOTION_MODE, format!("no motion code is active for {word} in '{block}'"));
    } else if direction && kernel.channel.state.place.tip().is_none() {
        kernel.diagnose(
            &diag::TIP_WORDS_ALONE,
            format!("tool centre point control is not active for {word} in '{block}'; the word is ignored"),
        );
    } else {
        kernel.diagnose(&diag::DATA_NOT_USED, format!("{word} is not used by any code in '{block}'; ignored"));
    }
}

/// Position of the last word of the same address, if there is a later word.
fn later_word(channel: &ChannelContext<'_>, register: RegisterId, position: usize) -> Option<(u32, u32)> {
    let words = channel.block.words.get(position + 1..)?;
    words.iter().rfind(|word| word.register == register).map(|word| (word.start, word.end))
}
