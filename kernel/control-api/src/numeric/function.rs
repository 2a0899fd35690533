//! Functions of one number.
//!
//! *Invariants:* angles are degrees, and sine and cosine are exact at multiples of 90; functions come from `libm`, so
//! that every machine gives the same bits.

use std::f64::consts::PI;

/// Degrees of a radian.
pub(crate) const DEGREES: f64 = 180.0 / PI;

/// Whole multiples of a whole number of degrees, which most angles of programs are not: a remainder costs more.
#[inline]
pub fn is_multiple(degrees: f64, of: f64) -> bool {
    /// Up to here a product of whole numbers is exact.
    const EXACT: f64 = 9e15;
    if degrees.abs() > EXACT {
        return degrees.rem_euclid(of) == 0.0;
    }
    (degrees / of) as i64 as f64 * of == degrees
}

/// Sine.
pub fn sine(degrees: f64) -> f64 {
    if is_multiple(degrees, 180.0) { 0.0 } else { libm::sin(degrees * PI / 180.0) }
}

/// Cosine.
pub fn cosine(degrees: f64) -> f64 {
    if is_multiple(degrees - 90.0, 180.0) { 0.0 } else { libm::cos(degrees * PI / 180.0) }
}

/// Tangent; none where there is none.
fn tangent(degrees: f64) -> Option<f64> {
    let cosine = cosine(degrees);
    (cosine != 0.0).then(|| sine(degrees) / cosine)
}

/// The whole number away from zero.
pub(crate) fn away(value: f64) -> f64 {
    if value < 0.0 { value.floor() } else { value.ceil() }
}

/// The number whose decimal digits are the groups of four bits; none where a group is above nine.
fn from_bcd(value: f64) -> Option<f64> {
    let (mut rest, mut out, mut weight) = (value.abs() as u64, 0.0, 1.0);
    while rest > 0 {
        if rest & 15 > 9 {
            return None;
        }
        out += (rest & 15) as f64 * weight;
        weight *= 10.0;
        rest >>= 4;
    }
    Some(out.copysign(value))
}

/// The number whose groups of four bits are the decimal digits.
fn to_bcd(value: f64) -> f64 {
    let (mut rest, mut out, mut shift) = (value.abs() as u64, 0_u64, 0_u32);
    while rest > 0 && shift < 64 {
        out |= (rest % 10) << shift;
        rest /= 10;
        shift += 4;
    }
    (out as f64).copysign(value)
}

/// Functions of one number that most controls have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumericFunction {
    /// Sine of an angle.
    Sin,
    /// Cosine of an angle.
    Cos,
    /// Tangent of an angle.
    Tan,
    /// Angle of a sine.
    Asin,
    /// Angle of a cosine.
    Acos,
    /// Angle of a tangent.
    Atan,
    /// Square root.
    Sqrt,
    /// Absolute value.
    Abs,
    /// Natural logarithm.
    Ln,
    /// Power of e.
    Exp,
    /// To the nearest whole number, halves away from zero.
    Round,
    /// To the whole number towards zero.
    Fix,
    /// To the whole number away from zero.
    Fup,
    /// To the next larger whole number.
    Ceil,
    /// To the next smaller whole number.
    Floor,
    /// From binary-coded decimal.
    Bin,
    /// To binary-coded decimal.
    Bcd,
    /// The opposite number.
    Neg,
    /// The product with itself.
    Square,
    /// Logarithm to base 10.
    Log,
    /// The digits after the point.
    Frac,
    /// -1 below zero, otherwise 1.
    Sign,
    /// The bits of a whole number, inverted.
    NotBits,
    /// A truth, inverted.
    Not,
    /// An angle from 0 to 360 degrees.
    FullTurn,
}

/// Functions that every control has, under the name that every control gives them.
pub const NAMED: [(&str, NumericFunction); 9] = [
    ("SIN", NumericFunction::Sin),
    ("COS", NumericFunction::Cos),
    ("TAN", NumericFunction::Tan),
    ("ASIN", NumericFunction::Asin),
    ("ACOS", NumericFunction::Acos),
    ("SQRT", NumericFunction::Sqrt),
    ("ABS", NumericFunction::Abs),
    ("LN", NumericFunction::Ln),
    ("EXP", NumericFunction::Exp),
];

impl NumericFunction {
    /// One that every control has.
    pub fn named(name: &str) -> Option<Self> {
        NAMED.iter().find(|(known, _)| *known == name).map(|(_, function)| *function)
    }

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sin => "SIN",
            Self::Cos => "COS",
            Self::Tan => "TAN",
            Self::Asin => "ASIN",
            Self::Acos => "ACOS",
            Self::Atan => "ATAN",
            Self::Sqrt => "SQRT",
            Self::Abs => "ABS",
            Self::Ln => "LN",
            Self::Exp => "EXP",
            Self::Round => "ROUND",
            Self::Fix => "FIX",
            Self::Fup => "FUP",
            Self::Ceil => "ROUNDUP",
            Self::Floor => "FIX",
            Self::Bin => "BIN",
            Self::Bcd => "BCD",
            Self::Neg => "NEG",
            Self::Square => "SQ",
            Self::Log => "LOG",
            Self::Frac => "FRAC",
            Self::Sign => "SGN",
            Self::NotBits | Self::Not => "NOT",
            Self::FullTurn => "ASIN",
        }
    }

    /// Value, none outside the domain of the function. Whether it is finite is not checked.
    pub fn value(self, v: f64) -> Option<f64> {
        Some(match self {
            Self::Sin => sine(v),
            Self::Cos => cosine(v),
            Self::Tan => tangent(v)?,
            Self::Asin | Self::Acos if v.abs() > 1.0 => return None,
            Self::Asin => libm::asin(v) * DEGREES,
            Self::Acos => libm::acos(v) * DEGREES,
            Self::FullTurn => v.rem_euclid(360.0),
            Self::Atan => libm::atan(v) * DEGREES,
            Self::Sqrt if v < 0.0 => return None,
            Self::Sqrt => v.sqrt(),
            Self::Abs => v.abs(),
            Self::Ln if v <= 0.0 => return None,
            Self::Ln => libm::log(v),
            Self::Exp => libm::exp(v),
            Self::Round => v.round(),
            Self::Fix => v.trunc(),
            Self::Fup => away(v),
            Self::Ceil => v.ceil(),
            Self::Floor => v.floor(),
            Self::Bin => from_bcd(v)?,
            Self::Bcd => to_bcd(v),
            Self::Neg => -v,
            Self::Square => v * v,
            Self::Log => libm::log10(v),
            Self::Frac => v.fract(),
            Self::Sign if v < 0.0 => -1.0,
            Self::Sign => 1.0,
            Self::NotBits => !(v as i64) as f64,
            Self::Not => super::truth(v == 0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        for (degrees, sin, cos) in [(0.0, 0.0, 1.0), (90.0, 1.0, 0.0), (180.0, 0.0, -1.0), (-90.0, -1.0, 0.0)] {
            assert_eq!((sine(degrees), cosine(degrees)), (sin, cos), "{degrees}");
        }
        assert_eq!((tangent(180.0), tangent(-90.0), tangent(450.0)), (Some(-0.0), None, None));
    }

    #[test]
    fn multiples_are_those_without_a_remainder() {
        let near = |value: f64| [value.next_down(), value, value.next_up()];
        let whole = (-5_i32..40).flat_map(|power| near(180.0 * f64::from(power) * 10_f64.powi(power.max(0))));
        let other =
            [0.1, 90.0, 359.999_999_999_999_94, 1e16, 180.0 * 2_f64.powi(60), f64::MAX, f64::NAN, f64::INFINITY];
        for degrees in whole.chain(other.into_iter().flat_map(near)).flat_map(|degrees| [degrees, -degrees]) {
            for of in [90.0, 180.0] {
                assert_eq!(is_multiple(degrees, of), degrees.rem_euclid(of) == 0.0, "{degrees} {of}");
            }
        }
    }

    #[test]
    fn decimals_in_bits() {
        assert_eq!((to_bcd(25.0), from_bcd(37.0), from_bcd(-37.0)), (37.0, Some(25.0), Some(-25.0)));
        assert_eq!((from_bcd(26.0), from_bcd(25.0)), (None, Some(19.0)));
        assert_eq!((away(2.1), away(-2.1)), (3.0, -3.0));
    }

    #[test]
    fn functions_have_no_value_outside_their_domain() {
        for (function, outside) in [
            (NumericFunction::Tan, 90.0),
            (NumericFunction::Asin, 1.1),
            (NumericFunction::Acos, -1.1),
            (NumericFunction::Sqrt, -1.0),
            (NumericFunction::Ln, 0.0),
        ] {
            assert_eq!(function.value(outside), None, "{}", function.name());
        }
        assert_eq!((NumericFunction::Sqrt.value(9.0), NumericFunction::Fup.value(-2.1)), (Some(3.0), Some(-3.0)));
    }
}
