//! The numeric algorithm: digits, zeros, points, signs, times.
//!
//! *Invariant:* the value is rounded once, half away from zero, on its exact decimal expansion. Facts: reference
//! macro-language.md 5, numeric algorithm.

use std::fmt::Write as _;

/// How suppressed zeros and the sign use the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnStyle {
    /// `V`: no blanks.
    Variable,
    /// `F`: blanks for suppressed zeros, the sign inside the columns of the whole digits.
    Fixed,
    /// `X`: like `F`, but the sign has the first column for itself.
    Signed,
}

/// The treatment of zeros at the outer end of a group of digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroStyle {
    /// All are shown.
    Shown,
    /// `s`: none is shown.
    Dropped,
    /// `e`: one digit stays.
    KeepOne,
}

/// The decimal point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointStyle {
    /// Not written.
    Implied,
    /// `.`
    Always,
    /// `f`: only with a fraction.
    WithFraction,
}

/// A numeric or time format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Numeric {
    /// Use of columns.
    pub style: ColumnStyle,
    /// Plus is written.
    pub plus: bool,
    /// Leading zeros.
    pub lead: ZeroStyle,
    /// Whole digits.
    pub whole: u8,
    /// Time groups of two digits after colons; none for a number.
    pub groups: Vec<ZeroStyle>,
    /// Decimal point.
    pub point: PointStyle,
    /// Fraction digits.
    pub fraction: u8,
    /// Trailing zeros.
    pub trail: ZeroStyle,
}

impl Numeric {
    /// `s9f9s`
    pub const WILDCARD: Numeric = Numeric {
        style: ColumnStyle::Variable,
        plus: false,
        lead: ZeroStyle::Dropped,
        whole: 9,
        groups: Vec::new(),
        point: PointStyle::WithFraction,
        fraction: 9,
        trail: ZeroStyle::Dropped,
    };

    /// Appends `value`; seconds for a time format.
    pub fn write(&self, out: &mut String, value: f64) {
        if !value.is_finite() {
            let _ = write!(out, "{value}");
            return;
        }
        let mut buffer = DecimalDigits::default();
        buffer.round(value.abs(), usize::from(self.fraction));
        let negative = value < 0.0 && !buffer.is_zero();
        let mut whole = String::with_capacity(24);
        if self.groups.is_empty() {
            self.number_whole(&mut whole, &buffer)
        } else {
            self.time(&mut whole, &buffer)
        }
        let (fraction, blanks) = self.fraction_part(&buffer);
        let point = match self.point {
            PointStyle::Always => ".",
            PointStyle::WithFraction if !fraction.trim_end().is_empty() => ".",
            _ => "",
        };
        if whole.trim_start().is_empty() && fraction.is_empty() {
            whole.pop();
            whole.push('0');
        }
        self.sign(&mut whole, negative);
        out.push_str(&whole);
        out.push_str(point);
        out.push_str(fraction);
        if self.style != ColumnStyle::Variable {
            let missing = blanks + usize::from(self.point == PointStyle::WithFraction && point.is_empty());
            out.extend(std::iter::repeat_n(' ', missing));
        }
    }

    fn number_whole(&self, out: &mut String, digits: &DecimalDigits) {
        self.group(out, digits.whole(), usize::from(self.whole), self.lead);
    }

    /// Appends one group of whole digits.
    fn group(&self, out: &mut String, digits: &str, width: usize, zeros: ZeroStyle) {
        let significant = digits.trim_start_matches('0');
        let keep = match zeros {
            ZeroStyle::Shown => width,
            ZeroStyle::KeepOne => 1,
            ZeroStyle::Dropped => 0,
        };
        let zeros = keep.saturating_sub(significant.len());
        let blanks = width.saturating_sub(significant.len() + zeros);
        if self.style != ColumnStyle::Variable {
            out.extend(std::iter::repeat_n(' ', blanks));
        }
        out.extend(std::iter::repeat_n('0', zeros));
        out.push_str(significant);
    }

    fn time(&self, out: &mut String, digits: &DecimalDigits) {
        let total: u64 = digits.whole().parse().unwrap_or(u64::MAX);
        let count = u32::try_from(self.groups.len()).unwrap_or(0);
        let top = total / 60u64.pow(count);
        self.group(out, &top.to_string(), usize::from(self.whole), self.lead);
        for (rest, zeros) in (0..count).rev().zip(&self.groups) {
            let part = format!("{:02}", total / 60u64.pow(rest) % 60);
            let nothing = out.trim_start().is_empty();
            if *zeros == ZeroStyle::Shown || !nothing {
                out.push(':');
                out.push_str(&part);
            } else {
                if self.style != ColumnStyle::Variable {
                    out.push(' ');
                }
                self.group(out, &part, 2, *zeros);
            }
        }
    }

    /// Fraction digits to show and the number of suppressed ones.
    fn fraction_part<'a>(&self, digits: &'a DecimalDigits) -> (&'a str, usize) {
        let all = digits.fraction();
        let shown = all.trim_end_matches('0');
        if self.point == PointStyle::WithFraction && shown.is_empty() {
            return ("", all.len());
        }
        let length = match self.trail {
            ZeroStyle::Shown => all.len(),
            ZeroStyle::Dropped => shown.len(),
            ZeroStyle::KeepOne => shown.len().max(1).min(all.len()),
        };
        (all.get(..length).unwrap_or(all), all.len() - length)
    }

    fn sign(&self, whole: &mut String, negative: bool) {
        let sign = match (negative, self.plus) {
            (true, _) => '-',
            (false, true) => '+',
            (false, false) => {
                if self.style == ColumnStyle::Signed {
                    whole.insert(0, ' ');
                }
                return;
            }
        };
        let blanks = whole.len() - whole.trim_start_matches(' ').len();
        match self.style {
            ColumnStyle::Variable | ColumnStyle::Signed => whole.insert(0, sign),
            ColumnStyle::Fixed if blanks > 0 => {
                whole.remove(0);
                whole.insert(blanks - 1, sign);
            }
            ColumnStyle::Fixed => {
                if self.lead == ZeroStyle::Shown && whole.starts_with('0') && whole.len() > 1 {
                    whole.remove(0);
                }
                whole.insert(0, sign);
            }
        }
    }
}

/// Decimal digits of a rounded number.
#[derive(Default)]
struct DecimalDigits {
    text: String,
    point: usize,
}

impl DecimalDigits {
    /// Rounds `value` (not negative) half up to `places` fraction digits.
    fn round(&mut self, value: f64, places: usize) {
        const POWERS: [f64; 10] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
        let scaled = value * POWERS.get(places).copied().unwrap_or(f64::MAX);
        let distance = (scaled.fract() - 0.5).abs();
        if scaled < 1e15 && distance > 1e-3 {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let digits = (scaled + 0.5) as u64;
            let _ = write!(self.text, "{digits:0width$}", width = places + 1);
        } else {
            self.exact(value, places);
        }
        self.point = self.text.len() - places;
    }

    fn exact(&mut self, value: f64, places: usize) {
        let _ = write!(self.text, "{value:.precision$}", precision = places + 40);
        let point = self.text.find('.').unwrap_or(self.text.len());
        let up = self.text.as_bytes().get(point + 1 + places).is_some_and(|digit| *digit >= b'5');
        self.text.truncate(point + 1 + places);
        let mut digits: Vec<u8> = self.text.bytes().filter(|byte| *byte != b'.').collect();
        if up {
            let mut carry = true;
            for digit in digits.iter_mut().rev() {
                if *digit == b'9' {
                    *digit = b'0';
                } else {
                    *digit += 1;
                    carry = false;
                    break;
                }
            }
            if carry {
                digits.insert(0, b'1');
            }
        }
        self.text.clear();
        self.text.extend(digits.into_iter().map(char::from));
    }

    fn is_zero(&self) -> bool {
        self.text.bytes().all(|byte| byte == b'0')
    }

    fn whole(&self) -> &str {
        self.text.get(..self.point).unwrap_or("")
    }

    fn fraction(&self) -> &str {
        self.text.get(self.point..).unwrap_or("")
    }
}
