//! Format texts as pieces.
//!
//! *Invariant:* a code that is not understood is an error at parse time, never silently literal.

use super::number::{Numeric, Point, Style, Zeros};
use crate::diag::Number;
use crate::fault::{Fault, Outcome};

/// A register named by a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// By index 1 to 99.
    Index(u8),
    /// By letter.
    Letter(char),
}

/// One code of a format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Code {
    /// Number or time.
    Number(Numeric),
    /// `An`
    Text {
        /// Width, 0 = as it is.
        width: usize,
        /// In lower case.
        lower: bool,
    },
    /// `Mn`
    Minor {
        /// Width, 0 = as it is.
        width: usize,
        /// In lower case.
        lower: bool,
    },
    /// `Rn`
    Record {
        /// Width, 0 = as it is.
        width: usize,
        /// In lower case.
        lower: bool,
    },
    /// `Ln`
    Logical {
        /// Width, 0 = as it is.
        width: usize,
        /// In lower case.
        lower: bool,
    },
    /// `Tn`, `tn`
    Column {
        /// Column, 1-based.
        column: usize,
        /// `t`: may go back.
        back: bool,
    },
    /// `Xn` of an input format.
    Skip(usize),
    /// `*`
    Any,
    /// `@n`, `#n`, `@t`, `#t`
    Register {
        /// Which one.
        register: Register,
        /// With prefix and suffix.
        word: bool,
        /// Value from the arguments, otherwise the current one.
        argument: bool,
    },
    /// `^`
    Character,
}

/// A piece of a format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Characters as they are.
    Literal(String),
    /// A code.
    Code(Code),
}

/// A parsed format.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Format {
    /// Pieces in order.
    pub pieces: Vec<Piece>,
    /// Number of arguments.
    pub arguments: usize,
}

/// Largest width and column.
const WIDEST: usize = 999;

const LETTERS: &str = "ABCDEFHNSTXYZ";

impl Format {
    /// Parses an output format.
    ///
    /// # Errors
    /// A code that does not exist.
    pub fn output(text: &str) -> Outcome<Format> {
        parse(text, false)
    }

    /// Parses an input format, where `Xn` skips characters.
    ///
    /// # Errors
    /// A code that does not exist.
    pub fn input(text: &str) -> Outcome<Format> {
        parse(text, true)
    }

    /// Bytes that it takes, about.
    pub(crate) fn size(&self) -> usize {
        let literal = |piece: &Piece| if let Piece::Literal(text) = piece { text.len() } else { 0 };
        self.pieces.iter().map(|piece| literal(piece) + 64).sum()
    }

    fn literal(&mut self, character: char) {
        if let Some(Piece::Literal(text)) = self.pieces.last_mut() {
            text.push(character);
        } else {
            self.pieces.push(Piece::Literal(character.to_string()));
        }
    }

    fn code(&mut self, code: Code) {
        let none = matches!(code, Code::Column { .. } | Code::Skip(_) | Code::Register { argument: false, .. });
        self.arguments += usize::from(!none);
        self.pieces.push(Piece::Code(code));
    }
}

fn parse(text: &str, input: bool) -> Outcome<Format> {
    let mut format = Format::default();
    let mut rest = text;
    while let Some(character) = rest.chars().next() {
        let after = rest.get(character.len_utf8()..).unwrap_or("");
        let next = after.chars().next();
        match (character, next) {
            ('!', Some('!')) | ('^', Some('^')) => {
                format.literal(character);
                rest = after.get(1..).unwrap_or("");
                continue;
            }
            ('!', Some('(')) => {
                let Some(end) = after.find(')') else {
                    return Err(Fault::new(Number::BAD_FORMAT, "a `!(` of this format is not closed"));
                };
                let inner = after.get(1..end).unwrap_or("");
                format.code(code(inner, input)?);
                rest = after.get(end + 1..).unwrap_or("");
                continue;
            }
            ('!', Some(sign @ ('@' | '#'))) => {
                let letter = after.chars().nth(1).map(|c| c.to_ascii_uppercase()).filter(|c| LETTERS.contains(*c));
                let Some(letter) = letter else {
                    let message = format!("`!{sign}` is followed by one of the letters {LETTERS}");
                    return Err(Fault::new(Number::BAD_FORMAT, message));
                };
                format.code(Code::Register { register: Register::Letter(letter), word: sign == '@', argument: false });
                rest = after.get(2..).unwrap_or("");
                continue;
            }
            ('^', _) => format.code(Code::Character),
            _ => format.literal(character),
        }
        rest = after;
    }
    Ok(format)
}

fn bad(inner: &str) -> Fault {
    Fault::new(Number::BAD_FORMAT, format!("`!({inner})` is not a format code"))
}

fn code(inner: &str, input: bool) -> Outcome<Code> {
    let squeezed: String = inner.chars().filter(|c| !c.is_whitespace()).collect();
    let mut characters = squeezed.chars();
    let first = characters.next().ok_or_else(|| bad(inner))?;
    let rest = characters.as_str();
    let lower = first.is_ascii_lowercase();
    let width = || number(rest).filter(|width| *width <= WIDEST).ok_or_else(|| bad(inner));
    Ok(match first {
        '*' if rest.is_empty() => Code::Any,
        'A' | 'a' => Code::Text { width: width()?, lower },
        'M' | 'm' => Code::Minor { width: width()?, lower },
        'R' | 'r' => Code::Record { width: width()?, lower },
        'L' | 'l' => Code::Logical { width: width()?, lower },
        'T' | 't' => Code::Column { column: width()?.max(1), back: lower },
        'X' | 'x' if input => Code::Skip(width()?.max(1)),
        '@' | '#' => {
            let register = match (number(rest), rest.chars().next()) {
                (Some(index @ 1..=99), _) => Register::Index(u8::try_from(index).unwrap_or(0)),
                (None, Some(letter)) if rest.len() == 1 && LETTERS.contains(letter.to_ascii_uppercase()) => {
                    Register::Letter(letter.to_ascii_uppercase())
                }
                _ => return Err(bad(inner)),
            };
            Code::Register { register, word: first == '@', argument: true }
        }
        _ => Code::Number(numeric(&squeezed).ok_or_else(|| bad(inner))?),
    })
}

/// Whole number, 0 for an empty text.
fn number(text: &str) -> Option<usize> {
    if text.is_empty() {
        return Some(0);
    }
    if text.bytes().all(|byte| byte.is_ascii_digit()) { text.parse().ok() } else { None }
}

/// Reads `[V|F|X][+][s|e]d[:[s|e]2][:[s|e]2][.|f][d][s|e]`.
fn numeric(text: &str) -> Option<Numeric> {
    let mut characters = text.chars().map(|c| c.to_ascii_lowercase()).peekable();
    let style = match characters.peek()? {
        'v' => Style::Variable,
        'f' => Style::Fixed,
        'x' => Style::Signed,
        _ => Style::Variable,
    };
    characters.next_if(|c| matches!(c, 'v' | 'f' | 'x'));
    let plus = characters.next_if_eq(&'+').is_some();
    let lead = zeros(&mut characters);
    let digit = |c: Option<char>| c.and_then(|c| c.to_digit(10)).and_then(|d| u8::try_from(d).ok());
    let whole = digit(characters.next_if(char::is_ascii_digit));
    let mut groups = Vec::new();
    while characters.next_if_eq(&':').is_some() {
        groups.push(zeros(&mut characters));
        characters.next_if_eq(&'2')?;
    }
    let point = match characters.next_if(|c| matches!(c, '.' | 'f')) {
        Some('.') => Point::Always,
        Some(_) => Point::WithFraction,
        None => Point::Implied,
    };
    let fraction = digit(characters.next_if(char::is_ascii_digit));
    let trail = zeros(&mut characters);
    if characters.next().is_some() || groups.len() > 2 || (whole.is_none() && fraction.is_none()) {
        return None;
    }
    Some(Numeric {
        style,
        plus,
        lead,
        whole: whole.unwrap_or(0),
        groups,
        point,
        fraction: fraction.unwrap_or(0),
        trail,
    })
}

/// Takes `s` or `e` if it comes next.
fn zeros(characters: &mut std::iter::Peekable<impl Iterator<Item = char>>) -> Zeros {
    match characters.next_if(|c| matches!(c, 's' | 'e')) {
        Some('s') => Zeros::Dropped,
        Some(_) => Zeros::KeepOne,
        None => Zeros::Shown,
    }
}
