//! Functions of numbers.
//!
//! Facts: reference control-emulator.md 5.4. Angles are degrees; sines and cosines are exact at multiples of 90.
//! Decisions: ATAN2 is above −180 up to 180; BOUND(least, most, value); ROUND rounds halves away from zero, ROUNDUP to
//! the next larger whole number. Invariant: an argument outside its domain is an alarm.

use super::evaluate::{number, real, same};
use super::frame::turn;
use super::value::Data;
use super::{Fault, Outcome, syntax};
use counterpoint_fault as diag;

/// Functions, with the smallest and the largest number of arguments.
const FUNCTIONS: [(&str, usize, usize); 37] = [
    ("SIN", 1, 1),
    ("COS", 1, 1),
    ("TAN", 1, 1),
    ("ASIN", 1, 1),
    ("ACOS", 1, 1),
    ("ATAN2", 2, 2),
    ("SQRT", 1, 1),
    ("ABS", 1, 1),
    ("POT", 1, 1),
    ("TRUNC", 1, 1),
    ("ROUND", 1, 1),
    ("ROUNDUP", 1, 1),
    ("LN", 1, 1),
    ("EXP", 1, 1),
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
    ("INT", 1, 1),
    ("REAL", 1, 1),
    ("BOOL", 1, 1),
    ("STRING", 1, 1),
];

/// The control has a function of this name.
pub(super) fn is_function(name: &str) -> bool {
    FUNCTIONS.iter().any(|(function, ..)| *function == name)
}

fn domain<T>(text: String) -> Outcome<T> {
    Err(Fault::Alarm(&diag::MACRO_DOMAIN, text))
}

/// Value of a function of numbers; none if it is not one.
pub(super) fn number_function(name: &str, values: &[Data]) -> Outcome<Option<Data>> {
    let Some((_, least, most)) = FUNCTIONS.iter().find(|(function, ..)| *function == name) else { return Ok(None) };
    if !(*least..=*most).contains(&values.len()) {
        let wanted = if least == most { least.to_string() } else { format!("{least} to {most}") };
        return syntax(format!("{name} takes {wanted} arguments, not {}", values.len()));
    }
    let at = |at: usize| values.get(at).map_or(Ok(0.0), number);
    let outside = |value: f64| domain(format!("{name} has no value at {value}"));
    let value = match name {
        "SIN" => turn(at(0)?).0,
        "COS" => turn(at(0)?).1,
        "TAN" => match turn(at(0)?) {
            (_, 0.0) => return outside(at(0)?),
            (sine, cosine) => sine / cosine,
        },
        "ASIN" | "ACOS" if at(0)?.abs() > 1.0 => return outside(at(0)?),
        "ASIN" => libm::asin(at(0)?).to_degrees(),
        "ACOS" => libm::acos(at(0)?).to_degrees(),
        "ATAN2" => libm::atan2(at(0)?, at(1)?).to_degrees(),
        "SQRT" if at(0)? < 0.0 => return outside(at(0)?),
        "SQRT" => at(0)?.sqrt(),
        "ABS" => match values.first() {
            Some(Data::Int(value)) => return Ok(Some(Data::Int(value.abs()))),
            _ => at(0)?.abs(),
        },
        "POT" => at(0)? * at(0)?,
        "TRUNC" => {
            let value = at(0)?;
            // What rounding has left of a whole number is that number, as for comparisons.
            return whole(if same(value, value.round()) { value.round() } else { value.trunc() });
        }
        "ROUND" => return whole(at(0)?.round()),
        "ROUNDUP" => return whole(at(0)?.ceil()),
        "LN" if at(0)? <= 0.0 => return outside(at(0)?),
        "LN" => libm::log(at(0)?),
        "EXP" => libm::exp(at(0)?),
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
        "INT" => return whole(at(0)?.round()),
        "REAL" => at(0)?,
        "BOOL" => return Ok(Some(Data::Bool(at(0)? != 0.0))),
        _ => return Ok(None),
    };
    real(value).map(Some)
}

/// A whole number; INT if it is one.
fn whole(value: f64) -> Outcome<Option<Data>> {
    if value.abs() <= super::value::MOST_INT as f64 { Ok(Some(Data::Int(value as i64))) } else { real(value).map(Some) }
}
