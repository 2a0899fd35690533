//! The trace: the work of a kernel, line by line, in the documented layout.
//!
//! Facts: reference listing-and-trace.md 3, 4, 6. Trace lines are events like all others, so they have their place in
//! the log and a trace is as reproducible as the log. *Invariant:* a kernel without trace letters asks one `Option`
//! per hook and makes no text.
//!
//! Macros have their hooks here too: [`entering`], [`statement`], [`leaving`] for the letters M and H, [`exec`] for X,
//! [`edited`] for the stages of a block's text.

use counterpoint_channel::queued_codes::literal_of;
pub use counterpoint_results::trace_lines::{
    TextStage, action, code, data, edited, entering, exec, ignored, leaving, sequence, statement, word,
};

use counterpoint_channel::burden::shortened;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_event::event::Kind;
use counterpoint_event::event::Trace;
use counterpoint_machine::ident;
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::ident::DataId;
use counterpoint_machine::number::written;

use crate::channel::Kernel;
use counterpoint_channel::macro_queries::own_sequence;

/// Letter of actions. Most are read from the events; an action without an event is a line of its own.
pub const ACTION: char = 'A';

impl Kernel<'_> {
    /// Adds a line of a letter, if it is wanted.
    #[inline(always)]
    pub fn trace(&mut self, letter: char, line: impl FnOnce(&Self) -> String) {
        if self.channel.env.trace.is_some() {
            self.trace_wanted(letter, line);
        }
    }

    #[cold]
    #[inline(never)]
    fn trace_wanted(&mut self, letter: char, line: impl FnOnce(&Self) -> String) {
        if traces(&self.channel, letter) {
            let text = shortened(&line(self)).to_owned();
            self.channel.emit(0, Kind::trace(letter, text));
        }
    }

    /// The words of the block as they were recognised, and its sequence number.
    #[cold]
    pub(crate) fn trace_words(&mut self) {
        if traces(&self.channel, 'W') {
            if let Some(number) = self.channel.block.sequence {
                self.trace('W', |_| word("N", &number.to_string()));
            }
            for index in 0..self.channel.block.words.len() {
                self.trace('W', |kernel| word_line(&kernel.channel, index));
            }
        }
        if let Some(number) = self.channel.block.sequence {
            self.trace('C', |_| sequence(number));
        }
        self.trace_head_sequence();
    }

    /// The sequence number that the head of this channel has of its own.
    fn trace_head_sequence(&mut self) {
        let Some(register) = own_sequence(&self.channel) else { return };
        let word = self.channel.block.words.iter().find(|word| word.register == register).map(|word| word.value);
        let id = if self.channel.env.kernel_number(self.channel.at.channel) <= 1 {
            ident::data::SEQNO_MAIN
        } else {
            ident::data::SEQNO_SIDE
        };
        if let Some(value) = word {
            self.trace('C', |kernel| data(kernel.channel.env.machine.data_name(id), value));
        }
    }

    /// The text that the pre-processor left.
    #[cold]
    pub(crate) fn trace_preprocessed(&mut self) {
        self.trace('E', |kernel| {
            let sequence = kernel.channel.block.sequence.map(|number| format!("N{number}"));
            let words = (0..kernel.channel.block.words.len()).filter_map(|index| text_of_word(&kernel.channel, index));
            let texts = kernel
                .channel
                .block
                .texts
                .iter()
                .filter_map(|&row| literal_of(&kernel.channel, row))
                .map(str::to_owned);
            edited(
                TextStage::PreProcessor,
                &sequence.into_iter().chain(words).chain(texts).collect::<Vec<_>>().join(" "),
            )
        });
    }

    /// The text that the pre-processor of another control left.
    #[cold]
    pub(crate) fn trace_left(&mut self, text: &str) {
        self.trace('E', |_| edited(TextStage::PreProcessor, text.trim()));
    }

    /// A code begins to act.
    #[inline(always)]
    pub(crate) fn trace_code(&mut self, id: CodeId) {
        self.trace('C', |kernel| code(kernel.channel.env.machine.code_name(id)));
    }

    /// A code is ignored.
    #[inline(always)]
    pub fn trace_ignored(&mut self, id: CodeId) {
        self.trace('C', |kernel| ignored(kernel.channel.env.machine.code_name(id)));
    }

    /// An action took a value.
    #[inline(always)]
    pub fn trace_data(&mut self, id: DataId, value: f64) {
        self.trace('C', |kernel| data(kernel.channel.env.machine.data_name(id), value));
    }
}

/// Adds an action that takes the place of that of the next event, if actions are wanted.
pub fn trace_instead(channel: &mut ChannelContext<'_>, text: &str) {
    if traces(channel, ACTION) {
        let text = shortened(&action(text)).into();
        channel.emit(0, Kind::Trace(Trace { letter: ACTION, text, listing: None, instead: true }));
    }
}

/// Lines of a letter are wanted for the current block. Blocks of stored files are shown only with the letter Z,
/// their actions in any case.
pub(crate) fn traces(channel: &ChannelContext<'_>, letter: char) -> bool {
    let Some(letters) = channel.env.trace else { return false };
    letters.has(letter) && (letter == ACTION || letters.has('Z') || !channel.env.info.is_stored(channel.at.file))
}

fn word_line(channel: &ChannelContext<'_>, index: usize) -> String {
    let Some((register, value)) = written_word(channel, index) else { return String::new() };
    word(register, &value)
}

/// A word as its register writes it.
fn text_of_word(channel: &ChannelContext<'_>, index: usize) -> Option<String> {
    let (name, value) = written_word(channel, index)?;
    let word = channel.block.words.get(index)?;
    let register = &channel.env.machine.registers[word.register];
    let before = if word.incremental && register.second.is_some() { name } else { register.before.as_str() };
    Some(format!("{before}{value}{}", register.after))
}

/// Name and number of a word as its register writes them.
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
