//! The trace: the work of a kernel, line by line, in the documented layout.
//!
//! Facts: reference listing-and-trace.md 3, 4, 6. Trace lines are events like all others, so they have their place in
//! the log and a trace is as reproducible as the log. *Invariant:* a kernel without trace letters asks one `Option`
//! per hook and makes no text.
//!
//! Macros have their hooks here too: [`entering`], [`statement`], [`leaving`] for the letters M and H, [`exec`] for X,
//! [`edited`] for the stages of a block's text.

use crate::burden::shortened;
use crate::channel_context::ChannelContext;
use crate::macro_queries::own_sequence;
use crate::queued_codes::literal_of;
use counterpoint_event::event::{Kind, Trace};
use counterpoint_machine::ident;
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_machine::number::written;

pub use counterpoint_results::trace_lines::{
    TextStage, action, code, data, edited, entering, exec, ignored, leaving, sequence, statement, word,
};

/// Letter of actions. Most are read from the events; an action without an event is a line of its own.
pub const ACTION: char = 'A';

/// Adds a line of a letter, if the trace has this letter.
#[inline(always)]
pub fn trace_line(channel: &mut ChannelContext<'_>, letter: char, line: impl FnOnce(&ChannelContext<'_>) -> String) {
    if channel.env.trace.is_some() {
        trace_wanted(channel, letter, line);
    }
}

#[cold]
#[inline(never)]
fn trace_wanted(channel: &mut ChannelContext<'_>, letter: char, line: impl FnOnce(&ChannelContext<'_>) -> String) {
    if traces(channel, letter) {
        let text = shortened(&line(channel)).to_owned();
        channel.emit(0, Kind::trace(letter, text));
    }
}

/// The words of the block as they were recognised, and its sequence number.
#[cold]
pub fn trace_words(channel: &mut ChannelContext<'_>) {
    if traces(channel, 'W') {
        if let Some(number) = channel.block.sequence {
            trace_line(channel, 'W', |_| word("N", &number.to_string()));
        }
        for index in 0..channel.block.words.len() {
            trace_line(channel, 'W', |channel| word_line(channel, index));
        }
    }
    if let Some(number) = channel.block.sequence {
        trace_line(channel, 'C', |_| sequence(number));
    }
    trace_head_sequence(channel);
}

/// The sequence number that the head of this channel has of its own.
fn trace_head_sequence(channel: &mut ChannelContext<'_>) {
    let Some(register) = own_sequence(channel) else { return };
    let word = channel.block.words.iter().find(|word| word.register == register).map(|word| word.value);
    let id = if channel.env.kernel_number(channel.at.channel) <= 1 {
        ident::data::SEQNO_MAIN
    } else {
        ident::data::SEQNO_SIDE
    };
    if let Some(value) = word {
        trace_line(channel, 'C', |channel| data(channel.env.machine.data_name(id), value));
    }
}

/// The text that the pre-processor left.
#[cold]
pub fn trace_preprocessed(channel: &mut ChannelContext<'_>) {
    trace_line(channel, 'E', |channel| {
        let sequence = channel.block.sequence.map(|number| format!("N{number}"));
        let words = (0..channel.block.words.len()).filter_map(|index| text_of_word(channel, index));
        let texts = channel.block.texts.iter().filter_map(|&row| literal_of(channel, row)).map(str::to_owned);
        edited(TextStage::PreProcessor, &sequence.into_iter().chain(words).chain(texts).collect::<Vec<_>>().join(" "))
    });
}

/// The text that the pre-processor of another control left.
#[cold]
pub fn trace_left(channel: &mut ChannelContext<'_>, text: &str) {
    trace_line(channel, 'E', |_| edited(TextStage::PreProcessor, text.trim()));
}

/// A code begins to act.
#[inline(always)]
pub fn trace_code(channel: &mut ChannelContext<'_>, id: CodeId) {
    trace_line(channel, 'C', |channel| code(channel.env.machine.code_name(id)));
}

/// A code is ignored.
#[inline(always)]
pub fn trace_ignored(channel: &mut ChannelContext<'_>, id: CodeId) {
    trace_line(channel, 'C', |channel| ignored(channel.env.machine.code_name(id)));
}

/// An action took a value.
#[inline(always)]
pub fn trace_data(channel: &mut ChannelContext<'_>, id: DataId, value: f64) {
    trace_line(channel, 'C', |channel| data(channel.env.machine.data_name(id), value));
}

/// Adds an action that replaces the action of the next event, if the trace has actions.
pub fn trace_instead(channel: &mut ChannelContext<'_>, text: &str) {
    if traces(channel, ACTION) {
        let text = shortened(&action(text)).into();
        channel.emit(0, Kind::Trace(Trace { letter: ACTION, text, listing: None, instead: true }));
    }
}

/// Whether the trace has lines of a letter for the current block. Blocks of stored files are shown only with the letter
/// Z, their actions in any case.
pub fn traces(channel: &ChannelContext<'_>, letter: char) -> bool {
    let Some(letters) = channel.env.trace else { return false };
    letters.has(letter) && (letter == ACTION || letters.has('Z') || !channel.env.info.is_stored(channel.at.file))
}

fn word_line(channel: &ChannelContext<'_>, index: usize) -> String {
    let Some((register, value)) = written_word(channel, index) else { return String::new() };
    word(register, &value)
}

/// A word in the format of its register.
fn text_of_word(channel: &ChannelContext<'_>, index: usize) -> Option<String> {
    let (name, value) = written_word(channel, index)?;
    let word = channel.block.words.get(index)?;
    let register = &channel.env.machine.registers[word.register];
    let before = if word.incremental && register.second.is_some() { name } else { register.before.as_str() };
    Some(format!("{before}{value}{}", register.after))
}

/// Name and number of a word, in the format of its register.
fn written_word<'c>(channel: &'c ChannelContext<'_>, index: usize) -> Option<(&'c str, String)> {
    let word = channel.block.words.get(index)?;
    let register = &channel.env.machine.registers[word.register];
    let name = match &register.second {
        Some(second) if word.incremental => second.as_str(),
        _ => register.name.as_str(),
    };
    let format = if channel.state.secondary { &register.secondary } else { &register.format };
    Some((name, written(word.value, format)))
}
