//! `#MSG`: texts with values.
//!
//! Facts: ISG programming manual, messages from the program (`#MSG [SYN] [receiver] ["text", values]`, `#MSG INFO`;
//! formats as those of printf). Decisions: a value of %d is truncated to a whole number; a text without values is
//! shown unchanged, except for `%%`; %s needs a text value, which this language does not have. Invariant: each
//! format has its value.

use counterpoint_fault as diag;

use super::cursor::{IsgCursor, IsgSyntaxError};
use super::expr::{Expr, IsgExpressionReader};
use super::{IsgBlockError, Outcome};

/// Most characters of a value.
const WIDEST: usize = 60;

/// Words between `#MSG` and its text: the modes, and the receiver of the message.
const BEFORE: [&str; 8] = ["SYN", "ASYN", "INFO", "SAVE", "HMI", "DIAG", "PLC", "DISK"];

/// Reads the text after `#MSG` and its values; `text` is the block as it was written.
pub(super) fn read(cursor: &mut IsgCursor<'_>, text: &[u8]) -> Result<(String, Vec<Expr>), IsgSyntaxError> {
    while BEFORE.iter().any(|word| cursor.word(word)) {}
    let bracket = cursor.take(b'[');
    if cursor.peek() != Some(b'"') {
        return Err(IsgSyntaxError::expected("a text in quotation marks", cursor.at));
    }
    cursor.at += 1;
    let begin = cursor.at;
    cursor.run(|byte| byte != b'"');
    let message = text.get(begin..cursor.at).unwrap_or_default();
    cursor.expect(b'"', "the end of the text")?;
    let mut values = Vec::new();
    while cursor.take(b',') {
        values.push(IsgExpressionReader::new(cursor).expression()?);
    }
    if bracket {
        cursor.expect(b']', "']'")?;
    }
    Ok((String::from_utf8_lossy(message).into_owned(), values))
}

/// The text with its values.
pub(super) fn filled(text: &str, values: &[f64]) -> Outcome<String> {
    let (mut out, mut left, mut rest) = (String::new(), values.iter(), text.chars().peekable());
    while let Some(one) = rest.next() {
        if one != '%' || values.is_empty() && rest.peek() != Some(&'%') {
            out.push(one);
            continue;
        }
        if rest.next_if_eq(&'%').is_some() {
            out.push('%');
            continue;
        }
        let mut format = ValueFormat::default();
        while let Some(flag) = rest.next_if(|c| matches!(c, '-' | '+' | ' ' | '0')) {
            match flag {
                '-' => format.left = true,
                '0' => format.zeros = true,
                sign => format.sign = Some(sign),
            }
        }
        let mut digits = || {
            let mut number = String::new();
            while let Some(digit) = rest.next_if(char::is_ascii_digit) {
                number.push(digit);
            }
            number
        };
        format.width = digits().parse().unwrap_or(0_usize).min(WIDEST);
        if rest.next_if_eq(&'.').is_some() {
            let mut number = String::new();
            while let Some(digit) = rest.next_if(char::is_ascii_digit) {
                number.push(digit);
            }
            format.places = Some(number.parse().unwrap_or(0_usize).min(WIDEST));
        }
        while rest.next_if(|c| matches!(c, 'l' | 'h' | 'L')).is_some() {}
        let letter = rest.next().unwrap_or(' ');
        let Some(value) = left.next() else {
            return wrong(format!("#MSG has fewer values than formats: write a value for each of them in '{text}'"));
        };
        let Some(piece) = format.piece(letter, *value) else {
            return wrong(format!("#MSG cannot show a number as %{letter}: use %d, %u, %f, %e, %g or %x in '{text}'"));
        };
        out.push_str(&piece);
    }
    if left.next().is_some() {
        return wrong(format!("#MSG has more values than formats: write a format for each of them in '{text}'"));
    }
    Ok(out)
}

fn wrong<T>(text: String) -> Outcome<T> {
    Err(IsgBlockError::Alarm(&diag::MACRO_SYNTAX, text))
}

/// How a value is written.
#[derive(Debug, Clone, Copy, Default)]
struct ValueFormat {
    left: bool,
    zeros: bool,
    sign: Option<char>,
    width: usize,
    places: Option<usize>,
}

impl ValueFormat {
    fn piece(self, letter: char, value: f64) -> Option<String> {
        let size = value.abs();
        let places = self.places.unwrap_or(6);
        let digits = match letter {
            'd' | 'i' | 'u' => format!("{:.0}", size.trunc()),
            'f' | 'F' => format!("{size:.places$}"),
            'e' => exponent(size, places),
            'E' => exponent(size, places).to_uppercase(),
            'g' | 'G' => general(size, places.max(1)),
            'x' => format!("{:x}", value as i64 as u32),
            'X' => format!("{:X}", value as i64 as u32),
            _ => return None,
        };
        let is_negative = match letter {
            'd' | 'i' | 'u' => value.trunc() < 0.0,
            'x' | 'X' => false,
            _ => value < 0.0,
        };
        let sign = if is_negative { "-".to_owned() } else { self.sign.map(String::from).unwrap_or_default() };
        let missing = self.width.saturating_sub(sign.len() + digits.len());
        Some(match (self.left, self.zeros) {
            (true, _) => sign + &digits + &" ".repeat(missing),
            (false, true) => sign + &"0".repeat(missing) + &digits,
            (false, false) => " ".repeat(missing) + &sign + &digits,
        })
    }
}

/// A number with an exponent of two digits at least.
fn exponent(value: f64, places: usize) -> String {
    let text = format!("{value:.places$e}");
    let Some((digits, power)) = text.split_once('e') else { return text };
    let (sign, power) = power.strip_prefix('-').map_or(('+', power), |power| ('-', power));
    format!("{digits}e{sign}{power:0>2}")
}

/// The shorter of both ways, without zeros at the end.
fn general(value: f64, places: usize) -> String {
    let power = if value == 0.0 { 0 } else { libm::floor(libm::log10(value)) as i32 };
    let cut = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if power < -4 || power >= places as i32 {
        let text = exponent(value, places - 1);
        return text.split_once('e').map_or(text.clone(), |(digits, power)| format!("{}e{power}", cut(digits)));
    }
    let decimals = (places as i32 - 1 - power).max(0) as usize;
    cut(&format!("{value:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_those_of_printf() {
        for (text, values, shown) in [
            ("A %d", &[20.0][..], "A 20"),
            ("%d of %d", &[3.0, 7.0], "3 of 7"),
            ("%i|%u", &[-3.9, 7.0], "-3|7"),
            ("%5d|%-5d|%05d|%+d", &[42.0, 42.0, -42.0, 42.0], "   42|42   |-0042|+42"),
            ("%f|%.2f|%8.3f|%-8.1f|", &[1.5, 2.346, -1.0, 2.25], "1.500000|2.35|  -1.000|2.2     |"),
            ("%e|%.1E", &[12345.678, 0.00012], "1.234568e+04|1.2E-04"),
            ("%g|%g|%g", &[0.5, 1234567.0, 100.0], "0.5|1.23457e+06|100"),
            ("%x|%X|%lf", &[255.0, 255.0, 1.0], "ff|FF|1.000000"),
            ("100%% of %d", &[4.0], "100% of 4"),
            ("50% done", &[], "50% done"),
            ("50%% done", &[], "50% done"),
            ("%d|%.1f", &[-0.5, -0.01], "0|-0.0"),
        ] {
            assert_eq!(filled(text, values).ok().as_deref(), Some(shown), "{text}");
        }
        for (text, values) in [("%d %d", &[1.0][..]), ("%d", &[1.0, 2.0]), ("%s", &[1.0]), ("%", &[1.0])] {
            assert!(filled(text, values).is_err(), "{text}");
        }
    }
}
