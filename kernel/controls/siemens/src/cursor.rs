//! A place in the text of a block, and the small pieces that are read there.
//!
//! Invariant: the place moves forward only, and is always between two characters of the text.

/// A place in a text.
#[derive(Debug, Clone)]
pub(super) struct SiemensCursor<'a> {
    text: &'a str,
    at: usize,
    /// Parentheses, brackets and arguments around the place.
    pub(super) depth: usize,
    /// Operators of the expression so far.
    pub(super) operators: usize,
}

/// Whether a byte may begin a name.
pub(super) fn begins_name(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || byte == b'_' || byte == b'$'
}

/// Whether a byte may be inside a name.
pub(super) fn in_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

impl<'a> SiemensCursor<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, at: 0, depth: 0, operators: 0 }
    }

    /// The same depth in a part of the text.
    pub(super) fn inside(&self, text: &'a str) -> Self {
        Self { text, at: 0, depth: self.depth + 1, operators: self.operators }
    }

    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// Goes back to a place that [`SiemensCursor::at`] gave.
    pub(super) fn back_to(&mut self, at: usize) {
        self.at = at;
    }

    pub(super) fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// Text from a place up to here.
    pub(super) fn since(&self, from: usize) -> &'a str {
        self.text.get(from..self.at).unwrap_or_default()
    }

    /// The byte this many after this one, 0 at the end.
    pub(super) fn byte(&self, ahead: usize) -> u8 {
        self.text.as_bytes().get(self.at + ahead).copied().unwrap_or(0)
    }

    /// The next byte after blanks; 0 at the end.
    pub(super) fn next_byte(&self) -> u8 {
        let rest = self.text.as_bytes().get(self.at..).unwrap_or_default();
        rest.iter().copied().find(|byte| !matches!(byte, b' ' | b'\t')).unwrap_or(0)
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.text.len()
    }

    pub(super) fn blanks(&mut self) {
        while matches!(self.byte(0), b' ' | b'\t') {
            self.at += 1;
        }
    }

    /// Passes blanks between a name and its brackets, which say nothing; others stay.
    pub(super) fn blanks_before_brackets(&mut self) {
        let from = self.at;
        self.blanks();
        if !matches!(self.byte(0), b'(' | b'[') {
            self.at = from;
        }
    }

    /// One character on.
    pub(super) fn step(&mut self) {
        self.at += self.rest().chars().next().map_or(0, char::len_utf8);
    }

    /// Takes a symbol, after blanks.
    pub(super) fn takes(&mut self, symbol: &str) -> bool {
        let from = self.at;
        self.blanks();
        if self.rest().starts_with(symbol) {
            self.at += symbol.len();
            return true;
        }
        self.at = from;
        false
    }

    /// Whether the sign of an assignment comes next, after blanks.
    pub(super) fn assigns(&self) -> bool {
        let rest = self.rest().trim_start_matches([' ', '\t']).as_bytes();
        rest.first() == Some(&b'=') && rest.get(1) != Some(&b'=')
    }

    /// The name that comes next, after blanks, as it is written.
    pub(super) fn peeked_name(&self) -> Option<&'a str> {
        let rest = self.rest().trim_start_matches([' ', '\t']);
        let bytes = rest.as_bytes();
        if !bytes.first().copied().is_some_and(begins_name) {
            return None;
        }
        let length = 1 + bytes.iter().skip(1).take_while(|byte| in_name(**byte)).count();
        rest.get(..length)
    }

    /// Takes that name.
    pub(super) fn name(&mut self) -> Option<&'a str> {
        let name = self.peeked_name()?;
        self.blanks();
        self.at += name.len();
        Some(name)
    }

    /// Takes a keyword, if it is next.
    pub(super) fn word(&mut self, word: &str) -> bool {
        let is = self.peeked_name().is_some_and(|name| name.eq_ignore_ascii_case(word));
        if is {
            self.name();
        }
        is
    }

    /// Takes digits.
    pub(super) fn digits(&mut self) -> &'a str {
        let from = self.at;
        while self.byte(0).is_ascii_digit() {
            self.at += 1;
        }
        self.since(from)
    }

    /// Takes `digits[.digits]` with at least one digit; whether there was a point.
    pub(super) fn decimal(&mut self) -> Option<(&'a str, bool)> {
        let from = self.at;
        let mut count = self.digits().len();
        let point = self.byte(0) == b'.';
        if point {
            self.at += 1;
            count += self.digits().len();
        }
        if count == 0 {
            self.at = from;
            return None;
        }
        Some((self.since(from), point))
    }

    /// Takes a text in quotation marks, without them; its end may be missing at the end of the block.
    pub(super) fn quoted(&mut self) -> Option<&'a str> {
        if self.byte(0) != b'"' {
            return None;
        }
        let inner = self.text.get(self.at + 1..)?;
        let length = inner.find('"')?;
        self.at += length + 2;
        inner.get(..length)
    }

    /// Takes the text in the parentheses that open here, without the parentheses.
    pub(super) fn enclosed(&mut self, open: u8, close: u8) -> Option<&'a str> {
        self.blanks();
        if self.byte(0) != open {
            return None;
        }
        let (mut depth, mut quoted) = (0_usize, false);
        for (at, byte) in self.rest().bytes().enumerate() {
            match byte {
                b'"' => quoted = !quoted,
                _ if quoted => {}
                _ if byte == open => depth += 1,
                _ if byte == close => {
                    depth -= 1;
                    if depth == 0 {
                        let inner = self.rest().get(1..at);
                        self.at += at + 1;
                        return inner;
                    }
                }
                _ => {}
            }
        }
        None
    }
}

/// Parts of a list between commas that are in no parentheses and no text.
pub(super) fn split_list(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth, mut quoted) = (Vec::new(), 0, 0_i32, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            _ if quoted => {}
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth -= 1,
            b',' if depth == 0 => {
                parts.push(text.get(from..at).unwrap_or_default().trim());
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text.get(from..).unwrap_or_default().trim());
    parts
}
