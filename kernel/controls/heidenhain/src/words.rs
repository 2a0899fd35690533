//! Words of a block: names with numbers, parameters or nothing after them.
//!
//! Facts: release notes of the Heidenhain pre-processor (word addresses followed by Q, QL, QR and QS). Invariant: a
//! number keeps its text, and text that is not a word stays unchanged, so that the tables of the machine decide.

use std::borrow::Cow;
use std::sync::{Arc, LazyLock};

use counterpoint_control_api::words::{Span, span};
use counterpoint_fault::Halt;
use counterpoint_machine::number::shortest;

use super::eval::Evaluator;
use super::formula::parameter;
use super::lex::HeidenhainCursor;
use super::q_parameter::{ParameterValue, QParameter};

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
        name: QParameter,
    },
}

/// A word.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeidenhainWord {
    pub(super) name: Arc<str>,
    pub(super) operand: Operand,
    /// Its place in the text of the block; [`MADE`] for a word that the pre-processor makes.
    pub(super) span: Span,
}

impl HeidenhainWord {
    /// A word that the pre-processor makes.
    pub(super) fn made(name: &str, operand: Operand) -> Self {
        Self { name: shared(name), operand, span: MADE }
    }

    /// The word with its place moved forward by `by` bytes.
    pub(super) fn further(&self, by: usize) -> Self {
        let (start, end) = self.span;
        let span = if self.span == MADE { MADE } else { (start + by as u32, end + by as u32) };
        Self { span, ..self.clone() }
    }
}

/// The place of a word that is not in the text of the block.
pub(super) const MADE: Span = (0, 0);

/// The text of a word after its name.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rest {
    Nothing,
    /// As in the block.
    Written(Arc<str>),
    Sign(char),
    /// The value, with only the digits that it needs.
    Value,
}

/// A word with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EvaluatedWord {
    pub(super) name: Arc<str>,
    pub(super) value: Option<f64>,
    pub(super) rest: Rest,
    pub(super) span: Span,
    /// The M function that the unit of a feed needs before it.
    pub(super) function: Option<u16>,
}

impl EvaluatedWord {
    /// A word that the pre-processor makes.
    pub(super) fn made(name: &str, value: f64) -> Self {
        Self { name: shared(name), value: Some(value), rest: Rest::Value, span: MADE, function: None }
    }

    /// A text without value.
    pub(super) fn text(text: &str) -> Self {
        Self { name: shared(text), value: None, rest: Rest::Nothing, span: MADE, function: None }
    }

    /// A direction of rotation.
    pub(super) fn turn(clockwise: bool) -> Self {
        let rest = Rest::Sign(if clockwise { '-' } else { '+' });
        Self { name: shared("DR"), value: None, rest, span: MADE, function: None }
    }

    /// The same value under another name.
    pub(super) fn renamed(&self, name: &str) -> Self {
        Self { name: shared(name), ..self.clone() }
    }

    /// The same word in another block.
    pub(super) fn apart(&self) -> Self {
        Self { span: MADE, ..self.clone() }
    }

    pub(super) fn is(&self, name: &str) -> bool {
        *self.name == *name
    }

    /// Its text, without the function of its unit.
    pub(super) fn own_text(&self) -> Cow<'_, str> {
        match &self.rest {
            Rest::Nothing => Cow::Borrowed(&self.name),
            Rest::Written(rest) if self.name.is_empty() => Cow::Borrowed(rest),
            Rest::Written(rest) => Cow::Owned([&*self.name, rest].concat()),
            Rest::Sign(sign) => Cow::Owned(format!("{}{sign}", self.name)),
            Rest::Value => Cow::Owned(format!("{}{}", self.name, shown(self.value.unwrap_or_default()))),
        }
    }

    /// Whether the word has this text.
    pub(super) fn reads(&self, text: &str) -> bool {
        text.strip_prefix(&*self.name).is_some_and(|behind| match &self.rest {
            Rest::Nothing => behind.is_empty(),
            Rest::Written(rest) => **rest == *behind,
            Rest::Sign(sign) => behind.strip_prefix(*sign) == Some(""),
            Rest::Value => self.value.is_some_and(|value| shown(value) == behind),
        })
    }

    /// R0, which ends the radius compensation, as opposed to a radius.
    pub(super) fn is_off(&self) -> bool {
        self.name.starts_with('R') && self.reads("R0")
    }

    /// Whether the direction of rotation is clockwise; `None` if the word is not a direction.
    pub(super) fn turns(&self) -> Option<bool> {
        match self.rest {
            Rest::Sign(sign) if self.is("DR") => Some(sign == '-'),
            _ => None,
        }
    }

    /// A feed, or FMAX.
    pub(super) fn is_rate(&self) -> bool {
        self.is("F") && self.value.is_some() || self.is("FMAX")
    }
}

/// A number in the form of words; digits after the ninth were not programmed.
pub(super) fn shown(value: f64) -> String {
    shortest(value).to_string()
}

/// Reads all remaining words.
pub(super) fn words(cursor: &mut HeidenhainCursor<'_>) -> Vec<HeidenhainWord> {
    let mut out = Vec::new();
    while !cursor.is_over() {
        let start = cursor.place();
        let word = word(cursor);
        out.push(HeidenhainWord { span: span(start, cursor.place()), ..word });
    }
    out
}

/// Names of words that the pre-processor makes.
const NAMES: [&str; 6] = ["FMAX", "DR", "CC", "CR", "IX", "IY"];

/// A shared name. Names of one letter, which most words have, and a few others are allocated once.
fn shared(name: &str) -> Arc<str> {
    static LETTERS: LazyLock<[Arc<str>; 26]> =
        LazyLock::new(|| std::array::from_fn(|at| char::from(b'A' + at as u8).to_string().into()));
    static OTHERS: LazyLock<[Arc<str>; NAMES.len()]> = LazyLock::new(|| NAMES.map(Arc::from));
    let known = match name.as_bytes() {
        [letter] => LETTERS.get(usize::from(letter.wrapping_sub(b'A'))),
        _ => OTHERS.iter().find(|known| ***known == *name),
    };
    known.map_or_else(|| name.into(), Arc::clone)
}

fn plain(text: &str) -> HeidenhainWord {
    HeidenhainWord::made(text, Operand::None)
}

fn word(cursor: &mut HeidenhainCursor<'_>) -> HeidenhainWord {
    if cursor.peek() == Some(b'"') {
        return plain(&format!("\"{}\"", cursor.quoted().unwrap_or_default()));
    }
    if let Some(name) = parameter(cursor) {
        if cursor.take(b'=') {
            return HeidenhainWord::made(&format!("{name}="), operand(cursor, true));
        }
        return HeidenhainWord::made("", Operand::Parameter { negative: false, name });
    }
    let mut ahead = cursor.clone();
    let letters = ahead.letters();
    if letters.is_empty() {
        // A sign of its own, a number without a name, anything else.
        if let Some((text, value)) = cursor.number() {
            return HeidenhainWord::made("", Operand::Number(Arc::from(&*text), value));
        }
        let first = cursor.bump().map(String::from).unwrap_or_default();
        return HeidenhainWord::made(&first, operand(cursor, false));
    }
    // The parameter that is directly after a name.
    for ending in ["QL", "QR", "QS", "Q"] {
        let Some(name) = letters.strip_suffix(ending).filter(|name| !name.is_empty()) else { continue };
        if ahead.next_byte().is_some_and(|byte| byte.is_ascii_digit()) {
            cursor.take_text(name);
            return HeidenhainWord::made(name, operand(cursor, false));
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
    HeidenhainWord::made(&name, operand(cursor, true))
}

/// The text after a name; blanks may precede a number.
fn operand(cursor: &mut HeidenhainCursor<'_>, blanks: bool) -> Operand {
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
    pub(super) fn seen(&mut self, words: &[HeidenhainWord]) -> Result<Vec<EvaluatedWord>, Halt> {
        words.iter().map(|word| self.seen_word(word)).collect()
    }

    fn seen_word(&mut self, word: &HeidenhainWord) -> Result<EvaluatedWord, Halt> {
        let (value, rest) = match &word.operand {
            Operand::None => (None, Rest::Nothing),
            Operand::Number(text, value) => (Some(*value), Rest::Written(Arc::clone(text))),
            Operand::Sign(sign) => (None, Rest::Sign(*sign)),
            Operand::Parameter { negative, name: parameter } => match self.value_or_kept(*parameter)? {
                Some(ParameterValue::Number(value)) => (Some(if *negative { -value } else { value }), Rest::Value),
                Some(ParameterValue::Text(text)) => (None, Rest::Written(text)),
                None => (None, Rest::Written(parameter.to_string().into())),
            },
        };
        Ok(EvaluatedWord { name: Arc::clone(&word.name), value, rest, span: word.span, function: None })
    }
}

/// A block of the remaining words.
pub(super) type LeftBlock = Vec<EvaluatedWord>;

/// A block of words after a head: a text of the machine, a G code, or nothing.
pub(super) fn headed(head: &str, words: impl IntoIterator<Item = EvaluatedWord>) -> LeftBlock {
    let first = (!head.is_empty()).then(|| match head.strip_prefix('G').and_then(|number| number.parse().ok()) {
        Some(number) => EvaluatedWord::made("G", number),
        None => EvaluatedWord::text(head),
    });
    first.into_iter().chain(words).collect()
}

/// The words of a block as text, one blank between them.
pub(super) fn joined(words: &[EvaluatedWord]) -> String {
    let mut out = String::new();
    for word in words {
        if !out.is_empty() {
            out.push(' ');
        }
        out.push_str(&word.own_text());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<String> {
        words(&mut HeidenhainCursor::new(text)).iter().map(|word| format!("{}|{:?}", word.name, word.operand)).collect()
    }

    #[test]
    fn words_are_names_with_what_stands_behind_them() {
        let q = |negative, index| {
            let name = QParameter { kind: super::super::q_parameter::ParameterKind::Q, index };
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
