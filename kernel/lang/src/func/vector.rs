//! Vectors: sequences of numbers.

use super::math::{cosine, direction, sine};
use super::{FunctionContext, number, numbers};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::value::MacroValue;

/// Scalar product over the common length.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Length.
pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Vector product of two vectors with up to three elements.
pub(super) fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    let at = |v: &[f64], i: usize| v.get(i).copied().unwrap_or(0.0);
    [
        at(a, 1) * at(b, 2) - at(a, 2) * at(b, 1),
        at(a, 2) * at(b, 0) - at(a, 0) * at(b, 2),
        at(a, 0) * at(b, 1) - at(a, 1) * at(b, 0),
    ]
}

/// `a` plus `factor` times `b`, over the common length.
pub(super) fn along(a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(x, y)| x + factor * y).collect()
}

/// A vector of length one; zero stays zero.
pub(super) fn normalised(a: &[f64]) -> Vec<f64> {
    let length = norm(a);
    if length == 0.0 { a.to_vec() } else { a.iter().map(|x| x / length).collect() }
}

pub(super) fn add(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::numbers(&along(&numbers(arguments, 0)?, &numbers(arguments, 1)?, 1.0)))
}

pub(super) fn subtract(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::numbers(&along(&numbers(arguments, 0)?, &numbers(arguments, 1)?, -1.0)))
}

pub(super) fn multiply(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let factor = number(arguments, 1)?;
    let scaled: Vec<f64> = numbers(arguments, 0)?.iter().map(|x| x * factor).collect();
    Ok(MacroValue::numbers(&scaled))
}

pub(super) fn dot_product(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::Real(dot(&numbers(arguments, 0)?, &numbers(arguments, 1)?)))
}

pub(super) fn length(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::Real(norm(&numbers(arguments, 0)?)))
}

pub(super) fn unit(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::numbers(&normalised(&numbers(arguments, 0)?)))
}

/// A warning, and `$NULL` as the result.
fn impossible_size(context: &mut FunctionContext<'_>) -> Outcome<MacroValue> {
    context.state.warn(MacroFault::new(DiagnosticNumber::BAD_VECTOR, "both vectors must have two or three elements"));
    Ok(MacroValue::Null)
}

fn unsigned_angle(a: &[f64], b: &[f64]) -> f64 {
    direction(norm(&cross(a, b)), dot(a, b))
}

pub(super) fn angle(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (a, b) = (numbers(arguments, 0)?, numbers(arguments, 1)?);
    match (a.len(), b.len()) {
        (2, 2) => {
            let [.., z] = cross(&a, &b);
            Ok(MacroValue::Real(direction(z, dot(&a, &b))))
        }
        (3, 3) => Ok(MacroValue::Real(unsigned_angle(&a, &b))),
        _ => impossible_size(context),
    }
}

pub(super) fn cross_product(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (a, b) = (numbers(arguments, 0)?, numbers(arguments, 1)?);
    if a.len() != b.len() || !matches!(a.len(), 2 | 3) {
        return impossible_size(context);
    }
    Ok(MacroValue::numbers(&cross(&a, &b)))
}

/// Turns `v` about `axis` counter-clockwise.
fn turned(v: &[f64], axis: &[f64], degrees: f64) -> Vec<f64> {
    let axis = normalised(axis);
    let (s, c) = (sine(degrees).unwrap_or(0.0), cosine(degrees).unwrap_or(1.0));
    let around = cross(&axis, v);
    let inside = dot(&axis, v) * (1.0 - c);
    v.iter().zip(around).zip(&axis).map(|((x, r), k)| x * c + r * s + k * inside).collect()
}

/// A vector of two or three elements as one of three, with its length; none for other lengths.
fn three(mut v: Vec<f64>) -> Option<(Vec<f64>, usize)> {
    let length = v.len();
    v.resize(3, 0.0);
    matches!(length, 2 | 3).then_some((v, length))
}

/// As many elements as came in, unless the vector was turned out of the plane: then all three.
fn as_long(result: &[f64], length: usize) -> MacroValue {
    let (kept, rest) = result.split_at_checked(length).unwrap_or((result, &[]));
    MacroValue::numbers(if rest.iter().all(|part| *part == 0.0) { kept } else { result })
}

/// The fraction 1 or −1 gives the direction of the second vector, for any angle; a negative fraction goes in the
/// opposite direction.
pub(super) fn turn_toward(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (Some((a, length)), Some((b, _))) = (three(numbers(arguments, 0)?), three(numbers(arguments, 1)?)) else {
        return impossible_size(context);
    };
    let fraction = number(arguments, 2)?;
    let axis = cross(&a, &b);
    let result = if fraction.abs() == 1.0 && norm(&b) > 0.0 {
        normalised(&b).iter().map(|part| part * norm(&a)).collect()
    } else if norm(&axis) == 0.0 {
        a
    } else {
        let angle = unsigned_angle(&a, &b);
        turned(&a, &axis, if fraction < 0.0 { 360.0 - angle } else { angle } * fraction)
    };
    Ok(as_long(&result, length))
}

pub(super) fn turn_about(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (Some((v, length)), Some((axis, _))) = (three(numbers(arguments, 1)?), three(numbers(arguments, 2)?)) else {
        return impossible_size(context);
    };
    let tolerance = if arguments.len() > 3 { number(arguments, 3)? } else { 0.0001 };
    let between = unsigned_angle(&v, &axis);
    let parallel = between.min(180.0 - between) <= tolerance;
    let result = if parallel || norm(&axis) == 0.0 { v } else { turned(&v, &axis, number(arguments, 0)?) };
    Ok(as_long(&result, length))
}
