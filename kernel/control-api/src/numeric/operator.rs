//! Operators between two values.
//!
//! *Invariant:* a division by zero has no value; every other operator has one, which may not be finite.

use super::function::DEGREES;
use super::truth;

/// Values that differ by less are equal for [`NumericOperator::EqNear`].
const NEAR: f64 = 1e-6;

/// An operator between two operands, or a function of two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumericOperator {
    /// Sum.
    Add,
    /// Difference.
    Sub,
    /// Product.
    Mul,
    /// Quotient.
    Div,
    /// The whole part of a quotient.
    WholeDiv,
    /// Remainder, with the sign of the dividend.
    Rem,
    /// Remainder of both operands rounded to whole numbers.
    RemOfWhole,
    /// Remainder by the whole part of the quotient.
    RemByQuotient,
    /// Remainder that is never negative.
    RemPositive,
    /// The first operand to the power of the second.
    Power,
    /// Equal.
    Eq,
    /// Not equal.
    Ne,
    /// Greater.
    Gt,
    /// Greater or equal.
    Ge,
    /// Less.
    Lt,
    /// Less or equal.
    Le,
    /// Equal, with a tolerance of a millionth.
    EqNear,
    /// Not equal, with a tolerance of a millionth.
    NeNear,
    /// And, of the bits of whole numbers.
    BitAnd,
    /// Or, of the bits of whole numbers.
    BitOr,
    /// Exclusive or, of the bits of whole numbers.
    BitXor,
    /// And, of truths.
    And,
    /// Or, of truths.
    Or,
    /// Exclusive or, of truths.
    Xor,
    /// Angle of a height and a length.
    Atan2,
    /// The same, 0 to 360 degrees.
    Angle,
    /// Length of the longest side of a right triangle.
    Legs,
    /// Two texts.
    Join,
    /// Two frames.
    Chain,
}

impl NumericOperator {
    /// Whether its value is a truth value for any operands.
    pub fn compares(self) -> bool {
        matches!(self, Self::Eq | Self::Ne | Self::Gt | Self::Ge | Self::Lt | Self::Le | Self::EqNear | Self::NeNear)
    }

    /// Value for two numbers; none for a division by zero.
    #[inline]
    pub fn value(self, a: f64, b: f64) -> Option<f64> {
        match self {
            Self::Add => Some(a + b),
            Self::Sub => Some(a - b),
            Self::Mul => Some(a * b),
            Self::Lt => Some(truth(a < b)),
            _ => self.other_value(a, b),
        }
    }

    /// The same for operators that programs have less often.
    #[inline(never)]
    fn other_value(self, a: f64, b: f64) -> Option<f64> {
        Some(match self {
            Self::Add => a + b,
            Self::Sub => a - b,
            Self::Mul => a * b,
            Self::Div | Self::WholeDiv | Self::Rem | Self::RemByQuotient | Self::RemPositive if b == 0.0 => {
                return None;
            }
            Self::Div => a / b,
            Self::WholeDiv => (a / b).trunc(),
            Self::Rem => a % b,
            Self::RemOfWhole if b.round() == 0.0 => return None,
            // Never the negative zero.
            Self::RemOfWhole => a.round() % b.round() + 0.0,
            Self::RemByQuotient => a - b * (a / b).trunc(),
            Self::RemPositive => a.rem_euclid(b),
            Self::Power => libm::pow(a, b),
            Self::Eq => truth(a == b),
            Self::Ne => truth(a != b),
            Self::EqNear => truth((a - b).abs() < NEAR),
            Self::NeNear => truth((a - b).abs() >= NEAR),
            Self::Gt => truth(a > b),
            Self::Ge => truth(a >= b),
            Self::Lt => truth(a < b),
            Self::Le => truth(a <= b),
            Self::BitAnd => (a as i64 & b as i64) as f64,
            Self::BitOr => (a as i64 | b as i64) as f64,
            Self::BitXor => (a as i64 ^ b as i64) as f64,
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::Xor => truth((a != 0.0) != (b != 0.0)),
            Self::Atan2 => libm::atan2(a, b) * DEGREES,
            // The first leg lies opposite to the angle.
            Self::Angle => (libm::atan2(a, b) * DEGREES).rem_euclid(360.0),
            Self::Legs => libm::sqrt(a * a + b * b),
            // Of texts and frames only.
            Self::Join | Self::Chain => a,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::NumericOperator;

    #[test]
    fn remainders_differ_by_control() {
        for (operator, a, b, expected) in [
            (NumericOperator::Rem, 7.5, 2.0, Some(1.5)),
            (NumericOperator::Rem, -7.5, 2.0, Some(-1.5)),
            (NumericOperator::RemOfWhole, 7.6, 2.4, Some(0.0)),
            (NumericOperator::RemOfWhole, 7.0, 0.4, None),
            (NumericOperator::RemByQuotient, -7.5, 2.0, Some(-1.5)),
            (NumericOperator::RemPositive, -7.5, 2.0, Some(0.5)),
            (NumericOperator::RemPositive, 7.5, -2.0, Some(1.5)),
            (NumericOperator::RemPositive, 1.0, 0.0, None),
            (NumericOperator::WholeDiv, -7.0, 2.0, Some(-3.0)),
            (NumericOperator::Div, 1.0, 0.0, None),
            (NumericOperator::Rem, 1.0, 0.0, None),
        ] {
            assert_eq!(operator.value(a, b), expected, "{operator:?} {a} {b}");
        }
        assert_eq!(NumericOperator::RemOfWhole.value(-4.0, 2.0).map(f64::to_bits), Some(0.0_f64.to_bits()));
    }

    #[test]
    fn truths_and_bits() {
        assert_eq!(NumericOperator::And.value(6.0, 3.0), Some(1.0));
        assert_eq!(NumericOperator::BitAnd.value(6.0, 3.0), Some(2.0));
        assert_eq!(NumericOperator::Xor.value(6.0, 3.0), Some(0.0));
        assert_eq!(NumericOperator::BitXor.value(6.0, 3.0), Some(5.0));
        assert_eq!(
            (NumericOperator::Legs.value(3.0, 4.0), NumericOperator::Angle.value(-1.0, 0.0)),
            (Some(5.0), Some(270.0))
        );
    }
}
