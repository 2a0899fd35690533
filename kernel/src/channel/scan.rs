//! From the text of a line to words.
//!
//! Facts: reference control-emulator.md 1.4 (reading a number), 5.5 (block delete), 5.6 (comments). Invariant: one
//! pass over the line, nothing copied; whatever is not a word of a register is kept as unknown text.

mod marks;

use super::block::{Block, Word};
use crate::dialect::fanuc::{Names, Number, key_word};
use crate::machine::Machine;
use crate::machine::model::{NumberFormat, Point, Zeros};
use crate::mcd::program::program_name;
use crate::mcd::special::{self, Early};

/// What a line turned out to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Plain words, now in the block.
    Words,
    /// It needs the pre-processor.
    Macro,
}

/// What the scanner needs of the machine, prepared once.
#[derive(Debug)]
pub(crate) struct Scanner {
    comment: Option<(Vec<u8>, Vec<u8>)>,
    message: Option<(Vec<u8>, Vec<u8>)>,
    opskip: Option<u8>,
    opskip_default: u8,
    eob: Option<u8>,
    /// Literal text codes: text and row.
    texts: Vec<(Vec<u8>, u16)>,
    /// How numbers of each register are read, in primary and in secondary units.
    reads: Vec<[Read; 2]>,
    /// Custom macro: variables and statements stand among the words.
    macros: bool,
    /// Which blocks are not plain words, for the pre-processor of another control.
    foreign: Option<fn(&[u8]) -> bool>,
    /// Active optional-skip levels, bit n.
    levels: u16,
    sequence: Option<u8>,
    letters: [(u8, bool); 128],
    /// Special registers, and texts that would be read as words; `None` on most machines.
    early: Option<Box<Early>>,
}

/// No register.
const NONE: u8 = u8::MAX;

impl Scanner {
    /// For a machine and the active optional-skip levels.
    pub(crate) fn new(machine: &Machine, opskip: &[u8]) -> Self {
        let pair =
            |p: &Option<(String, String)>| p.as_ref().map(|(a, b)| (a.clone().into_bytes(), b.clone().into_bytes()));
        let ascii = |c: Option<char>| c.and_then(|c| u8::try_from(c).ok());
        let mut letters = [(NONE, false); 128];
        for (letter, entry) in letters.iter_mut().zip(&machine.tables.letter) {
            if let Some((register, incremental)) = entry {
                *letter = (*register, *incremental);
            }
        }
        for lower in b'a'..=b'z' {
            let upper = letters.get(usize::from(lower - 32)).copied().unwrap_or((NONE, false));
            if let Some(slot) = letters.get_mut(usize::from(lower))
                && slot.0 == NONE
            {
                *slot = upper;
            }
        }
        let sequence = machine
            .data
            .iter()
            .find(|row| row.id == crate::machine::ident::data::SEQNO && row.enable)
            .and_then(|row| row.register);
        Self {
            comment: pair(&machine.format.comment),
            message: pair(&machine.format.message),
            opskip: ascii(machine.format.opskip_mark),
            opskip_default: machine.format.opskip_default,
            eob: ascii(machine.format.eob),
            texts: machine
                .tables
                .texts
                .iter()
                .filter_map(|&row| match &machine.codes.get(usize::from(row))?.form {
                    crate::machine::model::CodeForm::Text(text) => Some((text.clone().into_bytes(), row)),
                    _ => None,
                })
                .collect(),
            reads: machine.registers.iter().map(|r| [Read::new(r.format), Read::new(r.secondary)]).collect(),
            macros: machine.preprocessor == crate::machine::model::Preprocessor::Fanuc,
            foreign: crate::dialect::concerns(machine.preprocessor),
            levels: opskip.iter().filter(|&&l| l < 16).fold(0, |bits, &l| bits | 1 << l),
            sequence,
            letters,
            early: Early::new(machine),
        }
    }

    /// The machine has a pre-processor.
    pub(crate) fn has_preprocessor(&self) -> bool {
        self.macros || self.foreign.is_some()
    }

    /// The pre-processor is that of custom macro.
    pub(crate) fn has_macros(&self) -> bool {
        self.macros
    }

    /// The levels of optional skip that are on include this one; `None` is the one that a mark without number means.
    pub(crate) fn skips(&self, level: Option<u8>) -> bool {
        self.levels & 1 << level.unwrap_or(self.opskip_default).min(15) != 0
    }

    /// The machine has operator messages.
    pub(super) fn has_messages(&self) -> bool {
        self.message.is_some()
    }

    /// Active optional-skip levels, bit by level.
    pub(crate) fn levels(&self) -> u16 {
        self.levels
    }

    /// Register of the sequence number.
    pub(crate) fn sequence(&self) -> Option<u8> {
        self.sequence
    }

    /// What words of lines with expressions may be called besides letters.
    pub(super) fn names(&self) -> Names<'_> {
        let early = self.early.as_deref();
        Names {
            like_words: early.map_or(&[], |early| &early.texts),
            registers: early.map_or(&[], |early| &early.registers),
            texts: &self.texts,
        }
    }

    /// Register of a letter, with its incremental flag.
    pub(crate) fn register(&self, letter: u8) -> Option<(u8, bool)> {
        self.letters.get(usize::from(letter)).copied().filter(|&(register, _)| register != NONE)
    }

    /// Splits `line` into `block` (which is cleared first).
    #[inline(always)]
    pub(crate) fn scan(&self, line: &[u8], secondary: bool, block: &mut Block) -> Kind {
        if self.foreign.is_some_and(|concerns| concerns(line)) {
            return Kind::Macro;
        }
        self.split(line, secondary, block, self.macros)
    }

    /// The same, with or without the pre-processor.
    #[inline(never)]
    pub(crate) fn scan_as(&self, line: &[u8], secondary: bool, block: &mut Block, preprocess: bool) -> Kind {
        if preprocess && self.foreign.is_some_and(|concerns| concerns(line)) {
            return Kind::Macro;
        }
        self.split(line, secondary, block, preprocess && self.macros)
    }

    #[inline(always)]
    fn split(&self, line: &[u8], secondary: bool, block: &mut Block, macros: bool) -> Kind {
        block.clear();
        let mut at = 0;
        while let Some(&byte) = line.get(at) {
            if byte == b' ' || byte == b'\t' {
                at += 1;
                continue;
            }
            if let Some(early) = &self.early {
                if macros && early.opens_macro(line, at) {
                    return Kind::Macro;
                }
                if let Some(next) = self.early(early, line, at, secondary, block) {
                    at = next;
                    continue;
                }
            }
            if let Some((register, incremental)) = self.register(byte) {
                match self.word(line, at + 1, (at, register, incremental), secondary, block) {
                    Some(next) => {
                        at = next;
                        continue;
                    }
                    None if macros && self.opens_macro(line, at) => return Kind::Macro,
                    None => {}
                }
            } else if macros && (byte == b'#' || self.opens_macro(line, at)) {
                return Kind::Macro;
            }
            at = self.other(line, at, byte, block);
        }
        Kind::Words
    }

    /// A copy of the line with comments, skipped portions and skip marks blanked out, for the pre-processor. Inside
    /// brackets and in statements a skip character after the first word is a division.
    pub(crate) fn strip(&self, line: &[u8], out: &mut Vec<u8>, block: &mut Block) {
        block.clear();
        out.clear();
        out.extend_from_slice(line);
        let (mut at, mut formula) = (0, marks::Formula::default());
        while let Some(&byte) = line.get(at) {
            let division = Some(byte) == self.opskip && formula.divides();
            let next =
                if formula.depth > 0 && byte == b'(' || division { None } else { self.skip(line, at, byte, block) };
            if let Some(next) = next {
                out.get_mut(at..next.min(line.len())).unwrap_or_default().fill(b' ');
                at = next;
                continue;
            }
            formula.read(self.names(), line, at);
            at += 1;
        }
    }

    /// Position after a comment, message, skip mark with its portion, or end-of-block character at `at`.
    fn skip(&self, line: &[u8], at: usize, byte: u8, block: &mut Block) -> Option<usize> {
        // The same start for both means a comment.
        for (delimiters, message) in [(&self.comment, false), (&self.message, true)] {
            let Some((start, end)) = delimiters else { continue };
            if start.is_empty() || !line.get(at..).is_some_and(|rest| rest.starts_with(start)) {
                continue;
            }
            let inside = at + start.len();
            let close = if end.is_empty() { Some(line.len()) } else { find(line, inside, end) };
            if message {
                block.messages.push((inside as u32, close.unwrap_or(line.len()) as u32));
            }
            block.open_comment |= close.is_none();
            return Some(close.map_or(line.len(), |close| close + end.len()));
        }
        if Some(byte) == self.opskip {
            let (level, next) = match line.get(at + 1) {
                Some(digit @ b'1'..=b'9') => (digit - b'0', at + 2),
                _ => (self.opskip_default, at + 1),
            };
            if self.levels & (1 << level) == 0 {
                return Some(next);
            }
            return Some(self.next_inactive_mark(line, next));
        }
        if Some(byte) == self.eob {
            return Some(at + 1);
        }
        None
    }

    /// Start of the next skip mark of a level that is not active, or the end of the line.
    fn next_inactive_mark(&self, line: &[u8], from: usize) -> usize {
        let mut at = from;
        while let Some(&byte) = line.get(at) {
            if let Some(end) = self.comment_end(line, at) {
                at = end;
                continue;
            }
            if Some(byte) == self.opskip {
                let level = match line.get(at + 1) {
                    Some(digit @ b'1'..=b'9') => digit - b'0',
                    _ => self.opskip_default,
                };
                if self.levels & (1 << level) == 0 {
                    return at;
                }
            }
            at += 1;
        }
        line.len()
    }

    /// Anything that is not a word: returns where to go on.
    fn other(&self, line: &[u8], at: usize, byte: u8, block: &mut Block) -> usize {
        if let Some(next) = self.skip(line, at, byte, block) {
            return next;
        }
        for (text, row) in &self.texts {
            if special::stands(text, line, at) {
                block.texts.push(*row);
                return at + text.len().max(1);
            }
        }
        if byte == b'<'
            && self.macros
            && block.name.is_none()
            && let Some(end) = program_name(line, at)
        {
            block.name = Some((at as u32, end as u32));
            return end;
        }
        if byte < 32 || byte == 127 {
            block.bad_bytes = true;
            return at + 1;
        }
        // Unknown text runs to the next blank or the start of a word.
        let mut end = at + 1;
        while let Some(&next) = line.get(end) {
            if next <= b' ' || Some(next) == self.opskip || self.starts_comment(line, end) || starts_word(line, end) {
                break;
            }
            end += 1;
        }
        let (start, stop) = (at as u32, end as u32);
        match block.unknown.last_mut() {
            Some(last) if last.1 == start => last.1 = stop,
            _ => block.unknown.push((start, stop)),
        }
        end
    }

    /// Place of the first character that ends a block, outside comments and messages.
    pub(super) fn block_end(&self, line: &[u8]) -> Option<usize> {
        let mut at = 0;
        while let Some(&byte) = line.get(at) {
            if Some(byte) == self.eob {
                return Some(at);
            }
            at = self.comment_end(line, at).unwrap_or(at + 1);
        }
        None
    }

    /// Position after the comment or message that begins at `at`: a mark inside is none.
    fn comment_end(&self, line: &[u8], at: usize) -> Option<usize> {
        let rest = line.get(at..)?;
        let starts = |(start, _): &&(Vec<u8>, Vec<u8>)| !start.is_empty() && rest.starts_with(start);
        let (start, end) = [&self.comment, &self.message].into_iter().flatten().find(starts)?;
        let close = if end.is_empty() { None } else { find(line, at + start.len(), end) };
        Some(close.map_or(line.len(), |close| close + end.len()))
    }

    /// A special register or an early text at `at`: where to go on.
    fn early(&self, early: &Early, line: &[u8], at: usize, secondary: bool, block: &mut Block) -> Option<usize> {
        if !early.may_start(*line.get(at)?) {
            return None;
        }
        for (text, row) in &early.texts {
            if special::stands(text, line, at) {
                block.texts.push(*row);
                return Some(at + text.len());
            }
        }
        for special in &early.registers {
            if !line.get(at..)?.starts_with(&special.before) {
                continue;
            }
            let (words, sequence) = (block.words.len(), block.sequence);
            let from = at + special.before.len();
            let Some(end) = self.word(line, from, (at, special.register, special.incremental), secondary, block) else {
                continue;
            };
            if line.get(end..).is_some_and(|rest| rest.starts_with(&special.after)) {
                return Some(end + special.after.len());
            }
            block.words.truncate(words);
            block.sequence = sequence;
        }
        None
    }

    fn starts_comment(&self, line: &[u8], at: usize) -> bool {
        [&self.comment, &self.message]
            .into_iter()
            .flatten()
            .any(|(start, _)| !start.is_empty() && line.get(at..).is_some_and(|rest| rest.starts_with(start)))
    }

    /// A letter, `#` or `[` where a number was expected, or key words: text for the pre-processor.
    fn opens_macro(&self, line: &[u8], at: usize) -> bool {
        special::starts_expression(line, at + 1) || key_word(self.names(), line, at)
    }

    /// Value of a number as a register reads it, and whether it has more digits than the register's format.
    #[inline(always)]
    pub(super) fn reading(&self, register: u8, number: Number, secondary: bool) -> Option<(f64, bool)> {
        let read = self.reads.get(usize::from(register))?.get(usize::from(secondary))?;
        let value = if number.point || !read.implied { number.value } else { implied(number, &read.format) };
        Some((value, number.value.abs() >= if number.point { read.room } else { read.room_without_point }))
    }

    /// A word that begins at `at`, if a number follows its letter or text, which ends at `from`.
    #[inline(always)]
    fn word(
        &self,
        line: &[u8],
        from: usize,
        (at, register, incremental): (usize, u8, bool),
        secondary: bool,
        block: &mut Block,
    ) -> Option<usize> {
        let mut cursor = from;
        while matches!(line.get(cursor), Some(b' ' | b'\t')) {
            cursor += 1;
        }
        let (number, end) = parse_number(line, cursor)?;
        let (value, too_long) = self.reading(register, number, secondary)?;
        block.too_many_digits |= too_long;
        if Some(register) == self.sequence && block.sequence.is_none() && value >= 0.0 {
            block.sequence = Some(value as u32);
            return Some(end);
        }
        block.push(Word { register, incremental, used: false, value, start: at as u32, end: end as u32 });
        Some(end)
    }
}

fn starts_word(line: &[u8], at: usize) -> bool {
    line.get(at).is_some_and(u8::is_ascii_alphabetic)
        && matches!(line.get(at + 1), Some(b'0'..=b'9' | b'.' | b'-' | b'+' | b'#' | b'['))
}

fn find(line: &[u8], from: usize, what: &[u8]) -> Option<usize> {
    memchr::memmem::find(line.get(from..)?, what).map(|at| at + from)
}

/// Powers of ten that are exact in `f64`.
const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Digits whose value is exact in `u64` and `f64`.
const EXACT_DIGITS: usize = 15;

/// Appends the digits at the start of a text to a number; gives it with the rest of the text.
#[inline(always)]
fn leading_digits(mut number: u64, mut text: &[u8]) -> (u64, &[u8]) {
    while let [byte, rest @ ..] = text {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        number = number.wrapping_mul(10).wrapping_add(u64::from(digit));
        text = rest;
    }
    (number, text)
}

/// Parses `[+-]digits[.digits]` at `at`; correctly rounded.
#[inline(always)]
fn parse_number(line: &[u8], at: usize) -> Option<(Number, usize)> {
    let rest = line.get(at..)?;
    let (negative, text) = match rest {
        [b'-', text @ ..] => (true, text),
        [b'+', text @ ..] => (false, text),
        text => (false, text),
    };
    let (mantissa, after) = leading_digits(0, text);
    let digits = text.len() - after.len();
    let (mantissa, fraction, point, length) = match after {
        [b'.', decimals @ ..] => {
            let (mantissa, after) = leading_digits(mantissa, decimals);
            let fraction = decimals.len() - after.len();
            (mantissa, fraction, true, digits + 1 + fraction)
        }
        _ => (mantissa, 0, false, digits),
    };
    if digits + fraction == 0 {
        return None;
    }
    let magnitude = match POW10.get(fraction) {
        // Both sides are exact, so the quotient is correctly rounded.
        Some(power) if digits + fraction <= EXACT_DIGITS => mantissa as f64 / power,
        _ => std::str::from_utf8(text.get(..length)?).ok()?.parse().ok()?,
    };
    let value = if negative { -magnitude } else { magnitude };
    let number = Number { value, point, digits: digits.min(255) as u8 };
    Some((number, at + (rest.len() - text.len()) + length))
}

/// How a register's numbers are read.
#[derive(Debug, Clone, Copy)]
struct Read {
    format: NumberFormat,
    /// A number without a point has an implied one.
    implied: bool,
    /// Numbers from here on have more whole digits than the format.
    room: f64,
    /// The same without a written point: an implied one leaves room for the fraction too.
    room_without_point: f64,
}

impl Read {
    fn new(format: NumberFormat) -> Self {
        let power = |digits: u8| POW10.get(usize::from(digits)).copied().unwrap_or(f64::INFINITY);
        let implied = format.point == Point::Omit;
        let room = power(format.whole);
        let room_without_point = if implied { power(format.whole.saturating_add(format.frac)) } else { room };
        Self { format, implied, room, room_without_point }
    }
}

/// Value of a number without a point in a register that implies one (reference control-emulator.md 1.4).
fn implied(number: Number, format: &NumberFormat) -> f64 {
    let power = |n: u8| POW10.get(usize::from(n)).copied().unwrap_or(1.0);
    if format.point != Point::Omit || format.frac == 0 {
        number.value
    } else if format.trail == Zeros::Omit && format.lead != Zeros::Omit {
        // Left-justified into the whole digits.
        if number.digits <= format.whole {
            number.value * power(format.whole - number.digits)
        } else {
            number.value / power(number.digits - format.whole)
        }
    } else {
        number.value / power(format.frac)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_to_the_last_bit() {
        for text in
            ["0", "12", "-3.5", "+.125", "90.1999", "123456.7891", "0.1", "1.", "99999999999999999999.5", ".000001"]
        {
            let (number, end) = parse_number(text.as_bytes(), 0).unwrap();
            assert_eq!(end, text.len());
            assert_eq!(number.value, text.trim_start_matches('+').parse::<f64>().unwrap(), "{text}");
        }
        for text in ["", "-", ".", "+.", "X", "e5"] {
            assert!(parse_number(text.as_bytes(), 0).is_none(), "{text}");
        }
    }

    #[test]
    fn implied_points() {
        let format = |lead, trail| NumberFormat { whole: 4, frac: 3, point: Point::Omit, lead, trail, plus: false };
        let number = |text: &str| parse_number(text.as_bytes(), 0).unwrap().0;
        assert_eq!(implied(number("12500"), &format(Zeros::Omit, Zeros::Keep)), 12.5);
        assert_eq!(implied(number("00125"), &format(Zeros::Keep, Zeros::Omit)), 12.5);
        assert_eq!(
            implied(number("125"), &NumberFormat { point: Point::Keep, ..format(Zeros::Omit, Zeros::Omit) }),
            125.0
        );
    }
}
