//! Words of a block: names with numbers, parameters or nothing after them.
//!
//! Facts: release notes of the Heidenhain pre-processor (word addresses followed by Q, QL, QR and QS). Invariant: a
//! number keeps its text, and text that is not a word stays unchanged, so that the tables of the machine decide.

use counterpoint_fault::Halt;
use std::borrow::Cow;
use std::sync::{Arc, LazyLock};

use super::eval::Evaluator;
use super::formula::{Name, parameter};
use super::lex::Cursor;
use super::variables::Value;

/// The text after the name of a word.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Operand {
    None,
    /// As written, and its value.
    Number(Arc<str>, f64),
    /// A sign alone, as in `DR+`.
    Sign(char),
    Parameter {
        negative: bool,
        name: Name,
    },
}

/// A word.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word {
    pub(super) name: Arc<str>,
    pub(super) operand: Operand,
}

/// A word with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Seen {
    pub(super) name: Arc<str>,
    pub(super) value: Option<f64>,
    /// Its rest.
    pub(super) text: String,
}

impl Seen {
    /// A word that the pre-processor makes.
    pub(super) fn made(name: &str, value: f64) -> Self {
        Self { name: name.into(), value: Some(value), text: format!("{name}{}", shown(value)) }
    }

    /// A text without value.
    pub(super) fn text(text: &str) -> Self {
        Self { name: text.into(), value: None, text: text.to_owned() }
    }

    pub(super) fn is(&self, name: &str) -> bool {
        *self.name == *name
    }

    /// A feed, or FMAX.
    pub(super) fn is_rate(&self) -> bool {
        self.is("F") && self.value.is_some() || self.is("FMAX")
    }
}

/// A number in the form of words; digits after the ninth were not programmed.
pub(super) fn shown(value: f64) -> String {
    let tidy = if value.abs() < 1e6 { (value * 1e9).round() / 1e9 } else { value };
    format!("{}", tidy + 0.0)
}

/// Reads all remaining words.
pub(super) fn words(cursor: &mut Cursor<'_>) -> Vec<Word> {
    let mut out = Vec::new();
    while !cursor.is_over() {
        out.push(word(cursor));
    }
    out
}

/// A shared name. Names of one letter, which most words have, are allocated once.
fn shared(name: &str) -> Arc<str> {
    static LETTERS: LazyLock<[Arc<str>; 26]> =
        LazyLock::new(|| std::array::from_fn(|at| char::from(b'A' + at as u8).to_string().into()));
    match name.as_bytes() {
        [letter] => LETTERS.get(usize::from(letter.wrapping_sub(b'A'))).map_or_else(|| name.into(), Arc::clone),
        _ => name.into(),
    }
}

fn plain(text: &str) -> Word {
    Word { name: text.into(), operand: Operand::None }
}

fn word(cursor: &mut Cursor<'_>) -> Word {
    if cursor.peek() == Some(b'"') {
        return plain(&format!("\"{}\"", cursor.quoted().unwrap_or_default()));
    }
    if let Some(name) = parameter(cursor) {
        if cursor.take(b'=') {
            return Word { name: format!("{name}=").into(), operand: operand(cursor, true) };
        }
        return Word { name: "".into(), operand: Operand::Parameter { negative: false, name } };
    }
    let mut ahead = cursor.clone();
    let letters = ahead.letters();
    if letters.is_empty() {
        // A sign of its own, a number without a name, anything else.
        if let Some((text, value)) = cursor.number() {
            return Word { name: "".into(), operand: Operand::Number(Arc::from(&*text), value) };
        }
        let first = cursor.bump().map(String::from).unwrap_or_default();
        return Word { operand: operand(cursor, false), name: first.into() };
    }
    // The parameter that is directly after a name.
    for ending in ["QL", "QR", "QS", "Q"] {
        let Some(name) = letters.strip_suffix(ending).filter(|name| !name.is_empty()) else { continue };
        if ahead.next_byte().is_some_and(|byte| byte.is_ascii_digit()) {
            cursor.take_text(name);
            return Word { name: name.into(), operand: operand(cursor, false) };
        }
    }
    *cursor = ahead;
    let mut name = Cow::Borrowed(letters);
    // `DR2+0`: the digit belongs to the name where a value follows it.
    if name == "DR" && cursor.rest().starts_with('2') {
        let mut behind = cursor.clone();
        behind.bump();
        if matches!(behind.next_byte(), Some(b'+' | b'-' | b'Q')) {
            *cursor = behind;
            name.to_mut().push('2');
        }
    }
    if cursor.take(b'=') {
        name.to_mut().push('=');
    }
    if name == "F" {
        for (key, feed) in [("MAX", "FMAX"), ("AUTO", "FAUTO")] {
            if cursor.keyword(key) {
                return plain(feed);
            }
        }
    }
    Word { operand: operand(cursor, true), name: shared(&name) }
}

/// The text after a name; blanks may precede a number.
fn operand(cursor: &mut Cursor<'_>, blanks: bool) -> Operand {
    if !blanks && cursor.next_byte().is_some_and(|byte| byte == b' ') {
        return Operand::None;
    }
    let mut ahead = cursor.clone();
    let sign = match ahead.peek() {
        Some(byte @ (b'+' | b'-')) => {
            ahead.bump();
            Some(char::from(byte))
        }
        _ => None,
    };
    if let Some(name) = parameter(&mut ahead) {
        let mut behind = ahead.clone();
        // A parameter with an equal sign begins the next word.
        if !behind.take(b'=') {
            *cursor = ahead;
            return Operand::Parameter { negative: sign == Some('-'), name };
        }
    } else if let Some((text, value)) = ahead.number() {
        *cursor = ahead;
        let text: Arc<str> = match sign {
            None => Arc::from(&*text),
            Some(sign) => [sign.encode_utf8(&mut [0; 4]), &*text].concat().into(),
        };
        return Operand::Number(text, if sign == Some('-') { -value } else { value });
    }
    match sign {
        Some(sign) => {
            cursor.take(sign as u8);
            Operand::Sign(sign)
        }
        None => Operand::None,
    }
}

impl Evaluator<'_> {
    /// The words with their values.
    pub(super) fn seen(&mut self, words: &[Word]) -> Result<Vec<Seen>, Halt> {
        words.iter().map(|word| self.seen_word(word)).collect()
    }

    fn seen_word(&mut self, word: &Word) -> Result<Seen, Halt> {
        let name = Arc::clone(&word.name);
        let (value, text) = match &word.operand {
            Operand::None => (None, name.to_string()),
            Operand::Number(text, value) => (Some(*value), [&*name, text].concat()),
            Operand::Sign(sign) => (None, [&*name, sign.encode_utf8(&mut [0; 4])].concat()),
            Operand::Parameter { negative, name: parameter } => match self.value_or_kept(*parameter)? {
                Some(Value::Number(value)) => {
                    let value = if *negative { -value } else { value };
                    (Some(value), format!("{name}{}", shown(value)))
                }
                Some(Value::Text(text)) => (None, format!("{name}{text}")),
                None => (None, format!("{name}{parameter}")),
            },
        };
        Ok(Seen { name, value, text })
    }
}

/// The words of a block, one blank between them.
pub(super) fn joined(head: &str, words: &[Seen]) -> String {
    let mut out = String::with_capacity(head.len() + words.iter().map(|word| word.text.len() + 1).sum::<usize>());
    out.push_str(head);
    for word in words {
        if !out.is_empty() {
            out.push(' ');
        }
        out.push_str(&word.text);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<String> {
        words(&mut Cursor::new(text)).iter().map(|word| format!("{}|{:?}", word.name, word.operand)).collect()
    }

    #[test]
    fn words_are_names_with_what_stands_behind_them() {
        let q = |negative, index| {
            let name = Name { kind: super::super::formula::Kind::Q, index };
            format!("{:?}", Operand::Parameter { negative, name })
        };
        assert_eq!(read("X+10 IY-.5"), ["X|Number(\"+10\", 10.0)", "IY|Number(\"-.5\", -0.5)"]);
        assert_eq!(
            read("XQ1 Y-Q2 DR+ RL"),
            [format!("X|{}", q(false, 1)), format!("Y|{}", q(true, 2)), "DR|Sign('+')".into(), "RL|None".into()]
        );
        assert_eq!(read("F MAX FMAX F AUTO"), ["FMAX|None", "FMAX|None", "FAUTO|None"]);
        assert_eq!(read("Q200=+2 Q201=-20"), ["Q200=|Number(\"+2\", 2.0)", "Q201=|Number(\"-20\", -20.0)"]);
        assert_eq!(read("SET UP2"), ["SET|None", "UP|Number(\"2\", 2.0)"]);
    }

    #[test]
    fn numbers_are_tidy() {
        assert_eq!(shown(0.1 + 0.2), "0.3");
        assert_eq!(shown(-0.0), "0");
        assert_eq!(shown(12.0), "12");
    }
}
