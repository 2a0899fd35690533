//! Words that the interpreter of a control leaves in its block.
//!
//! *Invariant:* a word has its place in the text of the program. The words are also formatted as text, but only for the
//! trace and for macros that ask for the block. Facts: reference control-emulator.md 2.2, 5.4.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::number::{rounded, written};
use counterpoint_machine::rows::DecimalPointRule;
use counterpoint_program::block::{Word, irregular};
use counterpoint_program::key_words::WrittenNumber;

use super::Kernel;
use crate::channel::dialect_state::DialectState;

impl Kernel<'_> {
    /// Whether a trace or a macro may ask for the text of the words that an interpreter leaves.
    #[inline]
    pub(crate) fn asks_left_text(&self) -> bool {
        self.channel.env.trace.is_some() || self.plan.hooks.is_some_and(|hooks| (hooks.block.reads_left)(self))
    }
}

/// Adds a value as a word of a register.
pub(crate) fn left_value(
    channel: &mut ChannelContext<'_>,
    flow: &mut ProgramFlow,
    dialect: &mut DialectState,
    (register, incremental): (RegisterId, bool),
    value: f64,
    spelled: Option<&str>,
    (start, end): (u32, u32),
) {
    let (tables, secondary) = (channel.tables, channel.state.secondary);
    let row = &channel.env.machine.registers[register];
    let format = if secondary { &row.secondary } else { &row.format };
    let number = spelled.and_then(|text| tables.scanner.reading_of(register, text.as_bytes(), secondary));
    let (read, bits) = number.unwrap_or_else(|| {
        let value = rounded(value, format);
        let number = WrittenNumber { value, point: true, digits: 0, fraction: 0 };
        let (value, bits) = tables.scanner.reading(register, number, secondary);
        let pointed = match format.point {
            DecimalPointRule::Keep => format.frac > 0,
            DecimalPointRule::Fractional => value.fract() != 0.0,
            DecimalPointRule::Omit => false,
        };
        (value, if pointed { bits } else { bits & !irregular::POINT })
    });
    let machine = channel.env.machine;
    dialect.left.add(|| {
        let row = &machine.registers[register];
        let before = row.second.as_ref().filter(|_| incremental).unwrap_or(&row.before);
        let number = spelled.map_or_else(|| written(value, format), str::to_owned);
        format!("{before}{number}{}", row.after)
    });
    let block = &mut channel.block;
    block.flags.irregular |= bits;
    if Some(register) == tables.scanner.sequence() && block.sequence.is_none() && read >= 0.0 {
        block.sequence = Some(read as u32);
        return;
    }
    block.push(Word { register, incremental, used: false, made: number.is_none(), value: read, start, end });
    flow.pass.effects = true;
}

/// Adds the words of a part of a text whose places are those of the block.
pub(crate) fn left_plain(
    channel: &mut ChannelContext<'_>,
    flow: &mut ProgramFlow,
    dialect: &mut DialectState,
    text: &[u8],
    span: (u32, u32),
) {
    let tables = channel.tables;
    let scanner = tables.unmarked.as_deref().unwrap_or(&tables.scanner);
    scanner.scan_part(text, span, channel.state.secondary, &mut channel.block);
    dialect.left.add(|| part(text, span));
    notes_effect(channel, flow);
}

/// Adds words that replace a part of the block.
pub(crate) fn left_written(
    channel: &mut ChannelContext<'_>,
    flow: &mut ProgramFlow,
    dialect: &mut DialectState,
    words: &str,
    (start, end): (u32, u32),
) {
    let tables = channel.tables;
    let scanner = tables.unmarked.as_deref().unwrap_or(&tables.scanner);
    let block = &mut channel.block;
    let count = block.words.len();
    let unrecognised = std::mem::take(&mut block.unrecognised);
    scanner.scan_part(words.as_bytes(), (0, words.len() as u32), channel.state.secondary, block);
    for word in block.words.iter_mut().skip(count) {
        (word.start, word.end, word.made) = (start, end, true);
    }
    let is_word = std::mem::replace(&mut block.unrecognised, unrecognised).is_empty();
    if !is_word {
        block.unrecognised.push((start, end));
    }
    dialect.left.add(|| words.to_owned());
    notes_effect(channel, flow);
}

fn notes_effect(channel: &ChannelContext<'_>, flow: &mut ProgramFlow) {
    let block = &channel.block;
    // A sequence number alone is not an effect that a loop could wait for.
    let acts = !(block.words.is_empty() && block.texts.is_empty() && block.unrecognised.is_empty());
    flow.pass.effects |= acts;
}

/// Adds a part of a text that is not a word of the machine.
pub(crate) fn left_unknown(
    channel: &mut ChannelContext<'_>,
    flow: &mut ProgramFlow,
    dialect: &mut DialectState,
    text: &[u8],
    span: (u32, u32),
) {
    channel.block.push_unrecognised(span);
    dialect.left.add(|| part(text, span));
    flow.pass.effects = true;
}

fn part(text: &[u8], (start, end): (u32, u32)) -> String {
    let part = text.get(start as usize..end as usize).unwrap_or_default();
    String::from_utf8_lossy(part).trim().to_owned()
}
