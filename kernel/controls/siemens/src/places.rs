//! Places of the remaining words of a block.
//!
//! *Invariant:* the parts cover the words, unless other words have replaced them or joined them. A word that replaces
//! others has the place of the word with its name, otherwise that of the whole block.

use super::item::SiemensLine;
use super::number_text::is_number;
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_control_api::words::{Leaving, LeftValue, Meanings, Span, part, span};
use counterpoint_machine::index::RegisterId;
use std::borrow::Cow;

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
pub(super) struct RemainderParts {
    parts: Vec<LeftPart>,
    /// The last word with a number.
    number: Option<NumberWord>,
    /// Whether other words have replaced those of the block.
    pub(super) replaced: bool,
}

impl SiemensLine {
    /// The place of an item in the block.
    pub(super) fn place(&self, item: usize) -> Option<Span> {
        self.places.get(item + 1).copied()
    }
}

impl RemainderParts {
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
        let whole = |(text, part): (&str, &LeftPart)| are_plain(text) || is_part(text, block, part.place);
        !self.replaced && !block.is_empty() && covered && self.parts(words).all(whole)
    }

    /// Adds the words to the block.
    pub(super) fn push(&self, host: &mut dyn InterpreterHost, words: &str, block: &[u8]) {
        self.parts(words).for_each(|(text, part)| put(host, text, block, (part.place, part.number)));
    }

    /// Adds words that replace those of the block.
    pub(super) fn push_made(&self, host: &mut dyn InterpreterHost, meanings: &mut Meanings, words: &str, block: &[u8]) {
        let begin = block.len() - block.trim_ascii_start().len();
        let whole = span(begin, begin + block.trim_ascii().len());
        let mut places: Vec<Span> = self.parts.iter().map(|part| part.place).collect();
        if places.is_empty() {
            places = std::str::from_utf8(block).map(word_spans).unwrap_or_default();
        }
        let mut leaving = Leaving::new(host, meanings);
        for place in word_spans(words) {
            let word = words.get(place.0 as usize..place.1 as usize).unwrap_or_default();
            let (name, number) = name_of(word);
            let place = place_of(word, &places, block).unwrap_or(whole);
            leaving.word(name, number.map(LeftValue::Replaced), || Cow::Borrowed(word), place);
        }
        leaving.end();
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

/// The place of the same word in the block, otherwise of the word with its name.
fn place_of(word: &str, places: &[Span], block: &[u8]) -> Option<Span> {
    let name = name_of(word).0.trim_end_matches('=');
    let is_named = |place: &Span| {
        let text = part(block, *place);
        let begin = text.get(..name.len()).filter(|begin| begin.eq_ignore_ascii_case(name));
        begin.is_some() && !text.as_bytes().get(name.len()).is_some_and(u8::is_ascii_alphabetic)
    };
    let same = places.iter().find(|place| is_part(word, block, **place));
    same.or_else(|| places.iter().find(|place| is_named(place))).copied()
}

/// The places of the words of a text. Blanks may be before and after the `=` of a word, or before its number.
fn word_spans(text: &str) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    let mut at = 0;
    for piece in text.split(' ') {
        let end = at + piece.len();
        let continues = |last: &Span| part(text.as_bytes(), *last).ends_with('=');
        let is_rest = piece.starts_with(|c: char| c.is_ascii_digit() || "+-.=".contains(c));
        match spans.last_mut() {
            Some(last) if !piece.is_empty() && (is_rest || continues(last)) => last.1 = end as u32,
            _ if !piece.is_empty() => spans.push(span(at, end)),
            _ => {}
        }
        at = end + 1;
    }
    spans
}

/// The name of a word, with `=`, and its number if it has nothing else.
fn name_of(word: &str) -> (&str, Option<&str>) {
    let begin = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.');
    let end = match word.find('=') {
        Some(at) => at + 1,
        None => word.bytes().position(begin).unwrap_or(word.len()),
    };
    let (name, number) = word.split_at_checked(end).unwrap_or((word, ""));
    if is_number(number) { (name.trim_end(), Some(number)) } else { (word, None) }
}

/// Whether none of the words is a message or a text that only a whole block can have.
pub(super) fn are_plain(words: &str) -> bool {
    !words.bytes().any(|byte| matches!(byte, b'(' | b'"' | b';'))
}

/// Adds the number of a block.
pub(super) fn push_block_number(host: &mut dyn InterpreterHost, line: &SiemensLine, block: &[u8]) {
    let Some(number) = line.number.as_ref().filter(|_| host.is_register("N")) else { return };
    let place = line.places.first().copied().unwrap_or_default();
    put(host, &format!("N{number}"), block, (place, None));
}

/// Leaves blocks as text, which replaces the text of the block: the tables of the machine know texts with brackets and
/// quotation marks as a whole.
pub(super) fn leave_as_text(
    host: &mut dyn InterpreterHost,
    line: &SiemensLine,
    before: &[String],
    words: &str,
) -> Remaining {
    let mut text = String::new();
    let mut spans = Vec::new();
    for words in before.iter().map(String::as_str).chain([words]).filter(|words| !words.is_empty()) {
        let begin = text.len();
        let is_last = spans.len() == before.len();
        if let Some(number) = line.number.as_ref().filter(|_| is_last && host.is_register("N")) {
            text.push_str(&format!("N{number} "));
        }
        text.push_str(words);
        spans.push(span(begin, text.len()));
        text.push(' ');
    }
    for (at, place) in spans.iter().enumerate() {
        if at > 0 {
            host.end_block();
        }
        host.push_plain(text.as_bytes(), *place);
    }
    host.join_lines(text.trim_end().as_bytes());
    if spans.is_empty() { Remaining::Nothing } else { Remaining::Words }
}

fn is_part(text: &str, block: &[u8], (start, end): Span) -> bool {
    block.get(start as usize..end as usize) == Some(text.as_bytes())
}

/// Adds a part to the block: as a place of the block if the block has the same text there, otherwise as a value or as a
/// written word.
fn put(host: &mut dyn InterpreterHost, text: &str, block: &[u8], (place, number): (Span, Option<(Register, usize)>)) {
    let value = number.and_then(|(register, at)| Some((register, text.get(at..)?)));
    if is_part(text, block, place) {
        host.push_plain(block, place);
    } else if !value.is_some_and(|(register, number)| host.push_number(register, number, text, place)) {
        host.push_written(text, place);
    }
}

#[cfg(test)]
mod tests {
    use super::{name_of, place_of, word_spans};

    #[test]
    fn words_have_a_name_and_a_number() {
        let text = "TRANS X 5 Y= 2 A3 = 1 M19";
        let words: Vec<_> =
            word_spans(text).into_iter().filter_map(|(start, end)| text.get(start as usize..end as usize)).collect();
        assert_eq!(words, ["TRANS", "X 5", "Y= 2", "A3 = 1", "M19"]);
        assert_eq!(name_of("X-1.5"), ("X", Some("-1.5")));
        assert_eq!(name_of("A3=0.5"), ("A3=", Some("0.5")));
        assert_eq!(name_of("SC_MASTER2"), ("SC_MASTER", Some("2")));
        assert_eq!(name_of("X 5"), ("X", Some("5")));
        assert_eq!(name_of("A3 = 1"), ("A3 = 1", None));
        assert_eq!(name_of("TRANS"), ("TRANS", None));
    }

    #[test]
    fn words_that_replace_others_have_the_places_of_their_names() {
        let block = b"FAST X=R1 Y5 y=2";
        let places = word_spans("FAST X=R1 Y5 y=2");
        let place = |word| place_of(word, &places, block);
        assert_eq!(place("X7"), Some((5, 9)));
        assert_eq!(place("Y5"), Some((10, 12)));
        assert_eq!(place("Y2"), Some((10, 12)));
        assert_eq!(place("Z1"), None);
    }
}
