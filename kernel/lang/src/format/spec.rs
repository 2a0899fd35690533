//! Format texts as pieces.
//!
//! *Invariant:* a code that is not understood is an error at parse time, never silently literal.

use super::number::{ColumnStyle, Numeric, PointStyle, ZeroStyle};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};

/// A register named by a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormatRegister {
    /// By index 1 to 99.
    Index(u8),
    /// By letter.
    Letter(char),
}

/// One code of a format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FormatCode {
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
        register: FormatRegister,
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
pub enum FormatPiece {
    /// Characters as they are.
    Literal(String),
    /// A code.
    Code(FormatCode),
}

/// A parsed format.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StringFormat {
    /// Pieces in order.
    pub pieces: Vec<FormatPiece>,
    /// Number of arguments.
    pub arguments: usize,
}

/// Largest width and column.
const WIDEST: usize = 999;

const LETTERS: &str = "ABCDEFHNSTXYZ";

impl StringFormat {
    /// Parses an output format.
    ///
    /// # Errors
    /// A code that does not exist.
    pub fn output(text: &str) -> Outcome<StringFormat> {
        parse(text, false)
    }

    /// Parses an input format, where `Xn` skips characters.
    ///
    /// # Errors
    /// A code that does not exist.
    pub fn input(text: &str) -> Outcome<StringFormat> {
        parse(text, true)
    }

    /// Bytes that it takes, about.
    pub(crate) fn size(&self) -> usize {
        let literal = |piece: &FormatPiece| if let FormatPiece::Literal(text) = piece { text.len() } else { 0 };
        self.pieces.iter().map(|piece| literal(piece) + 64).sum()
    }

    fn literal(&mut self, character: char) {
        if let Some(FormatPiece::Literal(text)) = self.pieces.last_mut() {
            text.push(character);
        } else {
            self.pieces.push(FormatPiece::Literal(character.to_string()));
        }
    }

    fn code(&mut self, code: FormatCode) {
        let none = matches!(
            code,
            FormatCode::Column { .. } | FormatCode::Skip(_) | FormatCode::Register { argument: false, .. }
        );
        self.arguments += usize::from(!none);
        self.pieces.push(FormatPiece::Code(code));
    }
}

fn parse(text: &str, input: bool) -> Outcome<StringFormat> {
    let mut format = StringFormat::default();
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
                    return Err(MacroFault::new(DiagnosticNumber::BAD_FORMAT, "a `!(` of this format is not closed"));
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
                    return Err(MacroFault::new(DiagnosticNumber::BAD_FORMAT, message));
                };
                format.code(FormatCode::Register {
                    register: FormatRegister::Letter(letter),
                    word: sign == '@',
                    argument: false,
                });
                rest = after.get(2..).unwrap_or("");
                continue;
            }
            ('^', _) => format.code(FormatCode::Character),
            _ => format.literal(character),
        }
        rest = after;
    }
    Ok(format)
}

fn bad(inner: &str) -> MacroFault {
    MacroFault::new(DiagnosticNumber::BAD_FORMAT, format!("`!({inner})` is not a format code"))
}

fn code(inner: &str, input: bool) -> Outcome<FormatCode> {
    let squeezed: String = inner.chars().filter(|c| !c.is_whitespace()).collect();
    let mut characters = squeezed.chars();
    let first = characters.next().ok_or_else(|| bad(inner))?;
    let rest = characters.as_str();
    let lower = first.is_ascii_lowercase();
    let width = || number(rest).filter(|width| *width <= WIDEST).ok_or_else(|| bad(inner));
    Ok(match first {
        '*' if rest.is_empty() => FormatCode::Any,
        'A' | 'a' => FormatCode::Text { width: width()?, lower },
        'M' | 'm' => FormatCode::Minor { width: width()?, lower },
        'R' | 'r' => FormatCode::Record { width: width()?, lower },
        'L' | 'l' => FormatCode::Logical { width: width()?, lower },
        'T' | 't' => FormatCode::Column { column: width()?.max(1), back: lower },
        'X' | 'x' if input => FormatCode::Skip(width()?.max(1)),
        '@' | '#' => {
            let register = match (number(rest), rest.chars().next()) {
                (Some(index @ 1..=99), _) => FormatRegister::Index(u8::try_from(index).unwrap_or(0)),
                (None, Some(letter)) if rest.len() == 1 && LETTERS.contains(letter.to_ascii_uppercase()) => {
                    FormatRegister::Letter(letter.to_ascii_uppercase())
                }
                _ => return Err(bad(inner)),
            };
            FormatCode::Register { register, word: first == '@', argument: true }
        }
        _ => FormatCode::Number(numeric(&squeezed).ok_or_else(|| bad(inner))?),
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
        'v' => ColumnStyle::Variable,
        'f' => ColumnStyle::Fixed,
        'x' => ColumnStyle::Signed,
        _ => ColumnStyle::Variable,
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
        Some('.') => PointStyle::Always,
        Some(_) => PointStyle::WithFraction,
        None => PointStyle::Implied,
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
fn zeros(characters: &mut std::iter::Peekable<impl Iterator<Item = char>>) -> ZeroStyle {
    match characters.next_if(|c| matches!(c, 's' | 'e')) {
        Some('s') => ZeroStyle::Dropped,
        Some(_) => ZeroStyle::KeepOne,
        None => ZeroStyle::Shown,
    }
}
