//! Places of the remaining words of a block.
//!
//! *Invariant:* the parts cover the words, unless other words have replaced them or joined them.

use super::line::Line;
use crate::host::Host;
use crate::interpreter::Remaining;
use crate::words::Span;

/// Parts of the remaining words in their order.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// The end of each part within the words, and its place in the block.
    parts: Vec<(usize, Span)>,
    /// Whether other words have replaced those of the block.
    pub(super) replaced: bool,
}

impl Line {
    /// The place of an item in the block.
    pub(super) fn place(&self, item: usize) -> Option<Span> {
        self.places.get(item + 1).copied()
    }
}

impl Places {
    /// Gives the words up to `end` that no part covers this place.
    pub(super) fn put(&mut self, end: usize, place: Option<Span>) {
        let last = self.parts.last().map_or(0, |(end, _)| *end);
        match place {
            Some(place) if end > last => {
                if self.parts.is_empty() {
                    self.parts.reserve(8);
                }
                self.parts.push((end, place));
            }
            None if end > last => self.replaced = true,
            _ => {}
        }
    }

    /// Whether each word has its place, and none is a message or a text that only a whole block can have.
    pub(super) fn are_words_of(&self, words: &str, block: &[u8]) -> bool {
        let covered = self.parts.last().map_or(0, |(end, _)| *end) == words.len();
        let is_plain = |text: &str| !text.bytes().any(|byte| matches!(byte, b'(' | b'"' | b';'));
        let whole = |(text, place): (&str, Span)| is_plain(text) || is_part(text, block, place);
        !self.replaced && !block.is_empty() && covered && self.parts(words).all(whole)
    }

    /// Adds the words to the block.
    pub(super) fn push(&self, host: &mut dyn Host, line: &Line, words: &str, block: &[u8]) -> Remaining {
        if self.parts.is_empty() {
            return Remaining::Nothing;
        }
        if let Some((number, place)) = line.number.as_ref().zip(line.places.first()).filter(|_| host.is_register("N")) {
            put(host, &format!("N{number}"), block, *place);
        }
        self.parts(words).for_each(|(text, place)| put(host, text, block, place));
        Remaining::Words
    }

    fn parts<'w>(&self, words: &'w str) -> impl Iterator<Item = (&'w str, Span)> {
        let mut from = 0;
        self.parts.iter().map(move |&(end, place)| {
            let text = words.get(from..end).unwrap_or_default().trim_start();
            from = end;
            (text, place)
        })
    }
}

fn is_part(text: &str, block: &[u8], (start, end): Span) -> bool {
    block.get(start as usize..end as usize) == Some(text.as_bytes())
}

/// Adds a part to the block: as a place of the block if the text there is the same, otherwise as a written word.
fn put(host: &mut dyn Host, text: &str, block: &[u8], place: Span) {
    if is_part(text, block, place) {
        host.push_plain(block, place);
    } else {
        host.push_written(text, place);
    }
}
