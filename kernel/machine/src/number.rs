//! A number in the written form of a register.
//!
//! Invariant: the scanner reads a written number back as the same value, to the digits of the format. Facts: reference
//! control-emulator.md 1.4.

use super::rows::{DecimalPointRule, NumberFormat, ZeroRule};

/// `value` as a register of this format writes it: `12.`, `.2`, `-4.`, `0125`.
#[must_use]
pub fn written(value: f64, format: &NumberFormat) -> String {
    let places = usize::from(format.frac);
    let plain = format!("{:.places$}", value.abs());
    let (whole, fraction) = plain.split_once('.').unwrap_or((&plain, ""));
    let implied = format.point == DecimalPointRule::Omit && format.frac > 0;
    // An implied point needs all digits on one side, otherwise its place would be ambiguous.
    let left_justified = implied && format.trail == ZeroRule::Omit && format.lead != ZeroRule::Omit;
    let whole = if left_justified {
        format!("{whole:0>width$}", width = usize::from(format.whole))
    } else {
        lead(whole, format)
    };
    let fraction = if implied && !left_justified { fraction.to_owned() } else { trail(fraction, format) };
    let point = match format.point {
        DecimalPointRule::Keep => format.frac > 0,
        DecimalPointRule::Fractional => !fraction.is_empty(),
        DecimalPointRule::Omit => false,
    };
    let mut digits = format!("{whole}{}{fraction}", if point { "." } else { "" });
    if implied && !left_justified && format.lead == ZeroRule::Omit {
        digits = digits.trim_start_matches('0').to_owned();
    }
    if !digits.bytes().any(|b| b.is_ascii_digit()) {
        digits = if point { "0.".to_owned() } else { "0".to_owned() };
    }
    let zero = digits.bytes().all(|b| matches!(b, b'0' | b'.'));
    let sign = if value < 0.0 && !zero {
        "-"
    } else if format.plus {
        "+"
    } else {
        ""
    };
    format!("{sign}{digits}")
}

/// The value that a register of this format reads from the text of [`written`], computed without the text.
#[must_use]
pub fn rounded(value: f64, format: &NumberFormat) -> f64 {
    let magnitude = value.abs();
    let scale = POWERS.get(usize::from(format.frac)).copied().unwrap_or(f64::INFINITY);
    let units = magnitude * scale;
    let from_half = (units - units.floor() - 0.5).abs();
    // The product may be on the wrong side of a half unit; the decimal text is not.
    let rounded = if units < CERTAIN && from_half > NEAR_HALF {
        units.round() / scale
    } else {
        format!("{magnitude:.0$}", usize::from(format.frac)).parse().unwrap_or(magnitude)
    };
    if value < 0.0 && rounded != 0.0 { -rounded } else { rounded }
}

/// Powers of ten for the digits after a point.
const POWERS: [f64; 10] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

/// Below this limit a product is exact to less than [`NEAR_HALF`].
const CERTAIN: f64 = 1e11;

/// A product this close to a half may round to either side.
const NEAR_HALF: f64 = 1e-4;

/// A computed value with at most nine digits after the point, which is what programs can see of it.
#[must_use]
pub fn shortest(value: f64) -> f64 {
    let tidy = if value.abs() < 1e6 { (value * 1e9).round() / 1e9 } else { value };
    tidy + 0.0
}

fn lead(whole: &str, format: &NumberFormat) -> String {
    match format.lead {
        ZeroRule::Keep => format!("{whole:0>width$}", width = usize::from(format.whole)),
        ZeroRule::One => whole.to_owned(),
        ZeroRule::Omit => whole.trim_start_matches('0').to_owned(),
    }
}

fn trail(fraction: &str, format: &NumberFormat) -> String {
    let short = fraction.trim_end_matches('0');
    match format.trail {
        ZeroRule::Keep => fraction.to_owned(),
        ZeroRule::One if short.is_empty() && format.frac > 0 => "0".to_owned(),
        ZeroRule::One | ZeroRule::Omit => short.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::Excess;

    const fn format(point: DecimalPointRule, lead: ZeroRule, trail: ZeroRule) -> NumberFormat {
        NumberFormat { whole: 4, frac: 3, point, lead, trail, plus: false, excess: Excess::Kept }
    }

    #[test]
    fn a_kept_point() {
        let short = format(DecimalPointRule::Keep, ZeroRule::Omit, ZeroRule::Omit);
        let cases = [(12.0, "12."), (0.2, ".2"), (-4.0, "-4."), (0.0, "0."), (-0.0001, "0."), (1.2345, "1.234")];
        for (value, text) in cases {
            assert_eq!(written(value, &short), text);
        }
        assert_eq!(written(0.5, &format(DecimalPointRule::Keep, ZeroRule::One, ZeroRule::One)), "0.5");
        assert_eq!(written(2.0, &format(DecimalPointRule::Keep, ZeroRule::One, ZeroRule::One)), "2.0");
        assert_eq!(written(2.0, &format(DecimalPointRule::Keep, ZeroRule::Keep, ZeroRule::Keep)), "0002.000");
    }

    #[test]
    fn a_rounded_value_is_the_written_one() {
        let values = [0.0, 0.0005, 1.0005, 1.2345, 2.0 / 3.0, 8.0625, 123_456.789_05, 2.5e15, 1e-9, 4.35, 1.005];
        for frac in [0, 1, 3, 4, 6, 12] {
            let format = NumberFormat { frac, ..format(DecimalPointRule::Keep, ZeroRule::One, ZeroRule::One) };
            for value in values.into_iter().flat_map(|value| [value, -value]) {
                let read: f64 = written(value, &format).parse().unwrap();
                assert_eq!(rounded(value, &format).to_bits(), read.to_bits(), "{value} with {frac} digits");
            }
        }
        assert_eq!(rounded(12.5, &format(DecimalPointRule::Omit, ZeroRule::Keep, ZeroRule::Omit)), 12.5);
    }

    #[test]
    fn a_point_only_if_needed() {
        let whole =
            NumberFormat { whole: 4, frac: 0, ..format(DecimalPointRule::Fractional, ZeroRule::Omit, ZeroRule::Omit) };
        assert_eq!(written(950.0, &whole), "950");
        assert_eq!(written(0.0, &whole), "0");
        assert_eq!(written(54.1, &format(DecimalPointRule::Fractional, ZeroRule::Omit, ZeroRule::Omit)), "54.1");
        let plus = NumberFormat { plus: true, ..whole };
        assert_eq!((written(3.0, &plus).as_str(), written(-3.0, &plus).as_str()), ("+3", "-3"));
    }

    #[test]
    fn an_implied_point() {
        assert_eq!(written(12.5, &format(DecimalPointRule::Omit, ZeroRule::Omit, ZeroRule::Keep)), "12500");
        assert_eq!(written(0.001, &format(DecimalPointRule::Omit, ZeroRule::Omit, ZeroRule::Omit)), "1");
        assert_eq!(written(12.5, &format(DecimalPointRule::Omit, ZeroRule::Keep, ZeroRule::Omit)), "00125");
    }
}
