//! Conversion, tests and choice.

use super::{FunctionContext, count, number as real_argument, string};
use crate::fault::{MacroFault, Outcome};
use crate::ident;
use crate::value::{MacroValue, RecordName, ValueType};

/// Number at the beginning of a text, 0 without one.
pub(super) fn prefix(text: &str) -> f64 {
    let text = text.trim_start();
    let mut end = 0;
    let (mut point, mut digits) = (false, false);
    for (at, c) in text.char_indices() {
        match c {
            '+' | '-' if at == 0 => {}
            '.' if !point => point = true,
            '0'..='9' => digits = true,
            _ => break,
        }
        end = at + 1;
    }
    if digits { text.get(..end).and_then(|part| part.parse().ok()).unwrap_or(0.0) } else { 0.0 }
}

pub(super) fn number(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::Real(prefix(string(arguments, 0)?)))
}

fn as_real(value: &MacroValue) -> Outcome<f64> {
    Ok(match value {
        MacroValue::Unset => 0.0,
        MacroValue::Real(number) => *number,
        MacroValue::Logical(truth) => f64::from(u8::from(*truth)),
        MacroValue::Keyword(code) => f64::from(*code),
        MacroValue::Record(record) => f64::from(record.subclass),
        MacroValue::Text(text) => prefix(text),
        MacroValue::Code(index) | MacroValue::Register(index) => f64::from(*index),
        MacroValue::Sequence(elements) => match elements.first() {
            Some(first) => as_real(first)?,
            None => 0.0,
        },
        MacroValue::Null | MacroValue::Array(_) => return Err(MacroFault::kind("a value with a type", value)),
    })
}

pub(super) fn real(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    as_real(arguments.first().unwrap_or(&MacroValue::Unset)).map(MacroValue::Real)
}

pub(super) fn whole(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    as_real(arguments.first().unwrap_or(&MacroValue::Unset)).map(|number| MacroValue::Real(number.trunc()))
}

fn code(number: f64) -> Option<i32> {
    #[allow(clippy::cast_possible_truncation)]
    (0.0..=1e9).contains(&number.round()).then(|| number.round() as i32)
}

pub(super) fn minor(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let found = match arguments.first().unwrap_or(&MacroValue::Unset) {
        MacroValue::Text(name) => ident::minor_code(&name.trim().to_uppercase()),
        value => code(value.as_real().ok_or_else(|| MacroFault::kind("a number or a text", value))?),
    };
    Ok(found.map_or(MacroValue::Null, MacroValue::Keyword))
}

pub(super) fn major(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    if let Some(MacroValue::Text(name)) = arguments.first() {
        return Ok(ident::record(&name.trim().to_uppercase()).map_or(MacroValue::Null, MacroValue::Record));
    }
    let first = real_argument(arguments, 0)?;
    let (class, subclass) = match arguments.get(1) {
        Some(_) => (code(first), code(real_argument(arguments, 1)?)),
        None => (Some(ident::MAJOR_CLASS), code(first)),
    };
    Ok(class
        .zip(subclass)
        .map_or(MacroValue::Null, |(class, subclass)| MacroValue::Record(RecordName { class, subclass })))
}

pub(super) fn is(arguments: &[MacroValue], kind: ValueType) -> MacroValue {
    MacroValue::Logical(arguments.first().and_then(MacroValue::kind) == Some(kind))
}

fn truth(value: &MacroValue) -> Outcome<bool> {
    value.as_logical().ok_or_else(|| MacroFault::kind("a truth value", value))
}

pub(super) fn choice(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let position = if truth(arguments.first().unwrap_or(&MacroValue::Unset))? { 1 } else { 2 };
    Ok(arguments.get(position).cloned().unwrap_or(MacroValue::Null))
}

pub(super) fn choose(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let position = real_argument(arguments, 0)?.round();
    let found = if position >= 1.0 { arguments.get(count(position)) } else { None };
    Ok(found.cloned().unwrap_or(MacroValue::Null))
}

pub(super) fn switch(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    for pair in arguments.chunks(2) {
        if let [condition, value] = pair
            && truth(condition)?
        {
            return Ok(value.clone());
        }
    }
    Ok(MacroValue::Null)
}
