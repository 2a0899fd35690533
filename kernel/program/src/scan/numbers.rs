//! Numbers of words: their digits, and their values in the format of a register.
//!
//! Facts: reference control-emulator.md 1.4 (reading a number). Invariant: a value is the number closest to its digits.

use crate::block::irregular;
use crate::key_words::WrittenNumber;
use counterpoint_machine::rows::{DecimalPointRule, Excess, NumberFormat, ZeroRule};

/// All whole numbers below are exact in `f64`.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// Powers of ten that are exact in `f64`.
const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Powers of ten as whole numbers, for digits that are cut off.
const STEPS: [i64; EXACT_DIGITS + 1] = [
    1,
    10,
    100,
    1_000,
    10_000,
    100_000,
    1_000_000,
    10_000_000,
    100_000_000,
    1_000_000_000,
    10_000_000_000,
    100_000_000_000,
    1_000_000_000_000,
    10_000_000_000_000,
    100_000_000_000_000,
    1_000_000_000_000_000,
];

/// Digits whose value is exact in `i64` and `f64`.
const EXACT_DIGITS: usize = 15;

/// Appends the digits at the start of a text to a number; returns it with the rest of the text.
#[inline(always)]
fn leading_digits(mut number: i64, mut text: &[u8]) -> (i64, &[u8]) {
    while let [byte, rest @ ..] = text {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        number = number.wrapping_mul(10).wrapping_add(i64::from(digit));
        text = rest;
    }
    (number, text)
}

/// Appends four digits in one step, if the text begins with them; returns the number with the rest of the text.
#[inline(always)]
fn four_digits(number: i64, text: &[u8]) -> (i64, &[u8]) {
    const HIGH: u32 = 0xf0f0_f0f0;
    if let Some((four, rest)) = text.split_first_chunk() {
        let bytes = u32::from_le_bytes(*four);
        // The high half of a digit is 3, and stays 3 when 6 is added to it.
        if bytes & HIGH == 0x3030_3030 && bytes.wrapping_add(0x0606_0606) & HIGH == 0x3030_3030 {
            let digits = bytes & 0x0f0f_0f0f;
            let pairs = (digits * 10 + (digits >> 8)) & 0x00ff_00ff;
            let value = (pairs & 0xff) * 100 + (pairs >> 16);
            return (number.wrapping_mul(10_000).wrapping_add(i64::from(value)), rest);
        }
    }
    (number, text)
}

/// The characters of a number: `[+-]digits[.digits]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct NumberDigits<'a> {
    /// All of them after the sign.
    text: &'a [u8],
    negative: bool,
    point: bool,
    /// Digits before the point.
    whole: usize,
    /// Digits after it.
    fraction: usize,
    /// All digits as a whole number, if there are at most [`EXACT_DIGITS`].
    mantissa: i64,
}

/// The digits that begin at `at`, and where they end.
#[inline(always)]
pub(super) fn parse_digits(line: &[u8], at: usize) -> Option<(NumberDigits<'_>, usize)> {
    let rest = line.get(at..)?;
    let (negative, text) = match rest {
        [b'-', text @ ..] => (true, text),
        [b'+', text @ ..] => (false, text),
        text => (false, text),
    };
    let (mantissa, after) = leading_digits(0, text);
    let whole = text.len() - after.len();
    let (mantissa, fraction, point, length) = match after {
        [b'.', decimals @ ..] => {
            // Most numbers in programs of CAM systems have at least four decimals.
            let (mantissa, after) = four_digits(mantissa, decimals);
            let (mantissa, after) = leading_digits(mantissa, after);
            let fraction = decimals.len() - after.len();
            (mantissa, fraction, true, whole + 1 + fraction)
        }
        _ => (mantissa, 0, false, whole),
    };
    if whole + fraction == 0 {
        return None;
    }
    let end = at + (rest.len() - text.len()) + length;
    Some((NumberDigits { text: text.get(..length)?, negative, point, whole, fraction, mantissa }, end))
}

impl NumberDigits<'_> {
    /// The number; its value is the one closest to the digits.
    #[inline(always)]
    pub(super) fn number(self) -> WrittenNumber {
        let magnitude = match POW10.get(self.fraction) {
            // Both sides are exact, so the quotient is correctly rounded.
            Some(power) if self.whole + self.fraction <= EXACT_DIGITS => self.mantissa as f64 / power,
            // Only digits and a point, so they always parse.
            _ => std::str::from_utf8(self.text).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::INFINITY),
        };
        let value = if self.negative { -magnitude } else { magnitude };
        let (digits, fraction) = (self.whole.min(255) as u8, self.fraction.min(255) as u8);
        WrittenNumber { value, point: self.point, digits, fraction }
    }
}

/// Parses `[+-]digits[.digits]` at `at`; correctly rounded.
pub(super) fn parse_number(line: &[u8], at: usize) -> Option<(WrittenNumber, usize)> {
    parse_digits(line, at).map(|(digits, end)| (digits.number(), end))
}

/// How a register's numbers are read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Read {
    format: NumberFormat,
    /// A number without a point has an implied one.
    implied: bool,
    /// Numbers from here on have more whole digits than the format.
    room: f64,
    /// The same without a written point: an implied one leaves room for the fraction too.
    room_without_point: f64,
    /// Digits after the point that count.
    places: usize,
    /// One of the register's units is the whole over this.
    unit: f64,
    /// Digits beyond them round the last one.
    rounds: bool,
    /// Irregularities of a negative value, and of a written point.
    sign: u8,
    pointed: u8,
}

impl Read {
    /// For one of the formats of a register; `sign` and `pointed` are the irregularities of a negative value and of a
    /// written point.
    pub(super) fn new(format: NumberFormat, (sign, pointed): (u8, u8)) -> Self {
        let power = |digits: u8| POW10.get(usize::from(digits)).copied().unwrap_or(f64::INFINITY);
        let implied = format.point == DecimalPointRule::Omit;
        let room = power(format.whole);
        let room_without_point = if implied { power(format.whole.saturating_add(format.frac)) } else { room };
        let places = if format.excess == Excess::Kept { usize::MAX } else { usize::from(format.frac) };
        let (unit, rounds) = (power(format.frac), format.excess == Excess::Rounded);
        Self { format, implied, room, room_without_point, places, unit, rounds, sign, pointed }
    }

    /// Whether the digits of a number do not count, only its value.
    pub(super) fn takes_values(&self) -> bool {
        self.places == usize::MAX && !self.implied
    }

    /// Value of a number, and its irregularities, bit by bit.
    #[inline(always)]
    pub(super) fn value(&self, number: WrittenNumber) -> (f64, u8) {
        let value = if usize::from(number.fraction) > self.places {
            without_excess(number, &self.format)
        } else if number.point || !self.implied {
            number.value
        } else {
            implied(number, &self.format)
        };
        (value, self.irregular(number.value, number.point))
    }

    /// The same for digits.
    #[inline(always)]
    pub(super) fn value_of_digits(&self, digits: NumberDigits<'_>) -> (f64, u8) {
        if digits.fraction > self.places && digits.whole + digits.fraction <= EXACT_DIGITS {
            self.value_without_excess(digits)
        } else {
            self.value(digits.number())
        }
    }

    /// Value of at most [`EXACT_DIGITS`] digits, more of which stand after the point than the register has. They are
    /// cut as a whole number, so that no binary fraction stands just below or above a whole or half unit.
    #[inline(always)]
    fn value_without_excess(&self, digits: NumberDigits<'_>) -> (f64, u8) {
        let step = STEPS.get(digits.fraction - self.places).copied().unwrap_or(1);
        let cut = digits.mantissa / step;
        let units = cut + i64::from(self.rounds && (digits.mantissa - cut * step) * 2 >= step);
        let magnitude = units as f64 / self.unit;
        let too_long = u8::from(cut as f64 >= self.room * self.unit) * irregular::DIGITS;
        let sign = u8::from(digits.negative && digits.mantissa != 0) * self.sign;
        (if digits.negative { -magnitude } else { magnitude }, too_long | sign | self.pointed)
    }

    /// Irregularities of a number as written.
    #[inline(always)]
    fn irregular(&self, value: f64, point: bool) -> u8 {
        let too_long = value.abs() >= if point { self.room } else { self.room_without_point };
        let digits = u8::from(too_long) * irregular::DIGITS;
        let sign = u8::from(value < 0.0) * self.sign;
        digits | sign | (u8::from(point) * self.pointed)
    }
}

/// Value of a number with more digits after the point than its register has.
#[cold]
fn without_excess(number: WrittenNumber, format: &NumberFormat) -> f64 {
    let Some(power) = POW10.get(usize::from(format.frac)) else { return number.value };
    let units = number.value.abs() * power;
    if units >= EXACT {
        return number.value;
    }
    // Half of the last digit written, so that a binary fraction just below or above a whole or half unit is taken for
    // it.
    let written = POW10.get(usize::from(number.fraction.saturating_sub(format.frac)));
    let near = written.map_or(0.0, |written| 0.5 / written).max(units * 4.0 * f64::EPSILON);
    let below = units as u64 as f64;
    let rest = units - below;
    let half = if format.excess == Excess::Rounded { 0.5 } else { 1.0 };
    let units = if rest > half - near { below + 1.0 } else { below };
    (units / power).copysign(number.value)
}

/// Value of a number without a point in a register that implies one (reference control-emulator.md 1.4).
fn implied(number: WrittenNumber, format: &NumberFormat) -> f64 {
    let power = |n: u8| POW10.get(usize::from(n)).copied().unwrap_or(1.0);
    if format.point != DecimalPointRule::Omit || format.frac == 0 {
        number.value
    } else if format.trail == ZeroRule::Omit && format.lead != ZeroRule::Omit {
        // Left-justified into the whole digits.
        if number.digits <= format.whole {
            number.value * power(format.whole - number.digits)
        } else {
            number.value / power(number.digits - format.whole)
        }
    } else {
        number.value / power(format.frac)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_to_the_last_bit() {
        for text in
            ["0", "12", "-3.5", "+.125", "90.1999", "123456.7891", "0.1", "1.", "99999999999999999999.5", ".000001"]
        {
            let (number, end) = parse_number(text.as_bytes(), 0).unwrap();
            assert_eq!(end, text.len());
            assert_eq!(number.value, text.trim_start_matches('+').parse::<f64>().unwrap(), "{text}");
        }
        for text in ["", "-", ".", "+.", "X", "e5"] {
            assert!(parse_number(text.as_bytes(), 0).is_none(), "{text}");
        }
    }

    #[test]
    fn four_digits_are_those_that_one_by_one_gives() {
        let bytes: Vec<u8> = (0x00..=0xff).filter(|byte| byte % 16 < 2 || byte % 16 > 8).collect();
        let texts = bytes.iter().flat_map(|a| bytes.iter().map(move |b| [*a, *b]));
        for [odd, other] in texts {
            for place in 0..4 {
                let mut text = *b"90871";
                text[place] = odd;
                text[(place + 1) % 4] = other;
                let digits = text[..4].iter().all(u8::is_ascii_digit);
                let expected = if digits { leading_digits(12, &text[..4]).0 } else { 12 };
                let (number, rest) = four_digits(12, &text);
                assert_eq!((number, rest.len()), (expected, if digits { 1 } else { 5 }), "{text:?}");
            }
        }
        assert_eq!(four_digits(12, b"908"), (12, &b"908"[..]));
    }

    #[test]
    fn implied_points() {
        let format = |lead, trail| NumberFormat {
            whole: 4,
            frac: 3,
            point: DecimalPointRule::Omit,
            lead,
            trail,
            plus: false,
            excess: Excess::Kept,
        };
        let number = |text: &str| parse_number(text.as_bytes(), 0).unwrap().0;
        assert_eq!(implied(number("12500"), &format(ZeroRule::Omit, ZeroRule::Keep)), 12.5);
        assert_eq!(implied(number("00125"), &format(ZeroRule::Keep, ZeroRule::Omit)), 12.5);
        assert_eq!(
            implied(
                number("125"),
                &NumberFormat { point: DecimalPointRule::Keep, ..format(ZeroRule::Omit, ZeroRule::Omit) }
            ),
            125.0
        );
    }

    #[test]
    fn digits_beyond_the_register_are_kept_cut_or_rounded() {
        let value = |text: &str, excess| {
            let (lead, trail) = (ZeroRule::Omit, ZeroRule::Omit);
            let format =
                NumberFormat { whole: 5, frac: 3, point: DecimalPointRule::Keep, lead, trail, plus: false, excess };
            let read = Read::new(format, (0, 0));
            let (value, irregular) = read.value_of_digits(parse_digits(text.as_bytes(), 0).unwrap().0);
            assert_eq!((value, irregular), read.value(parse_number(text.as_bytes(), 0).unwrap().0), "{text}");
            value
        };
        let cases = [
            ("1.2345", 1.2345, 1.234, 1.235),
            ("-1.2345", -1.2345, -1.234, -1.235),
            ("0.0006", 0.0006, 0.0, 0.001),
            ("0.0004", 0.0004, 0.0, 0.0),
            ("0.0005", 0.0005, 0.0, 0.001),
            ("0.00049999", 0.00049999, 0.0, 0.0),
            // 0.029 times 1000 is less than 29 in binary.
            ("0.0290", 0.029, 0.029, 0.029),
            ("1.0050000", 1.005, 1.005, 1.005),
            ("99999.9996", 99999.9996, 99999.999, 100_000.0),
            ("12345.678901234567", 12345.678901234567, 12345.678, 12345.679),
            ("5.", 5.0, 5.0, 5.0),
            ("5", 5.0, 5.0, 5.0),
        ];
        for (text, kept, cut, rounded) in cases {
            let values = [Excess::Kept, Excess::Cut, Excess::Rounded].map(|excess| value(text, excess));
            assert_eq!(values, [kept, cut, rounded], "{text}");
        }
    }

    #[test]
    fn every_number_with_one_digit_too_many_is_cut_and_rounded_as_its_digits_say() {
        let format = |excess| NumberFormat {
            whole: 5,
            frac: 3,
            point: DecimalPointRule::Keep,
            lead: ZeroRule::Omit,
            trail: ZeroRule::Omit,
            plus: false,
            excess,
        };
        let [cut, rounded] = [Excess::Cut, Excess::Rounded].map(|excess| Read::new(format(excess), (0, 0)));
        for units in (0..2_000_000_u32).step_by(7) {
            let text = format!("{}.{:04}", units / 10_000, units % 10_000);
            let number = parse_number(text.as_bytes(), 0).unwrap().0;
            let digits = parse_digits(text.as_bytes(), 0).unwrap().0;
            let (below, nearest) = (f64::from(units / 10) / 1000.0, f64::from((units + 5) / 10) / 1000.0);
            assert_eq!((cut.value(number).0, cut.value_of_digits(digits).0), (below, below), "{text}");
            assert_eq!((rounded.value(number).0, rounded.value_of_digits(digits).0), (nearest, nearest), "{text}");
        }
    }
}
