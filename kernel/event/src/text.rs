//! The text of a file, line by line.
//!
//! A byte order mark is not part of the text; UTF-16 becomes UTF-8. Invariant: other bytes are kept as they are; a line
//! ends at LF, CR LF or a lone CR, and the line's text excludes its end. Lines count from 1.

use bytes::Bytes;

/// A text and the places of its lines.
#[derive(Debug)]
pub struct Text {
    bytes: Bytes,
    /// Start of each line, and one past the end as last entry.
    starts: Vec<u32>,
}

/// A text without its byte order mark, in UTF-8 if it is UTF-16. UTF-16 without a mark shows zeros in every second
/// byte of its first two characters.
fn plain(bytes: Bytes, asked: impl Fn() -> bool) -> Bytes {
    let wide = |from: usize, unit: fn([u8; 2]) -> u16| {
        let pairs = bytes.get(from..).unwrap_or_default().chunks_exact(2);
        let units = pairs.filter_map(|pair| pair.try_into().ok().map(unit));
        let units = units.take_while(|_| !asked());
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

impl Text {
    /// Indexes the lines of `bytes`. A text of 4 GiB or more is cut at 4 GiB − 1. Once `asked` says that the job is to
    /// end, the rest has no lines.
    #[must_use]
    pub fn new(bytes: Bytes, asked: impl Fn() -> bool) -> Self {
        let bytes = plain(bytes, &asked);
        let limit = bytes.len().min(u32::MAX as usize - 1);
        let text = bytes.get(..limit).unwrap_or_default();
        let mut starts = Vec::with_capacity(text.len() / 16 + 2);
        starts.push(0);
        for at in memchr::memchr2_iter(b'\n', b'\r', text) {
            if text.get(at) == Some(&b'\r') && text.get(at + 1) == Some(&b'\n') {
                continue;
            }
            starts.push(at as u32 + 1);
            if asked() {
                break;
            }
        }
        if starts.last().is_some_and(|&last| (last as usize) < limit) {
            starts.push(limit as u32);
        }
        starts.shrink_to_fit();
        Self { bytes, starts }
    }

    /// The whole text.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Size in bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        self.bytes.len()
    }

    /// Number of lines.
    #[must_use]
    pub fn lines(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// Number of the line that contains the byte at `at`.
    #[must_use]
    pub fn line_at(&self, at: usize) -> u32 {
        self.starts.partition_point(|start| *start as usize <= at) as u32
    }

    /// Byte at which line `number` (from 1) begins; the length of the text if there is no such line.
    #[must_use]
    pub fn start(&self, number: u32) -> usize {
        self.starts.get((number as usize).wrapping_sub(1)).map_or(self.bytes.len(), |start| *start as usize)
    }

    /// Text of line `number` (from 1) without its end; empty beyond the file.
    #[must_use]
    #[inline]
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        let text_of = Text::new(Bytes::copy_from_slice(text.as_bytes()), || false);
        (1..=text_of.lines()).map(|n| String::from_utf8_lossy(text_of.line(n)).into_owned()).collect()
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
            let text_of = Text::new(bytes.into(), || false);
            (1..=text_of.lines()).map(|n| String::from_utf8_lossy(text_of.line(n)).into_owned()).collect::<Vec<_>>()
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
    fn every_byte_is_in_the_line_that_begins_at_it_or_before() {
        let text_of = Text::new(Bytes::from_static(b"G0\r\n\nM30\rO1"), || false);
        let lines: Vec<u32> = (0..text_of.size()).map(|at| text_of.line_at(at)).collect();
        assert_eq!(lines, [1, 1, 1, 1, 2, 3, 3, 3, 3, 4, 4]);
        assert_eq!([1, 2, 3, 4, 5].map(|line| text_of.start(line)), [0, 4, 5, 9, 11]);
    }

    #[test]
    fn beyond_the_file_is_empty() {
        let text_of = Text::new(Bytes::from_static(b"G1"), || false);
        assert_eq!(text_of.line(0), b"");
        assert_eq!(text_of.line(1), b"G1");
        assert_eq!(text_of.line(2), b"");
    }
}
