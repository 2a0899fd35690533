//! The meaning of functions and operators of numbers on every control that has them.
//!
//! *Invariant:* a dialect names functions and operators in its tables; none computes a shared one by itself.

mod function;
mod operator;

pub use function::{NAMED, NumericFunction, cosine, is_multiple, sine};
pub use operator::NumericOperator;

/// The value of a numbered variable that has none: one special NaN, which counts as zero in arithmetic and equals only
/// itself.
pub const VACANT: f64 = f64::from_bits(0x7ff8_0000_0c0d_e001);

/// Tells the vacant value from every other one.
#[inline]
pub fn is_vacant(value: f64) -> bool {
    value.to_bits() == VACANT.to_bits()
}

/// A truth as a number.
#[inline]
pub fn truth(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}
