//! Places of the remaining words of a block.
//!
//! *Invariant:* the parts cover the words, unless other words have replaced them or joined them.

use super::line::Line;
use crate::host::Host;
use crate::interpreter::Remaining;
use crate::words::Span;
use counterpoint_machine::index::RegisterId;

/// A part of the remaining words.
#[derive(Debug, Clone, Copy)]
struct LeftPart {
    /// End of the part within the words.
    end: usize,
    /// Place of the part in the block.
    place: Span,
    /// If the part is one word of data: its register, and where its number begins within the part.
    number: Option<(Register, usize)>,
}

/// A register, and whether it is the incremental form.
type Register = (RegisterId, bool);

/// A word of data: its register and its bounds within the words (start, start of the number, end).
#[derive(Debug, Clone, Copy)]
struct NumberWord {
    register: Register,
    bounds: [usize; 3],
}

/// Parts of the remaining words in their order.
#[derive(Debug, Default)]
pub(super) struct Places {
    parts: Vec<LeftPart>,
    /// The last word with a number.
    number: Option<NumberWord>,
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
        let last = self.parts.last().map_or(0, |part| part.end);
        match place {
            Some(place) if end > last => {
                if self.parts.is_empty() {
                    self.parts.reserve(8);
                }
                // One blank precedes each part except the first.
                let begin = if last == 0 { 0 } else { last + 1 };
                let alone = |word: &NumberWord| word.bounds[0] == begin && word.bounds[2] == end;
                let number = self.number.take().filter(alone);
                let number = number.map(|word| (word.register, word.bounds[1] - begin));
                self.parts.push(LeftPart { end, place, number });
            }
            None if end > last => self.replaced = true,
            _ => {}
        }
    }

    /// Notes a word of a register at these bounds: start, start of the number, end.
    pub(super) fn note_number(&mut self, register: Option<Register>, bounds: [usize; 3]) {
        self.number = register.map(|register| NumberWord { register, bounds });
    }

    /// Whether each word has its place, and none is a message or a text that only a whole block can have.
    pub(super) fn are_words_of(&self, words: &str, block: &[u8]) -> bool {
        let covered = self.parts.last().map_or(0, |part| part.end) == words.len();
        let is_plain = |text: &str| !text.bytes().any(|byte| matches!(byte, b'(' | b'"' | b';'));
        let whole = |(text, part): (&str, &LeftPart)| is_plain(text) || is_part(text, block, part.place);
        !self.replaced && !block.is_empty() && covered && self.parts(words).all(whole)
    }

    /// Adds the words to the block.
    pub(super) fn push(&self, host: &mut dyn Host, line: &Line, words: &str, block: &[u8]) -> Remaining {
        if self.parts.is_empty() {
            return Remaining::Nothing;
        }
        if let Some((number, place)) = line.number.as_ref().zip(line.places.first()).filter(|_| host.is_register("N")) {
            put(host, &format!("N{number}"), block, (*place, None));
        }
        self.parts(words).for_each(|(text, part)| put(host, text, block, (part.place, part.number)));
        Remaining::Words
    }

    fn parts<'w>(&self, words: &'w str) -> impl Iterator<Item = (&'w str, &LeftPart)> {
        let mut from = 0;
        self.parts.iter().map(move |part| {
            let text = words.get(from..part.end).unwrap_or_default().trim_start();
            from = part.end;
            (text, part)
        })
    }
}

fn is_part(text: &str, block: &[u8], (start, end): Span) -> bool {
    block.get(start as usize..end as usize) == Some(text.as_bytes())
}

/// Adds a part to the block: as a place of the block if the block has the same text there, otherwise as a value or as a
/// written word.
fn put(host: &mut dyn Host, text: &str, block: &[u8], (place, number): (Span, Option<(Register, usize)>)) {
    let value = number.and_then(|(register, at)| Some((register, text.get(at..)?)));
    if is_part(text, block, place) {
        host.push_plain(block, place);
    } else if !value.is_some_and(|(register, number)| host.push_number(register, number, text, place)) {
        host.push_written(text, place);
    }
}
