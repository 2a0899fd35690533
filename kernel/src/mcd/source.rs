//! A source file: its bytes and the index of its lines.
//!
//! A byte order mark is no text; UTF-16 becomes UTF-8. Invariant: other bytes are kept as they are; a line ends at LF,
//! CR LF or a lone CR, and the line's text excludes its end. Lines count from 1.

use std::ops::RangeInclusive;
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use rustc_hash::FxHashMap;

use super::program::{self, Range, Shape};
use super::spot::Spot;
use super::syntax::Syntax;
use crate::control::Stop;

/// A file of the job.
#[derive(Debug)]
pub struct Source {
    /// Name as the job knows it.
    pub name: String,
    bytes: Bytes,
    /// Start of each line, and one past the end as last entry.
    starts: Vec<u32>,
    shape: Arc<Shape>,
    stop: Stop,
    programs: OnceLock<Vec<Range>>,
    sequences: OnceLock<FxHashMap<u32, Vec<Spot>>>,
    /// Whether a byte comes up in the text: the one that was asked for first.
    has: OnceLock<(u8, bool)>,
}

/// A text without its byte order mark, in UTF-8 if it is UTF-16. UTF-16 without a mark is told by zeros in every second
/// byte of its first two characters.
fn plain(bytes: Bytes, stop: &Stop) -> Bytes {
    let wide = |from: usize, unit: fn([u8; 2]) -> u16| {
        let pairs = bytes.get(from..).unwrap_or_default().chunks_exact(2);
        let units = pairs.filter_map(|pair| pair.try_into().ok().map(unit));
        let units = units.take_while(|_| !stop.asked());
        let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        Bytes::from(characters.collect::<String>())
    };
    match *bytes {
        [0xEF, 0xBB, 0xBF, ..] => bytes.slice(3..),
        [0xFF, 0xFE, ..] => wide(2, u16::from_le_bytes),
        [0xFE, 0xFF, ..] => wide(2, u16::from_be_bytes),
        [1..=255, 0, 1..=255, 0, ..] => wide(0, u16::from_le_bytes),
        [0, 1..=255, 0, 1..=255, ..] => wide(0, u16::from_be_bytes),
        _ => bytes,
    }
}

impl Source {
    /// Indexes the lines of `bytes`. Files of 4 GiB or more are cut at 4 GiB − 1.
    #[must_use]
    pub fn new(name: impl Into<String>, bytes: Bytes) -> Self {
        Self::shaped(name, bytes, Arc::default(), Stop::default())
    }

    /// What the pre-processor of the machine makes of it.
    #[must_use]
    pub fn syntax(&self) -> &'static Syntax {
        self.shape.syntax()
    }

    /// The same for a machine, which may tell its programs apart in a way of its own. When `stop` is asked for, what is
    /// looked for in the text ends where it is: nothing may be made of that any more.
    #[must_use]
    pub fn shaped(name: impl Into<String>, bytes: Bytes, shape: Arc<Shape>, stop: Stop) -> Self {
        let bytes = plain(bytes, &stop);
        let limit = bytes.len().min(u32::MAX as usize - 1);
        let text = bytes.get(..limit).unwrap_or_default();
        let mut starts = Vec::with_capacity(text.len() / 16 + 2);
        starts.push(0);
        for at in memchr::memchr2_iter(b'\n', b'\r', text) {
            if text.get(at) == Some(&b'\r') && text.get(at + 1) == Some(&b'\n') {
                continue;
            }
            starts.push(at as u32 + 1);
            if stop.asked() {
                break;
            }
        }
        if starts.last().is_some_and(|&last| (last as usize) < limit) {
            starts.push(limit as u32);
        }
        starts.shrink_to_fit();
        let (programs, sequences, has) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self { name: name.into(), bytes, starts, shape, stop, programs, sequences, has }
    }

    /// The whole text.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Whether a byte comes up in the text; the byte that is asked for first is looked for once.
    #[inline(always)]
    pub(crate) fn has(&self, byte: u8) -> bool {
        match self.has.get() {
            Some((known, has)) if *known == byte => *has,
            _ => self.find(byte),
        }
    }

    #[cold]
    #[inline(never)]
    fn find(&self, byte: u8) -> bool {
        let find = || memchr::memchr(byte, &self.bytes).is_some();
        match *self.has.get_or_init(|| (byte, find())) {
            (known, has) if known == byte => has,
            _ => find(),
        }
    }

    /// Number of lines.
    #[must_use]
    pub fn lines(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// The numbers of these lines, as long as nobody wants the job to end.
    pub(crate) fn walk(&self, first: u32, last: u32) -> impl DoubleEndedIterator<Item = u32> + Clone + '_ {
        Walk { lines: first..=last, stop: &self.stop }
    }

    /// Text of line `number` (from 1) without its end; empty beyond the file.
    #[must_use]
    pub fn line(&self, number: u32) -> &[u8] {
        let index = (number as usize).wrapping_sub(1);
        let (Some(&start), Some(&end)) = (self.starts.get(index), self.starts.get(index.wrapping_add(1))) else {
            return &[];
        };
        let mut line = self.bytes.get(start as usize..end as usize).unwrap_or_default();
        if let [head @ .., b'\n'] = line {
            line = head;
        }
        if let [head @ .., b'\r'] = line {
            line = head;
        }
        line
    }

    /// The programs in the file, in order. Text before the first definition is one without number, so is a file without
    /// definitions.
    #[must_use]
    pub fn programs(&self) -> &[Range] {
        self.programs.get_or_init(|| program::ranges(self, &self.shape))
    }

    /// The name that a line defines a program by.
    pub(crate) fn name_at(&self, line: u32) -> Option<&[u8]> {
        self.shape.name(self.line(line))
    }

    /// A line without comments and messages, in capitals.
    pub(super) fn words(&self, line: u32) -> Vec<u8> {
        self.shape.words(self.line(line))
    }

    /// Something stands in a line besides blanks, comments and a rewind-stop.
    pub(crate) fn has_text(&self, line: u32) -> bool {
        self.shape.has_text(self.line(line))
    }

    /// The program of a name, letter case ignored.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<Range> {
        let is = |range: &&Range| self.name_at(range.first).is_some_and(|n| n.eq_ignore_ascii_case(name.as_bytes()));
        self.programs().iter().filter(|range| range.number.is_none()).find(is).copied()
    }

    /// A program has no definition: it is the text of the file, or what stands before the first definition.
    #[must_use]
    pub fn is_plain(&self, range: Range) -> bool {
        range.number.is_none() && self.name_at(range.first).is_none()
    }

    /// Blocks that begin with sequence number `number`, ascending.
    #[must_use]
    pub(crate) fn sequences(&self, number: u32) -> &[Spot] {
        self.sequences
            .get_or_init(|| {
                let mut index: FxHashMap<u32, Vec<Spot>> = FxHashMap::default();
                for line in self.walk(1, self.lines()) {
                    let text = self.line(line);
                    for offset in self.shape.block_starts(text) {
                        let block = text.get(offset..).unwrap_or_default();
                        if let Some(number) = program::leading_number(block, b'N') {
                            index.entry(number).or_default().push(Spot { line, offset: offset as u32 });
                        }
                    }
                }
                index
            })
            .get(&number)
            .map_or(&[], Vec::as_slice)
    }

    /// Size in bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        self.bytes.len()
    }
}

/// Lines until somebody wants the job to end.
#[derive(Debug, Clone)]
struct Walk<'s> {
    lines: RangeInclusive<u32>,
    stop: &'s Stop,
}

impl Iterator for Walk<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        if self.stop.asked() { None } else { self.lines.next() }
    }
}

impl DoubleEndedIterator for Walk<'_> {
    fn next_back(&mut self) -> Option<u32> {
        if self.stop.asked() { None } else { self.lines.next_back() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        let source = Source::new("t", Bytes::copy_from_slice(text.as_bytes()));
        (1..=source.lines()).map(|n| String::from_utf8_lossy(source.line(n)).into_owned()).collect()
    }

    #[test]
    fn every_kind_of_line_end_ends_a_line() {
        assert_eq!(lines("a\nb\r\nc\rd"), ["a", "b", "c", "d"]);
        assert_eq!(lines("a\n\nb\n"), ["a", "", "b"]);
        assert_eq!(lines("\r\r\n\r"), ["", "", ""]);
        assert!(lines("").is_empty());
    }

    #[test]
    fn byte_order_marks_and_wide_characters_are_understood() {
        let text = "%\nO1 (\u{fc})\r\nG0 X1.\rM30";
        let expected = ["%", "O1 (\u{fc})", "G0 X1.", "M30"];
        let read = |bytes: Vec<u8>| {
            let source = Source::new("t", bytes.into());
            (1..=source.lines()).map(|n| String::from_utf8_lossy(source.line(n)).into_owned()).collect::<Vec<_>>()
        };
        let wide = |mark: &str, unit: fn(u16) -> [u8; 2]| {
            format!("{mark}{text}").encode_utf16().flat_map(unit).collect::<Vec<u8>>()
        };
        assert_eq!(read(format!("\u{feff}{text}").into_bytes()), expected);
        for mark in ["\u{feff}", ""] {
            assert_eq!(read(wide(mark, u16::to_le_bytes)), expected, "{mark:?}");
            assert_eq!(read(wide(mark, u16::to_be_bytes)), expected, "{mark:?}");
        }
        // Half a character at the end, and half of a pair, are no reason to give up.
        assert_eq!(read(vec![0xFF, 0xFE, b'G', 0, b'0']), ["G"]);
        assert_eq!(read(vec![0xFE, 0xFF, 0xD8, 0, 0, b'M']), ["\u{fffd}M"]);
    }

    #[test]
    fn nothing_is_looked_for_when_the_job_is_to_end() {
        let stop = Stop::default();
        let text = Bytes::from_static(b"O1\nN1\nO2\nN2\n");
        let source = Source::shaped("t", text, Arc::default(), stop.clone());
        assert_eq!(source.walk(2, 3).collect::<Vec<_>>(), [2, 3]);
        stop.ask();
        assert_eq!(source.walk(1, 4).count(), 0);
        assert!(source.programs().iter().all(|range| range.number.is_none()));
        assert!(source.sequences(2).is_empty());
    }

    #[test]
    fn beyond_the_file_is_empty() {
        let source = Source::new("t", Bytes::from_static(b"G1"));
        assert_eq!(source.line(0), b"");
        assert_eq!(source.line(1), b"G1");
        assert_eq!(source.line(2), b"");
    }
}
