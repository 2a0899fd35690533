//! Source text of a file of macros and places in it.
//!
//! *Invariant:* every offset kept in tokens, trees and bytecode is a byte offset into one source's text.

/// A stretch of a source, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub start: u32,
    /// Byte after the last one.
    pub end: u32,
}

impl Span {
    /// The stretch from the start of `self` to the end of `other`.
    #[must_use]
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// One file of macros.
#[derive(Clone, Debug)]
pub struct MacroSource {
    /// Name shown in diagnostics.
    pub name: String,
    /// Text, at most 4 GiB; the rest of longer text is left out.
    pub text: String,
    starts: Vec<u32>,
}

impl MacroSource {
    /// Takes a text.
    #[must_use]
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> MacroSource {
        let mut text = text.into();
        if u32::try_from(text.len()).is_err() {
            let cut = text.floor_char_boundary(u32::MAX as usize);
            text.truncate(cut);
        }
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0).chain(ends.map(|(at, _)| u32::try_from(at + 1).unwrap_or(u32::MAX))).collect();
        MacroSource { name: name.into(), text, starts }
    }

    /// Accepts any bytes. Bytes that are not UTF-8 are replaced and then refused by the lexer as a strange character.
    #[must_use]
    pub fn from_bytes(name: impl Into<String>, bytes: &[u8]) -> MacroSource {
        MacroSource::new(name, String::from_utf8_lossy(bytes))
    }

    /// Line (1-based) of an offset.
    #[must_use]
    pub fn line(&self, offset: u32) -> u32 {
        u32::try_from(self.starts.partition_point(|start| *start <= offset)).unwrap_or(u32::MAX)
    }

    /// Line and column (1-based, in characters) of an offset.
    #[must_use]
    pub fn place(&self, offset: u32) -> (u32, u32) {
        let line = self.line(offset);
        let start = self.starts.get(line as usize - 1).copied().unwrap_or(0);
        let before = self.text.get(start as usize..offset as usize).unwrap_or("");
        (line, u32::try_from(before.chars().count() + 1).unwrap_or(u32::MAX))
    }

    /// Text of a line (1-based) without its end.
    #[must_use]
    pub fn line_text(&self, line: u32) -> &str {
        let Some(&start) = (line as usize).checked_sub(1).and_then(|at| self.starts.get(at)) else { return "" };
        let end = self.starts.get(line as usize).map_or(self.text.len(), |end| *end as usize);
        self.text.get(start as usize..end).unwrap_or("").trim_end_matches(['\n', '\r'])
    }

    /// Text of a stretch.
    #[must_use]
    pub fn slice(&self, span: Span) -> &str {
        self.text.get(span.start as usize..span.end as usize).unwrap_or("")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_from_one_in_characters() {
        let source = MacroSource::new("m", "A=1\r\nÄ='é'\nB");
        assert_eq!(source.place(0), (1, 1));
        assert_eq!(source.place(5), (2, 1));
        assert_eq!(source.place(7), (2, 2));
        assert_eq!(source.line_text(1), "A=1");
        assert_eq!(source.line_text(2), "Ä='é'");
        assert_eq!(source.line_text(3), "B");
        assert_eq!(source.line_text(9), "");
    }
}
