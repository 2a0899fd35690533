//! From the bytes of a line to a block without number, comment and marks, and a cursor over it.
//!
//! Facts: programming manuals of the control: a block begins with its number (conversational) or with N (ISO), `;`
//! begins a comment, `*` a structure line or, at the end of a block, its end, `~` at the end continues in the next
//! line. Invariant: outside quotation marks everything is in capital letters.

use std::borrow::Cow;

use counterpoint_control_api::text::without_comment;

/// A block as it is read.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Clean {
    /// Block number.
    pub(super) number: Option<u32>,
    /// The rest, empty if there is nothing to do.
    pub(super) text: String,
    /// Where the rest begins in the line.
    pub(super) start: usize,
    /// The next line belongs to it.
    pub(super) continues: bool,
    /// It has nothing to do because it is a comment or is skipped.
    pub(super) silent: bool,
    /// Whether it has a mark of optional skip, so that its compiled form may become invalid.
    pub(super) marked: bool,
}

/// Takes number, comment and marks off a line; `skips` tells whether blocks of a level are skipped.
pub(super) fn clean(raw: &[u8], skips: &dyn Fn(Option<u8>) -> bool) -> Clean {
    let raw = String::from_utf8_lossy(raw);
    let mut block = Clean::default();
    let mut rest = raw.trim();
    if let Some(before) = rest.strip_suffix('~') {
        (block.continues, rest) = (true, before);
    }
    let whole = rest.len();
    rest = without_comment(rest);
    block.silent = rest.len() < whole;
    rest = rest.trim();
    if let Some(before) = rest.strip_suffix('~') {
        (block.continues, rest) = (true, before.trim_end());
    }
    for _ in 0..2 {
        if let Some(behind) = rest.strip_prefix('/') {
            let level = behind.bytes().next().filter(|byte| (b'1'..=b'9').contains(byte)).map(|byte| byte - b'0');
            block.marked = true;
            if skips(level) {
                return Clean { marked: true, silent: true, continues: block.continues, ..Clean::default() };
            }
            rest = behind.get(usize::from(level.is_some())..).unwrap_or_default().trim_start();
        }
        if block.number.is_none() {
            (block.number, rest) = number(rest);
        }
    }
    if rest.starts_with('*') {
        return Clean { text: String::new(), silent: true, ..block };
    }
    let rest = rest.strip_suffix('*').map_or(rest, str::trim_end);
    block.text = capitals(rest);
    // The rest is a part of the line.
    block.start = (rest.as_ptr() as usize).saturating_sub(raw.as_ptr() as usize);
    block
}

/// Block number at the beginning.
fn number(text: &str) -> (Option<u32>, &str) {
    let digits = text.strip_prefix(['N', 'n']).map_or(text, str::trim_start);
    let end = digits.bytes().take_while(u8::is_ascii_digit).count();
    let (number, rest) = digits.split_at_checked(end).unwrap_or(("", digits));
    if end == 0 || rest.starts_with(['.', ',', '=']) {
        return (None, text);
    }
    (number.parse().ok(), rest.trim_start())
}

/// Capital letters outside quotation marks.
pub(super) fn capitals(text: &str) -> String {
    if !text.bytes().any(|byte| byte.is_ascii_lowercase() || byte == b'\t') {
        return text.to_owned();
    }
    let mut quoted = false;
    let large = |c: char| {
        quoted ^= c == '"';
        match c {
            '\t' => ' ',
            c if quoted => c,
            c => c.to_ascii_uppercase(),
        }
    };
    text.chars().map(large).collect()
}

/// A place in the text of a block.
#[derive(Debug, Clone)]
pub(super) struct HeidenhainCursor<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> HeidenhainCursor<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Self { text, at: 0 }
    }

    /// The rest.
    pub(super) fn rest(&self) -> &'t str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// Where it is in the text.
    pub(super) fn place(&self) -> usize {
        self.at
    }

    /// Column for messages, from 1.
    pub(super) fn column(&self) -> usize {
        self.at + 1
    }

    pub(super) fn blanks(&mut self) {
        while self.next_byte() == Some(b' ') {
            self.at += 1;
        }
        if !self.next_byte().is_some_and(|byte| byte.is_ascii_graphic()) {
            self.at += self.rest().len() - self.rest().trim_start().len();
        }
    }

    /// The next byte after blanks.
    pub(super) fn peek(&mut self) -> Option<u8> {
        self.blanks();
        self.next_byte()
    }

    /// The very next byte.
    pub(super) fn next_byte(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    pub(super) fn is_over(&mut self) -> bool {
        self.peek().is_none()
    }

    /// Takes one character.
    pub(super) fn bump(&mut self) -> Option<char> {
        let next = self.rest().chars().next()?;
        self.at += next.len_utf8();
        Some(next)
    }

    /// Takes a character after blanks, if it is the next one.
    pub(super) fn take(&mut self, wanted: u8) -> bool {
        let is = self.peek() == Some(wanted);
        self.at += usize::from(is);
        is
    }

    /// Takes a text after blanks, if it is the next one.
    pub(super) fn take_text(&mut self, wanted: &str) -> bool {
        self.blanks();
        let is = self.rest().starts_with(wanted);
        self.at += if is { wanted.len() } else { 0 };
        is
    }

    /// Takes words with any blanks between them, if no letter follows.
    pub(super) fn keyword(&mut self, wanted: &str) -> bool {
        let start = self.at;
        for word in wanted.split(' ') {
            if !self.take_text(word) {
                self.at = start;
                return false;
            }
        }
        let ends = !self.next_byte().is_some_and(|byte| byte.is_ascii_alphabetic() || byte == b'_');
        if !ends {
            self.at = start;
        }
        ends
    }

    /// Letters and underscores.
    pub(super) fn letters(&mut self) -> &'t str {
        self.run(|byte| byte.is_ascii_alphabetic() || byte == b'_')
    }

    /// Takes bytes as long as they fit.
    pub(super) fn run(&mut self, fits: impl Fn(u8) -> bool) -> &'t str {
        let rest = self.rest();
        // Only ASCII bytes fit, so the end is that of a character.
        let end = rest.bytes().position(|byte| !byte.is_ascii() || !fits(byte)).unwrap_or(rest.len());
        self.at += end;
        rest.get(..end).unwrap_or_default()
    }

    /// A number without sign: its text, with a point for a decimal comma, and its value.
    pub(super) fn number(&mut self) -> Option<(Cow<'t, str>, f64)> {
        self.blanks();
        let start = self.at;
        let mut text = Cow::Borrowed(self.run(|byte| byte.is_ascii_digit() || byte == b'.'));
        let decimals = self.rest().strip_prefix(',').and_then(|behind| behind.bytes().next());
        if !text.is_empty() && !text.contains('.') && decimals.is_some_and(|byte| byte.is_ascii_digit()) {
            self.at += 1;
            text = Cow::Owned(format!("{text}.{}", self.run(|byte| byte.is_ascii_digit())));
        }
        match text.parse() {
            Ok(value) if text.bytes().any(|byte| byte.is_ascii_digit()) => Some((text, value)),
            _ => {
                self.at = start;
                None
            }
        }
    }

    /// A whole number without sign.
    pub(super) fn whole(&mut self) -> Option<u32> {
        self.blanks();
        let start = self.at;
        let value = self.run(|byte| byte.is_ascii_digit()).parse().ok();
        if value.is_none() {
            self.at = start;
        }
        value
    }

    /// A text in quotation marks; one that is not closed goes to the end.
    pub(super) fn quoted(&mut self) -> Option<&'t str> {
        if !self.take(b'"') {
            return None;
        }
        let rest = self.rest();
        let end = rest.find('"').unwrap_or(rest.len());
        self.at = (self.at + end + 1).min(self.text.len());
        rest.get(..end)
    }

    /// Everything up to the end.
    pub(super) fn all(&mut self) -> &'t str {
        let rest = self.rest().trim();
        self.at = self.text.len();
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(text: &str) -> (Option<u32>, String, bool) {
        let clean = clean(text.as_bytes(), &|_| false);
        (clean.number, clean.text, clean.continues)
    }

    #[test]
    fn numbers_comments_and_marks_are_taken_off() {
        assert_eq!(cleaned("12 l x+1 ; go"), (Some(12), "L X+1".into(), false));
        assert_eq!(cleaned("N10 G01 X+5 *"), (Some(10), "G01 X+5".into(), false));
        assert_eq!(cleaned("* - Part 1"), (None, String::new(), false));
        assert_eq!(cleaned("3 * - Part 1"), (Some(3), String::new(), false));
        assert_eq!(cleaned("QS1 = \"a;b\" ~"), (None, "QS1 = \"a;b\"".into(), true));
        assert_eq!(cleaned("Q200=2 ;SET-UP ~"), (None, "Q200=2".into(), true));
        assert_eq!(cleaned("/ 4 X+1"), (Some(4), "X+1".into(), false));
        assert_eq!(cleaned("4 /2 X+1"), (Some(4), "X+1".into(), false));
    }

    #[test]
    fn a_decimal_comma_is_a_point() {
        let number = |text: &str| HeidenhainCursor::new(text).number().map(|(text, value)| (text.into_owned(), value));
        assert_eq!(number("1,25 X"), Some(("1.25".into(), 1.25)));
        assert_eq!(number("1.5,2"), Some(("1.5".into(), 1.5)));
        assert_eq!(number("7, 8"), Some(("7".into(), 7.0)));
        assert_eq!(number(",5"), None);
    }

    #[test]
    fn key_words_end_where_a_letter_does_not_follow() {
        let mut cursor = HeidenhainCursor::new("CALL  LBL 5");
        assert!(!cursor.keyword("CAL"));
        assert!(cursor.keyword("CALL LBL"));
        assert_eq!(cursor.whole(), Some(5));
        assert!(cursor.is_over());
    }
}
