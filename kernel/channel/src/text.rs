//! The text of the block in process: of its line, of an edit, of a macro.
//!
//! *Invariant:* the scanner, the pre-processor and messages about words use one text, to which the positions of words
//! refer.

use std::borrow::Cow;
use std::sync::Arc;

use counterpoint_machine::number::written;
use counterpoint_program::block::Word;

use super::channel_context::ChannelContext;

impl ChannelContext<'_> {
    /// Text of the user's current block, for messages: at most 60 characters. Codes that a macro executes without a text
    /// of their own belong to the block of the program.
    pub fn block_text(&self) -> String {
        match self.context.text.as_ref().filter(|text| !text.trim().is_empty()) {
            Some(text) => counterpoint_event::info::cut(text, 60),
            None => {
                let place = self.at.user_place();
                self.env.info.block_text(place.file, place.line, 60).into_owned()
            }
        }
    }

    /// Text of the block in process.
    pub fn text_bytes(&self) -> Cow<'_, [u8]> {
        match self.context.text.as_ref() {
            Some(text) => text.as_bytes().into(),
            None => current_text(self).into(),
        }
    }

    /// Text of a word: its part of the block, or the digits that its register writes.
    #[cold]
    pub fn word_bytes(&self, word: &Word) -> Cow<'_, [u8]> {
        if word.made {
            let register = &self.env.machine.registers[word.register];
            let format = if self.state.secondary { &register.secondary } else { &register.format };
            return format!("{}{}", register.before, written(word.value, format)).into_bytes().into();
        }
        let span = word.start as usize..word.end as usize;
        match self.text_bytes() {
            Cow::Borrowed(line) => line.get(span).unwrap_or_default().into(),
            Cow::Owned(line) => line.get(span).unwrap_or_default().to_vec().into(),
        }
    }

    /// A part of the text of the block, without blanks around it.
    pub fn span_text(&self, (start, end): (u32, u32)) -> String {
        let line = self.text_bytes();
        let end = line.len().min(end as usize);
        String::from_utf8_lossy(line.get(start as usize..end).unwrap_or_default()).trim().to_owned()
    }
}

/// Replaces the unrecognised text.
pub fn set_left(channel: &mut ChannelContext<'_>, text: String) {
    channel.block.unrecognised.clear();
    if !text.trim().is_empty() {
        // The span is not read: the text is in the context.
        channel.block.unrecognised.push((0, 0));
    }
    channel.context.unrecognised = Some(Arc::new(text));
}

/// Unrecognised text, or the text that a macro left in its place.
pub fn left_text(channel: &ChannelContext<'_>) -> String {
    if let Some(text) = channel.context.unrecognised.as_ref() {
        return text.as_ref().clone();
    }
    let parts: Vec<String> = channel.block.unrecognised.iter().map(|&span| channel.span_text(span)).collect();
    parts.join(" ")
}

/// The text of the block with the words that the pre-processor made.
pub fn preprocessed_bytes<'t>(channel: &'t ChannelContext<'_>) -> Cow<'t, [u8]> {
    channel.context.left.as_ref().map_or_else(|| channel.text_bytes(), |left| left.as_bytes().into())
}

/// Text of the block being processed.
pub fn current_text<'t>(channel: &'t ChannelContext<'_>) -> &'t [u8] {
    match &channel.text.edited {
        Some(text) => text,
        None => {
            let (sources, at) = (channel.env.sources, &channel.at);
            let line = sources.get(at.file).map_or(&[][..], |source| source.line(at.line));
            let end = channel.tables.scanner.block_end(line).unwrap_or(line.len());
            line.get(..end).unwrap_or_default()
        }
    }
}

/// Whether the block is a line of a file as it was read, and this byte occurs nowhere in the file.
pub fn is_line_without(channel: &ChannelContext<'_>, byte: u8) -> bool {
    let source = || channel.env.sources.get(channel.at.file);
    channel.text.edited.is_none() && source().is_some_and(|source| !source.has(byte))
}
