//! Cost of work on values: ranges and joins of values.

use super::{State, memory};
use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::value::{Array, Elements, Kind, Value};
use std::sync::Arc;

/// Whole part of an index.
pub(crate) fn whole(number: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation)]
    let whole = number as i64;
    whole
}

/// A value for a variable of a declared type.
pub(crate) fn typed(value: &Value, kind: Kind) -> Outcome<Value> {
    match value {
        Value::Unset => Ok(kind.initial()),
        value if value.kind() == Some(kind) => Ok(value.clone()),
        value => {
            let message = format!("the variable is of type {}, the value is {}", kind.name(), value.kind_name());
            Err(Fault::new(Number::TYPED_STORE, message))
        }
    }
}

/// Pays for the copying of a long value, so that the budget bounds the time.
pub(crate) fn pay(state: &mut State, value: &Value) -> Outcome<()> {
    match value {
        Value::Text(text) if text.len() >= 64 => state.spend(text.len() / 64),
        Value::Sequence(elements) if elements.len() >= 4 => state.spend(elements.len() / 4),
        _ => Ok(()),
    }
}

/// Pays for looking through a long value, or for copying an array.
pub(crate) fn pay_to_look(state: &mut State, value: &Value) -> Outcome<()> {
    match value {
        Value::Text(text) if text.len() >= 64 => state.spend(text.len() / 64),
        Value::Sequence(elements) if elements.len() >= 16 => state.spend(elements.len() / 16),
        Value::Array(array) => state.spend(array.elements.len() / 4),
        _ => Ok(()),
    }
}

/// Pays for writing a value as text.
pub(crate) fn pay_to_write(state: &mut State, value: &Value) -> Outcome<()> {
    match value {
        Value::Text(text) if text.len() >= 64 => state.spend(text.len() / 64),
        Value::Sequence(elements) => state.spend(elements.len() * 2),
        Value::Array(array) => state.spend(array.elements.len() * 2),
        _ => Ok(()),
    }
}

/// Pays for looking at every element, with the text of those that are texts.
pub(crate) fn pay_to_look_inside(state: &mut State, elements: &[Value]) -> Outcome<()> {
    state.spend(elements.len() / 4)?;
    let bytes: usize = elements.iter().filter_map(Value::as_text).map(str::len).sum();
    state.spend(bytes / 64)
}

/// Pays for the copy that changing a value in place needs when another variable also has the value.
pub(crate) fn pay_if_shared(state: &mut State, value: &Value) -> Outcome<()> {
    match value {
        Value::Text(text) if Arc::strong_count(text) > 1 => state.grow(memory::text(text.len())),
        Value::Sequence(held) if Elements::strong_count(held) > 1 => state.grow(memory::sequence(held.len())),
        _ => return Ok(()),
    }
    pay(state, value)
}

/// Pays for appended values.
pub(crate) fn pay_to_append(state: &mut State, target: &Value, more: &Value) -> Outcome<()> {
    match (target, more) {
        (Value::Text(_), Value::Text(more)) => state.grow(more.len()),
        (Value::Sequence(_), Value::Sequence(more)) => state.grow(more.len() * memory::ELEMENT),
        (Value::Sequence(_), _) => state.grow(memory::ELEMENT),
        _ => {}
    }
    pay(state, more)
}

/// Bytes that a value can add to its owner; a value without text or elements adds none.
pub(crate) fn weight(value: &Value) -> usize {
    if !matches!(value, Value::Text(_) | Value::Sequence(_) | Value::Array(_)) {
        return 0;
    }
    let mut scale = memory::Scale::default();
    scale.add(value);
    usize::try_from(scale.bytes).unwrap_or(usize::MAX)
}

/// A copy that shares no memory with the value: kernels must not notice the effect of other kernels on exchanged
/// values.
pub(crate) fn detached(state: &mut State, value: &Value) -> Outcome<Value> {
    let own = |value: &Value| match value {
        Value::Text(text) if text.len() >= 64 => Value::text(text.as_str()),
        other => other.clone(),
    };
    match value {
        Value::Text(text) if text.len() >= 64 => state.spend(text.len() / 64)?,
        Value::Sequence(elements) => pay_to_look_inside(state, elements)?,
        Value::Array(array) => pay_to_look_inside(state, &array.elements)?,
        _ => {}
    }
    Ok(match value {
        Value::Sequence(elements) => Value::sequence(elements.iter().map(own).collect()),
        Value::Array(array) => {
            let elements = array.elements.iter().map(own).collect();
            Value::Array(Box::new(Array { elements, sizes: array.sizes.clone(), ..**array }))
        }
        single => own(single),
    })
}

/// The elements or characters `from` to `to`, cut at the end; nothing if `to` lies before `from`.
///
/// # Errors
/// An index below 1, or a value without a range.
pub fn range(value: &Value, from: i64, to: i64) -> Outcome<Value> {
    if from < 1 || to < 0 {
        return Err(Fault::new(Number::OUT_OF_RANGE, "a range starts at 1 or later"));
    }
    let start = usize::try_from(from - 1).unwrap_or(usize::MAX);
    let count = usize::try_from(to.saturating_sub(from).saturating_add(1)).unwrap_or(0);
    match value {
        Value::Sequence(elements) => Ok(Value::sequence(elements.iter().skip(start).take(count).cloned().collect())),
        Value::Text(text) => {
            if text.is_ascii() {
                let start = start.min(text.len());
                let end = start.saturating_add(count).min(text.len());
                return Ok(Value::text(text.get(start..end).unwrap_or("")));
            }
            Ok(Value::text(text.chars().skip(start).take(count).collect::<String>()))
        }
        Value::Unset => Ok(Value::text("")),
        other => Err(Fault::kind("a text or a sequence", other)),
    }
}

/// Joins values into one flat sequence.
///
/// # Errors
/// There are too many elements.
pub fn sequence_of<'a>(state: &State, values: impl Iterator<Item = &'a Value>) -> Outcome<Value> {
    let mut elements = Vec::new();
    for value in values {
        match value {
            Value::Sequence(inner) => elements.extend(inner.iter().cloned()),
            Value::Array(_) => return Err(Fault::kind("a single value", value)),
            single => elements.push(single.clone()),
        }
        state.check_elements(elements.len())?;
    }
    Ok(Value::sequence(elements))
}
