//! Conversion, tests and choice.

use super::{Context, count, number as real_argument, string};
use crate::fault::{Fault, Outcome};
use crate::ident;
use crate::value::{Kind, Record, Value};

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

pub(super) fn number(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    Ok(Value::Real(prefix(string(arguments, 0)?)))
}

fn as_real(value: &Value) -> Outcome<f64> {
    Ok(match value {
        Value::Unset => 0.0,
        Value::Real(number) => *number,
        Value::Logical(truth) => f64::from(u8::from(*truth)),
        Value::Keyword(code) => f64::from(*code),
        Value::Record(record) => f64::from(record.subclass),
        Value::Text(text) => prefix(text),
        Value::Code(index) | Value::Register(index) => f64::from(*index),
        Value::Sequence(elements) => match elements.first() {
            Some(first) => as_real(first)?,
            None => 0.0,
        },
        Value::Null | Value::Array(_) => return Err(Fault::kind("a value with a type", value)),
    })
}

pub(super) fn real(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    as_real(arguments.first().unwrap_or(&Value::Unset)).map(Value::Real)
}

pub(super) fn whole(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    as_real(arguments.first().unwrap_or(&Value::Unset)).map(|number| Value::Real(number.trunc()))
}

fn code(number: f64) -> Option<i32> {
    #[allow(clippy::cast_possible_truncation)]
    (0.0..=1e9).contains(&number.round()).then(|| number.round() as i32)
}

pub(super) fn minor(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let found = match arguments.first().unwrap_or(&Value::Unset) {
        Value::Text(name) => ident::minor_code(&name.trim().to_uppercase()),
        value => code(value.as_real().ok_or_else(|| Fault::kind("a number or a text", value))?),
    };
    Ok(found.map_or(Value::Null, Value::Keyword))
}

pub(super) fn major(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    if let Some(Value::Text(name)) = arguments.first() {
        return Ok(ident::record(&name.trim().to_uppercase()).map_or(Value::Null, Value::Record));
    }
    let first = real_argument(arguments, 0)?;
    let (class, subclass) = match arguments.get(1) {
        Some(_) => (code(first), code(real_argument(arguments, 1)?)),
        None => (Some(ident::MAJOR_CLASS), code(first)),
    };
    Ok(class.zip(subclass).map_or(Value::Null, |(class, subclass)| Value::Record(Record { class, subclass })))
}

pub(super) fn is(arguments: &[Value], kind: Kind) -> Value {
    Value::Logical(arguments.first().and_then(Value::kind) == Some(kind))
}

fn truth(value: &Value) -> Outcome<bool> {
    value.as_logical().ok_or_else(|| Fault::kind("a truth value", value))
}

pub(super) fn choice(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let position = if truth(arguments.first().unwrap_or(&Value::Unset))? { 1 } else { 2 };
    Ok(arguments.get(position).cloned().unwrap_or(Value::Null))
}

pub(super) fn choose(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let position = real_argument(arguments, 0)?.round();
    let found = if position >= 1.0 { arguments.get(count(position)) } else { None };
    Ok(found.cloned().unwrap_or(Value::Null))
}

pub(super) fn switch(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    for pair in arguments.chunks(2) {
        if let [condition, value] = pair
            && truth(condition)?
        {
            return Ok(value.clone());
        }
    }
    Ok(Value::Null)
}
