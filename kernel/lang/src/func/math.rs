//! Arithmetic; the angles come from one library so that every machine gives the same bits.

use super::{FunctionContext, impossible, number};
use crate::fault::Outcome;
use crate::value::MacroValue;

const RADIAN: f64 = std::f64::consts::PI / 180.0;

/// Whole quarter turns give exact results.
fn quarter(degrees: f64) -> Option<usize> {
    let turns = (degrees / 90.0).rem_euclid(4.0);
    [0.0, 1.0, 2.0, 3.0].iter().position(|quarter| *quarter == turns)
}

pub(super) fn sine(degrees: f64) -> Option<f64> {
    match quarter(degrees) {
        Some(quarter) => [0.0, 1.0, 0.0, -1.0].get(quarter).copied(),
        None => Some(libm::sin(degrees * RADIAN)),
    }
}

pub(super) fn cosine(degrees: f64) -> Option<f64> {
    match quarter(degrees) {
        Some(quarter) => [1.0, 0.0, -1.0, 0.0].get(quarter).copied(),
        None => Some(libm::cos(degrees * RADIAN)),
    }
}

pub(super) fn tangent(degrees: f64) -> Option<f64> {
    match quarter(degrees) {
        Some(0 | 2) => Some(0.0),
        Some(_) => None,
        None => Some(libm::tan(degrees * RADIAN)),
    }
}

pub(super) fn arc_sine(n: f64) -> Option<f64> {
    (-1.0..=1.0).contains(&n).then(|| libm::asin(n) / RADIAN)
}

pub(super) fn arc_cosine(n: f64) -> Option<f64> {
    (-1.0..=1.0).contains(&n).then(|| libm::acos(n) / RADIAN)
}

pub(super) fn arc_tangent(n: f64) -> Option<f64> {
    Some(libm::atan(n) / RADIAN)
}

pub(super) fn exponential(n: f64) -> Option<f64> {
    Some(libm::exp(n))
}

pub(super) fn natural_logarithm(n: f64) -> Option<f64> {
    (n > 0.0).then(|| libm::log(n))
}

pub(super) fn logarithm(n: f64) -> Option<f64> {
    (n > 0.0).then(|| libm::log10(n))
}

pub(super) fn root(n: f64) -> Option<f64> {
    (n >= 0.0).then(|| n.sqrt())
}

/// Angle of a vector in degrees, (−180, 180].
pub(super) fn direction(y: f64, x: f64) -> f64 {
    let degrees = libm::atan2(y, x) / RADIAN;
    if degrees <= -180.0 { 180.0 } else { degrees }
}

pub(super) fn arc_tangent_of_two(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (y, x) = (number(arguments, 0)?, number(arguments, 1)?);
    if x == 0.0 && y == 0.0 {
        return impossible("$FATAN2 has no result for two zeros");
    }
    Ok(MacroValue::Real(direction(y, x)))
}

/// The remainder of two whole numbers, which takes no library; the sign is that of `a`.
pub(super) fn quick_remainder(a: f64, b: f64) -> Option<f64> {
    #[allow(clippy::cast_possible_truncation)]
    let (x, y) = (a as i32, b as i32);
    if f64::from(x) == a && f64::from(y) == b {
        return x.checked_rem(y).map(|rest| f64::from(rest).copysign(a));
    }
    (b != 0.0).then(|| a % b)
}

pub(super) fn remainder(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (a, b) = (number(arguments, 0)?, number(arguments, 1)?);
    if b == 0.0 {
        return impossible("$FMOD divides by zero");
    }
    Ok(MacroValue::Real(a % b))
}

fn fold(arguments: &[MacroValue], choose: fn(f64, f64) -> f64) -> Outcome<MacroValue> {
    let mut result = number(arguments, 0)?;
    for position in 1..arguments.len() {
        result = choose(result, number(arguments, position)?);
    }
    Ok(MacroValue::Real(result))
}

pub(super) fn largest(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    fold(arguments, f64::max)
}

pub(super) fn smallest(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    fold(arguments, f64::min)
}

pub(super) fn distance(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let mut sum = 0.0;
    for axis in 0..3 {
        let difference = number(arguments, axis + 3)? - number(arguments, axis)?;
        sum += difference * difference;
    }
    Ok(MacroValue::Real(sum.sqrt()))
}
