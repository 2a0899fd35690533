//! Printing statements: their output, from the text of a line, and the format of numbers in it.
//!
//! Facts: reference fanuc-variables-and-alarms.md 2.5. Decisions: blanks are not text; a number with more whole digits
//! than its format takes the room it needs.

use super::cursor::{FanucParser, FanucSyntaxError};
use super::expr::{is_vacant, to_step};
use super::statement::PrintItem;
use counterpoint_machine::model::PrintFileFormat;

impl FanucParser<'_> {
    /// `[text#n[cd]…]` with this many digits in each format.
    pub(super) fn items(&mut self, digits: usize) -> Result<Vec<PrintItem>, FanucSyntaxError> {
        if !self.accept(b'[') {
            return Err(self.error("'[' and what to print"));
        }
        let mut items = Vec::new();
        let mut text = String::new();
        loop {
            match self.peek() {
                Some(b']') => {
                    self.at += 1;
                    break;
                }
                Some(b'#') => {
                    items.extend((!text.is_empty()).then(|| PrintItem::Text(std::mem::take(&mut text))));
                    items.push(self.number_item(digits)?);
                }
                Some(b'[') | None => return Err(self.error("text, a variable or ']'")),
                Some(byte) => {
                    self.at += 1;
                    text.push(if byte == b'*' { ' ' } else { char::from(byte) });
                }
            }
        }
        items.extend((!text.is_empty()).then_some(PrintItem::Text(text)));
        Ok(items)
    }

    /// A variable and its format.
    fn number_item(&mut self, digits: usize) -> Result<PrintItem, FanucSyntaxError> {
        let mut ops = Vec::new();
        self.primary(&mut ops)?;
        let value = self.checked(ops)?;
        let mut format = [0_u8; 2];
        if !self.accept(b'[') {
            return Err(self.error("'[' and the digits of the variable"));
        }
        for slot in format.iter_mut().rev().take(digits).rev() {
            match self.peek() {
                Some(digit @ b'0'..=b'9') => *slot = digit - b'0',
                _ => return Err(self.error("a digit of the format")),
            }
            self.at += 1;
        }
        if !self.accept(b']') {
            return Err(self.error("']' after the format"));
        }
        let [whole, fraction] = format;
        Ok(PrintItem::Number(value, whole, fraction))
    }
}

/// A number as DPRNT writes it; vacant is 0.
pub(super) fn decimal(value: f64, whole: u8, fraction: u8, output: &PrintFileFormat) -> String {
    let value = if is_vacant(value) { 0.0 } else { value };
    let value = to_step(value, 10_f64.powi(i32::from(fraction)));
    let digits = format!("{:.1$}", value.abs(), usize::from(fraction));
    let sign = if value < 0.0 { "-" } else { "" };
    if !output.padded {
        return format!("{sign}{digits}");
    }
    let point = if fraction > 0 { usize::from(fraction) + 1 } else { 0 };
    let sign = if sign.is_empty() && output.sign_column { " " } else { sign };
    format!("{sign}{digits:>0$}", usize::from(whole) + point)
}

/// The four bytes of a number as BPRNT writes it, as characters of the same numbers; vacant is 0.
pub(super) fn binary(value: f64, fraction: u8) -> String {
    let value = if is_vacant(value) { 0.0 } else { value };
    let number = (value * 10_f64.powi(i32::from(fraction))).round() as i32;
    number.to_be_bytes().map(char::from).iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_the_control_does() {
        let fanuc =
            PrintFileFormat { file: String::new(), padded: true, sign_column: true, line_end: "", opened: true };
        let short = PrintFileFormat { padded: false, ..fanuc.clone() };
        let haas = PrintFileFormat { sign_column: false, ..fanuc.clone() };
        for (value, whole, fraction, expected) in [
            (-7.0456, 3, 3, ["-  7.046", "-7.046", "-  7.046"]),
            (12.5, 4, 0, ["   13", "13", "  13"]),
            (128.4, 5, 3, ["   128.400", "128.400", "  128.400"]),
            (0.0, 2, 2, ["  0.00", "0.00", " 0.00"]),
            (1234.5, 2, 1, [" 1234.5", "1234.5", "1234.5"]),
            (-0.001, 2, 2, ["  0.00", "0.00", " 0.00"]),
        ] {
            let found = [&fanuc, &short, &haas].map(|output| decimal(value, whole, fraction, output));
            assert_eq!(found, expected, "{value}");
        }
        assert_eq!(binary(12.347, 2), "\0\0\u{4}\u{d3}");
        assert_eq!(binary(-15.0, 2), "\u{ff}\u{ff}\u{fa}\u{24}");
    }
}
