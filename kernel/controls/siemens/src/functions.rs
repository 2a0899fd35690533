//! Functions of numbers.
//!
//! Facts: reference control-emulator.md 5.4. Angles are degrees; sines and cosines are exact at multiples of 90.
//! Decisions: ATAN2 is above −180 up to 180; BOUND(least, most, value); ROUND rounds halves away from zero, ROUNDUP to
//! the next larger whole number. Invariant: an argument outside its domain is an alarm.

use super::conversions::{bits, number, real, same};
use super::frame::{cosine, sine, turn};
use super::value::Data;
use super::{Outcome, SiemensBlockError, syntax};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};
use counterpoint_fault as diag;

/// Functions besides those of all controls, with the smallest and the largest number of arguments.
const FUNCTIONS: [(&str, usize, usize); 29] = [
    ("ATAN2", 2, 2),
    ("POT", 1, 1),
    ("TRUNC", 1, 1),
    ("ROUND", 1, 1),
    ("ROUNDUP", 1, 1),
    ("MINVAL", 2, 2),
    ("MAXVAL", 2, 2),
    ("BOUND", 3, 3),
    ("TOUPPER", 1, 1),
    ("TOLOWER", 1, 1),
    ("STRLEN", 1, 1),
    ("INDEX", 2, 2),
    ("RINDEX", 2, 2),
    ("MINDEX", 2, 2),
    ("MATCH", 2, 2),
    ("SUBSTR", 2, 3),
    ("NUMBER", 1, 1),
    ("ISNUMBER", 1, 1),
    ("AXSTRING", 1, 1),
    ("AXNAME", 1, 1),
    ("SPRINT", 1, 10),
    ("ISAXIS", 1, 1),
    ("ISVAR", 1, 1),
    ("ISFILE", 1, 1),
    ("GETT", 1, 2),
    ("INT", 1, 1),
    ("REAL", 1, 1),
    ("BOOL", 1, 1),
    ("STRING", 1, 1),
];

/// Whether the control has a function of this name.
pub(super) fn is_function(name: &str) -> bool {
    NumericFunction::named(name).is_some() || FUNCTIONS.iter().any(|(function, ..)| *function == name)
}

fn domain<T>(text: String) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::MACRO_DOMAIN, text))
}

/// Whether a function takes this many arguments.
pub(super) fn check(name: &str, count: usize) -> Outcome<()> {
    let known = FUNCTIONS.iter().find(|(function, ..)| *function == name);
    match known.copied().or(NumericFunction::named(name).map(|_| ("", 1, 1))) {
        Some((_, least, most)) if !(least..=most).contains(&count) => {
            let wanted = if least == most { least.to_string() } else { format!("{least} to {most}") };
            syntax(format!("{name} takes {wanted} arguments, not {count}"))
        }
        _ => Ok(()),
    }
}

/// The function of one number that a name means.
pub(super) fn of_one(name: &str) -> Option<NumericFunction> {
    Some(match name {
        "POT" => NumericFunction::Square,
        "TRUNC" => NumericFunction::Fix,
        "ROUND" => NumericFunction::Round,
        "ROUNDUP" => NumericFunction::Ceil,
        name => return NumericFunction::named(name),
    })
}

/// Value of a function of one number, or of a sign.
pub(super) fn apply(function: NumericFunction, value: &Data) -> Outcome<Data> {
    let v = number(value)?;
    let result = match (function, value) {
        (NumericFunction::Neg, Data::Int(value)) => return Ok(value.checked_neg().map_or(Data::Real(-v), Data::Int)),
        (NumericFunction::Neg, _) => return Ok(Data::Real(-v)),
        (NumericFunction::Not, _) => return Ok(Data::Bool(v == 0.0)),
        (NumericFunction::NotBits, _) => return Ok(Data::Int(i64::from(!bits(value)?))),
        (NumericFunction::Abs, Data::Int(value)) => return Ok(Data::Int(value.saturating_abs())),
        // A whole number with rounding residue is that number, as for comparisons.
        (NumericFunction::Fix, _) if same(v, v.round()) => return whole(v.round()),
        (NumericFunction::Fix | NumericFunction::Round | NumericFunction::Ceil, _) => {
            return whole(function.value(v).unwrap_or(v));
        }
        (NumericFunction::Sin, _) => Some(sine(v)),
        (NumericFunction::Cos, _) => Some(cosine(v)),
        (NumericFunction::Tan, _) => match turn(v) {
            (_, 0.0) => None,
            (sine, cosine) => Some(sine / cosine),
        },
        _ => function.value(v),
    };
    match result {
        Some(result) => real(result),
        None => domain(format!("{} has no value at {v}", function.name())),
    }
}

/// Value of another function of numbers; none if it is not one.
pub(super) fn number_function(name: &str, values: &[Data]) -> Outcome<Option<Data>> {
    let at = |at: usize| values.get(at).map_or(Ok(0.0), number);
    let value = match name {
        "ATAN2" => NumericOperator::Atan2.value(at(0)?, at(1)?).unwrap_or(0.0),
        "MINVAL" | "MAXVAL" => {
            let first_is_less = at(0)? <= at(1)?;
            let chosen = usize::from(first_is_less != (name == "MINVAL"));
            return Ok(values.get(chosen).cloned());
        }
        "BOUND" => {
            let (least, most, value) = (at(0)?, at(1)?, at(2)?);
            if least > most {
                return domain(format!("BOUND has no value between {least} and {most}"));
            }
            value.clamp(least, most)
        }
        "INT" => return whole(at(0)?.round()).map(Some),
        "REAL" => at(0)?,
        "BOOL" => return Ok(Some(Data::Bool(at(0)? != 0.0))),
        _ => return Ok(None),
    };
    real(value).map(Some)
}

/// A whole number; INT if it is one.
fn whole(value: f64) -> Outcome<Data> {
    if value.abs() <= super::value::MOST_INT as f64 { Ok(Data::Int(value as i64)) } else { real(value) }
}
