//! A block in the form in which it is read once.
//!
//! Facts: LinuxCNC documentation, "Format of a line", "O codes". *Invariant:* items are in the order of the text; a
//! block with an O code has no other items.

use super::expr::{ParameterName, Rs274Expr, Rs274ExpressionReader, name, parameter_name};
use super::text::{BlockText, Rs274Cursor, Rs274Mistake};
use counterpoint_control_api::words::Span;

/// A block.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Rs274Line {
    /// The block begins with a slash.
    pub(super) skip: bool,
    /// Whole part of the sequence number.
    pub(super) number: Option<u32>,
    pub(super) items: Vec<Rs274Item>,
    pub(super) flow: Option<OCode>,
    /// Place of the text within the last comment.
    pub(super) comment: Option<Span>,
    /// A line for the sender of the program, such as `$H`.
    pub(super) for_sender: bool,
    /// Only a percent sign: the start or the end of the text.
    pub(super) percent: bool,
}

/// Part of a block.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rs274Item {
    Word(Rs274Word),
    Set(ParameterName, Rs274Expr),
}

/// A letter with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rs274Word {
    /// Lower-case letter, or `$`, `@`, `^`.
    pub(super) letter: u8,
    pub(super) value: Rs274Expr,
    /// The number as the program writes it, if it is one.
    pub(super) spelled: Option<Box<str>>,
    pub(super) span: Span,
}

/// An O code: its label, its word, and values in brackets.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OCode {
    pub(super) label: OLabel,
    pub(super) word: OWord,
    pub(super) values: Vec<Rs274Expr>,
}

/// The label of an O code.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum OLabel {
    /// A number or a name.
    Text(Box<str>),
    Computed(Rs274Expr),
}

/// The word of an O code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OWord {
    Sub,
    EndSub,
    Call,
    Return,
    If,
    ElseIf,
    Else,
    EndIf,
    Do,
    While,
    EndWhile,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// No word: the start of a program that M98 calls.
    Program,
}

/// Words of O codes; a word comes before each shorter word that it begins with.
const WORDS: &[(&str, OWord)] = &[
    ("endsub", OWord::EndSub),
    ("sub", OWord::Sub),
    ("call", OWord::Call),
    ("return", OWord::Return),
    ("if", OWord::If),
    ("elseif", OWord::ElseIf),
    ("else", OWord::Else),
    ("endif", OWord::EndIf),
    ("do", OWord::Do),
    ("endwhile", OWord::EndWhile),
    ("while", OWord::While),
    ("endrepeat", OWord::EndRepeat),
    ("repeat", OWord::Repeat),
    ("break", OWord::Break),
    ("continue", OWord::Continue),
];

/// Largest number of arguments of a call.
const ARGUMENTS: usize = 30;

/// Reads a block; `language` is false for a control without parameters and O codes.
pub(super) fn read(text: &[u8], language: bool) -> Result<Rs274Line, Rs274Mistake> {
    if matches!(text.trim_ascii_start().first(), Some(b'$' | b'?' | b'!' | b'~')) {
        return Ok(Rs274Line { for_sender: true, ..Rs274Line::default() });
    }
    if text.trim_ascii() == b"%" {
        return Ok(Rs274Line { percent: true, ..Rs274Line::default() });
    }
    let text = BlockText::read(text)?;
    let mut cursor = Rs274Cursor::new(&text);
    let mut line = Rs274Line { comment: text.comment, ..Rs274Line::default() };
    // GRBL accepts N anywhere in the block, and checks N like the other words.
    line.skip = if language { head(&mut cursor, &mut line.number)? } else { cursor.takes("/") };
    if cursor.here() == Some(b'o') && language {
        line.flow = Some(o_code(&mut cursor)?);
        return if cursor.here().is_none() { Ok(line) } else { Err(cursor.expected("nothing after an O code")) };
    }
    while let Some(letter) = cursor.here() {
        let start = cursor.at;
        match letter {
            b'#' if language => {
                cursor.at += 1;
                let target = parameter_name(&mut cursor)?;
                cursor.expect("=")?;
                line.items.push(Rs274Item::Set(target, value(&mut cursor)?));
            }
            b'a'..=b'z' | b'$' | b'@' | b'^' => {
                cursor.at += 1;
                let first = cursor.at;
                let value = if language { value(&mut cursor)? } else { number(&mut cursor)? };
                let spelled = text.bytes.get(first..cursor.at).and_then(|text| std::str::from_utf8(text).ok());
                let spelled = spelled.filter(|text| text.parse::<f64>().is_ok()).map(Box::from);
                let span = text.span(start, cursor.at);
                if letter == b'n' && !language {
                    line.number = spelled.as_deref().and_then(sequence_number);
                }
                line.items.push(Rs274Item::Word(Rs274Word { letter, value, spelled, span }));
            }
            _ => return Err(cursor.expected("a letter")),
        }
    }
    Ok(line)
}

/// Takes the slash and the sequence number. Returns whether there is a slash.
pub(super) fn head(cursor: &mut Rs274Cursor<'_>, number: &mut Option<u32>) -> Result<bool, Rs274Mistake> {
    let skip = cursor.takes("/");
    if cursor.here() == Some(b'n') {
        cursor.at += 1;
        match cursor.number() {
            Some(value) => *number = sequence(value),
            None => return Err(cursor.expected("the number of the block")),
        }
    }
    Ok(skip)
}

/// The whole part of a sequence number.
fn sequence(value: f64) -> Option<u32> {
    (0.0..=99_999_999.0).contains(&value).then_some(value as u32)
}

fn sequence_number(spelled: &str) -> Option<u32> {
    spelled.parse().ok().and_then(sequence)
}

fn value(cursor: &mut Rs274Cursor<'_>) -> Result<Rs274Expr, Rs274Mistake> {
    Rs274ExpressionReader::new(cursor).value()
}

/// A number with a sign, on a control without expressions.
fn number(cursor: &mut Rs274Cursor<'_>) -> Result<Rs274Expr, Rs274Mistake> {
    let negative = cursor.takes("-");
    if !negative {
        cursor.takes("+");
    }
    match cursor.number() {
        Some(value) => Ok(Rs274Expr::constant(if negative { -value } else { value })),
        None => Err(Rs274Mistake { error: 2, ..cursor.expected("a number") }),
    }
}

/// The label of an O code, after its letter.
pub(super) fn label(cursor: &mut Rs274Cursor<'_>) -> Result<OLabel, Rs274Mistake> {
    Ok(match cursor.here() {
        Some(b'<') => OLabel::Text(name(cursor)?),
        Some(b'[') => OLabel::Computed(Rs274ExpressionReader::new(cursor).bracketed()?),
        Some(b'#') => OLabel::Computed(value(cursor)?),
        _ => match cursor.run(|byte| byte.is_ascii_digit()) {
            "" => return Err(cursor.expected("the number or the name of an O code")),
            digits => OLabel::Text(numbered(digits)),
        },
    })
}

/// A number as a label, without leading zeros.
pub(super) fn numbered(digits: &str) -> Box<str> {
    let digits = digits.trim_start_matches('0');
    if digits.is_empty() { "0".into() } else { digits.into() }
}

/// The word of an O code.
pub(super) fn o_word(cursor: &mut Rs274Cursor<'_>) -> Result<OWord, Rs274Mistake> {
    if cursor.here().is_none() {
        return Ok(OWord::Program);
    }
    let found = WORDS.iter().find(|(word, _)| cursor.takes(word));
    found.map(|(_, word)| *word).ok_or_else(|| cursor.expected("a word of an O code (sub, call, if, while, ...)"))
}

fn o_code(cursor: &mut Rs274Cursor<'_>) -> Result<OCode, Rs274Mistake> {
    cursor.expect("o")?;
    let label = label(cursor)?;
    let word = o_word(cursor)?;
    let mut values = Vec::new();
    while cursor.here() == Some(b'[') {
        values.push(Rs274ExpressionReader::new(cursor).bracketed()?);
    }
    let (least, most) = match word {
        OWord::If | OWord::ElseIf | OWord::While | OWord::Repeat => (1, 1),
        OWord::Call => (0, ARGUMENTS),
        OWord::EndSub | OWord::Return => (0, 1),
        _ => (0, 0),
    };
    if values.len() < least {
        return Err(cursor.expected("a value in brackets"));
    }
    if values.len() > most {
        let text = format!("the O code has {} values, at most {most} are possible", values.len());
        return Err(Rs274Mistake::syntax(text));
    }
    Ok(OCode { label, word, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_settings_and_o_codes() {
        let line = read(b"/N5 #1=2 G1 X[#1+1] Y-.5", true).unwrap();
        assert_eq!((line.skip, line.number, line.items.len()), (true, Some(5), 4));
        let spelled = |item: &Rs274Item| match item {
            Rs274Item::Word(word) => (char::from(word.letter), word.spelled.as_deref().map(str::to_owned)),
            Rs274Item::Set(..) => ('#', None),
        };
        let words: Vec<_> = line.items.iter().map(spelled).collect();
        let expected = [('#', None), ('g', Some("1")), ('x', None), ('y', Some("-.5"))];
        assert_eq!(words, expected.map(|(letter, text)| (letter, text.map(str::to_owned))));
        for (text, word, values) in [
            ("o100 sub", OWord::Sub, 0),
            ("O<a b> call [1] [2]", OWord::Call, 2),
            ("o[#1] call", OWord::Call, 0),
            ("o1 elseif [1]", OWord::ElseIf, 1),
            ("o007 (title)", OWord::Program, 0),
        ] {
            let code = read(text.as_bytes(), true).unwrap().flow.unwrap();
            assert_eq!((code.word, code.values.len()), (word, values), "{text}");
        }
        for wrong in ["o1 if", "o1 else [1]", "o1 jump", "o1 sub x1", "x", "g1 x+-", "#1", "1"] {
            assert!(read(wrong.as_bytes(), true).is_err(), "{wrong}");
        }
        assert!(read(b"g1 x[1]", false).is_err() && read(b"g1 x-1.5", false).is_ok());
    }
}
