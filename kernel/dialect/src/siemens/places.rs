//! Where the remaining words of a block are from.
//!
//! *Invariant:* the parts cover the words, unless other words have replaced them or joined them.

use super::line::Line;
use crate::host::Host;
use crate::interpreter::Remaining;
use crate::words::Span;

/// Parts of the remaining words in their order.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// Where each part ends in the words, and the place in the block that it is from.
    parts: Vec<(usize, Span)>,
    /// Other words stand for those of the block.
    pub(super) replaced: bool,
}

impl Line {
    /// Where an item is in the block.
    pub(super) fn place(&self, item: usize) -> Option<Span> {
        self.places.get(item + 1).copied()
    }
}

impl Places {
    /// The words up to `end` that no part covers are from this place.
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

    /// Whether each word has its place, and none is a message or a text that only the block as a whole can have.
    pub(super) fn are_words_of(&self, words: &str, block: &[u8]) -> bool {
        let covered = self.parts.last().map_or(0, |(end, _)| *end) == words.len();
        let is_plain = |text: &str| !text.bytes().any(|byte| matches!(byte, b'(' | b'"' | b';'));
        let whole = |(text, place): (&str, Span)| is_plain(text) || is_part(text, block, place);
        !self.replaced && !block.is_empty() && covered && self.parts(words).all(whole)
    }

    /// Puts the words in the block.
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

/// Puts a part in the block: the block itself where it has this text.
fn put(host: &mut dyn Host, text: &str, block: &[u8], place: Span) {
    if is_part(text, block, place) {
        host.push_plain(block, place);
    } else {
        host.push_written(text, place);
    }
}
