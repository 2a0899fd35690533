//! Text as values.
//!
//! *Invariant:* reading never fails as a whole; a code without a match gives `$NULL`, which is reported to the caller.

use super::{FormatCode, FormatPiece, Numeric, PointStyle, StringFormat, ZeroStyle};
use crate::ident;
use crate::value::{MacroValue, RecordName};

/// Reads a line by an input format; the flag says that every code and literal was found.
#[must_use]
pub fn read(format: &StringFormat, line: &str) -> (Vec<MacroValue>, bool) {
    let characters: Vec<char> = line.chars().collect();
    let mut reader = FormatReader { line: &characters, at: 0, good: true };
    let mut values = Vec::new();
    for piece in &format.pieces {
        match piece {
            FormatPiece::Literal(text) => text.chars().for_each(|wanted| reader.literal(wanted)),
            FormatPiece::Code(FormatCode::Column { column, back }) => {
                reader.at = if *back { column - 1 } else { reader.at.max(column - 1) }.min(characters.len());
            }
            FormatPiece::Code(FormatCode::Skip(count)) => reader.at = (reader.at + count).min(characters.len()),
            FormatPiece::Code(FormatCode::Register { argument: false, .. }) => reader.good = false,
            FormatPiece::Code(code) => {
                let value = reader.code(code);
                reader.good &= value.is_some();
                values.push(value.unwrap_or(MacroValue::Null));
            }
        }
    }
    (values, reader.good)
}

/// Digits that are looked through for the colon of a time.
const MOST_DIGITS: usize = 64;

struct FormatReader<'a> {
    line: &'a [char],
    at: usize,
    good: bool,
}

impl FormatReader<'_> {
    fn peek(&self) -> Option<char> {
        self.line.get(self.at).copied()
    }

    fn next_if(&mut self, test: impl Fn(char) -> bool) -> Option<char> {
        let character = self.peek().filter(|c| test(*c))?;
        self.at += 1;
        Some(character)
    }

    fn blanks(&mut self) {
        while self.next_if(|c| c == ' ' || c == '\t').is_some() {}
    }

    fn literal(&mut self, wanted: char) {
        if wanted == ' ' || wanted == '\t' {
            self.blanks();
        } else {
            self.good &= self.peek() == Some(wanted);
            self.at = (self.at + 1).min(self.line.len());
        }
    }

    fn digits(&mut self, most: usize) -> String {
        let mut digits = String::new();
        while digits.len() < most
            && let Some(digit) = self.next_if(|c| c.is_ascii_digit())
        {
            digits.push(digit);
        }
        digits
    }

    fn word(&mut self, width: usize) -> String {
        let mut word = String::new();
        if width > 0 {
            word.extend(self.line.iter().skip(self.at).take(width));
            self.at = (self.at + width).min(self.line.len());
            return word.trim().to_ascii_uppercase();
        }
        while let Some(c) = self.next_if(|c| c.is_ascii_alphanumeric() || matches!(c, '#' | ':' | '*' | '_')) {
            word.push(c.to_ascii_uppercase());
        }
        word
    }

    fn code(&mut self, code: &FormatCode) -> Option<MacroValue> {
        match code {
            FormatCode::Number(numeric) => self.number(numeric).map(MacroValue::Real),
            FormatCode::Register { .. } => self.number(&Numeric::WILDCARD).map(MacroValue::Real),
            FormatCode::Text { width, lower } => {
                let width = if *width == 0 { usize::MAX } else { *width };
                let text: String = self.line.iter().skip(self.at).take(width).collect();
                self.at = self.at.saturating_add(width).min(self.line.len());
                Some(MacroValue::text(if *lower { text.to_lowercase() } else { text }))
            }
            FormatCode::Minor { width, .. } => minor(&self.word(*width)),
            FormatCode::Record { width, .. } => major(&self.word(*width)),
            FormatCode::Logical { width, .. } => match self.word(*width).as_str() {
                "TRUE" => Some(MacroValue::Logical(true)),
                "FALSE" => Some(MacroValue::Logical(false)),
                _ => None,
            },
            FormatCode::Character => self.next_if(|_| true).map(|c| MacroValue::Real(f64::from(u32::from(c)))),
            FormatCode::Any => self.any(),
            FormatCode::Column { .. } | FormatCode::Skip(_) => None,
        }
    }

    fn sign(&mut self) -> f64 {
        match self.next_if(|c| c == '-' || c == '+') {
            Some('-') => -1.0,
            _ => 1.0,
        }
    }

    /// A number in the width of its format; a written point overrules an implied one.
    fn number(&mut self, format: &Numeric) -> Option<f64> {
        self.blanks();
        let sign = self.sign();
        let (whole, fraction) = (usize::from(format.whole), usize::from(format.fraction));
        if !format.groups.is_empty() {
            return self.time(sign);
        }
        let implied = format.point == PointStyle::Implied;
        let mut digits = self.digits(if implied { whole + fraction } else { whole.max(1) });
        if self.next_if(|c| c == '.').is_some() {
            digits.push('.');
            digits.push_str(&self.digits(fraction.max(1)));
        } else if implied && fraction > 0 && !digits.is_empty() {
            let at = if format.trail == ZeroStyle::Shown { digits.len().checked_sub(fraction) } else { Some(whole) };
            match at {
                Some(at) if at <= digits.len() => digits.insert(at, '.'),
                Some(_) => {}
                None => digits = format!(".{digits:0>fraction$}"),
            }
        }
        if digits.bytes().any(|byte| byte.is_ascii_digit()) {
            digits.parse::<f64>().ok().map(|n| sign * n)
        } else {
            None
        }
    }

    fn time(&mut self, sign: f64) -> Option<f64> {
        let mut total = 0.0;
        for _ in 0..3 {
            let mut digits = self.digits(15);
            let point = self.next_if(|c| c == '.').is_some();
            if point {
                digits.push('.');
                digits.push_str(&self.digits(15));
            }
            total = total * 60.0 + digits.parse::<f64>().ok()?;
            if point || self.next_if(|c| c == ':').is_none() {
                break;
            }
        }
        Some(sign * total)
    }

    /// The next word by its first character.
    fn any(&mut self) -> Option<MacroValue> {
        self.blanks();
        match self.peek()? {
            '$' => {
                self.at += 1;
                match self.word(0).as_str() {
                    "NULL" => Some(MacroValue::Null),
                    "TRUE" => Some(MacroValue::Logical(true)),
                    "FALSE" => Some(MacroValue::Logical(false)),
                    _ => None,
                }
            }
            '\'' => {
                self.at += 1;
                let mut text = String::new();
                while let Some(c) = self.next_if(|_| true) {
                    if c == '\'' && self.next_if(|c| c == '\'').is_none() {
                        return Some(MacroValue::text(text));
                    }
                    text.push(c);
                }
                None
            }
            '#' => {
                let word = self.word(0);
                if word.contains(':') { major(&word) } else { minor(&word) }
            }
            c if c.is_ascii_alphabetic() => {
                let word = self.word(0);
                minor(&word).or_else(|| major(&word))
            }
            c if c.is_ascii_digit() || matches!(c, '+' | '-' | '.') => self.plain().map(MacroValue::Real),
            _ => None,
        }
    }

    fn plain(&mut self) -> Option<f64> {
        let begin = self.at;
        let sign = self.sign();
        let colon = self.line.iter().skip(self.at).take(MOST_DIGITS).find(|c| !c.is_ascii_digit()) == Some(&':');
        if colon {
            return self.time(sign);
        }
        let mut digits = self.digits(30);
        if self.next_if(|c| c == '.').is_some() {
            digits.push('.');
            digits.push_str(&self.digits(30));
        }
        let number = digits.parse::<f64>().ok().map(|number| sign * number);
        if number.is_none() {
            self.at = begin;
        }
        number
    }
}

fn minor(word: &str) -> Option<MacroValue> {
    match word.strip_prefix('#') {
        Some(code) => code.parse().ok().map(MacroValue::Keyword),
        None => ident::minor_code(word).map(MacroValue::Keyword),
    }
}

fn major(word: &str) -> Option<MacroValue> {
    let part = |text: &str| if text == "*" { Some(-1) } else { text.parse().ok() };
    let record = match word.strip_prefix('#') {
        Some(codes) => match codes.split_once(':') {
            Some((class, subclass)) => RecordName { class: part(class)?, subclass: part(subclass)? },
            None => RecordName { class: ident::MAJOR_CLASS, subclass: part(codes)? },
        },
        None => ident::record(word)?,
    };
    Some(MacroValue::Record(record))
}
