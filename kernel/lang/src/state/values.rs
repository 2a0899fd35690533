//! Cost of work on values: ranges and joins of values.

use super::{MacroState, memory};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::value::{Array, Elements, MacroValue, ValueType};
use std::sync::Arc;

/// Whole part of an index.
pub(crate) fn whole(number: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation)]
    let whole = number as i64;
    whole
}

/// A value for a variable of a declared type.
pub(crate) fn typed(value: &MacroValue, kind: ValueType) -> Outcome<MacroValue> {
    match value {
        MacroValue::Unset => Ok(kind.initial()),
        value if value.kind() == Some(kind) => Ok(value.clone()),
        value => {
            let message = format!("the variable is of type {}, the value is {}", kind.name(), value.kind_name());
            Err(MacroFault::new(DiagnosticNumber::TYPED_STORE, message))
        }
    }
}

/// Pays for the copying of a long value, so that the budget bounds the time.
pub(crate) fn pay(state: &mut MacroState, value: &MacroValue) -> Outcome<()> {
    match value {
        MacroValue::Text(text) if text.len() >= 64 => state.spend(text.len() / 64),
        MacroValue::Sequence(elements) if elements.len() >= 4 => state.spend(elements.len() / 4),
        _ => Ok(()),
    }
}

/// Pays for looking through a long value, or for copying an array.
pub(crate) fn pay_to_look(state: &mut MacroState, value: &MacroValue) -> Outcome<()> {
    match value {
        MacroValue::Text(text) if text.len() >= 64 => state.spend(text.len() / 64),
        MacroValue::Sequence(elements) if elements.len() >= 16 => state.spend(elements.len() / 16),
        MacroValue::Array(array) => state.spend(array.elements.len() / 4),
        _ => Ok(()),
    }
}

/// Pays for writing a value as text.
pub(crate) fn pay_to_write(state: &mut MacroState, value: &MacroValue) -> Outcome<()> {
    match value {
        MacroValue::Text(text) if text.len() >= 64 => state.spend(text.len() / 64),
        MacroValue::Sequence(elements) => state.spend(elements.len() * 2),
        MacroValue::Array(array) => state.spend(array.elements.len() * 2),
        _ => Ok(()),
    }
}

/// Pays for looking at every element, with the text of those that are texts.
pub(crate) fn pay_to_look_inside(state: &mut MacroState, elements: &[MacroValue]) -> Outcome<()> {
    state.spend(elements.len() / 4)?;
    let bytes: usize = elements.iter().filter_map(MacroValue::as_text).map(str::len).sum();
    state.spend(bytes / 64)
}

/// Pays for the copy that changing a value in place needs when another variable also has the value.
pub(crate) fn pay_if_shared(state: &mut MacroState, value: &MacroValue) -> Outcome<()> {
    match value {
        MacroValue::Text(text) if Arc::strong_count(text) > 1 => state.grow(memory::text(text.len())),
        MacroValue::Sequence(held) if Elements::strong_count(held) > 1 => state.grow(memory::sequence(held.len())),
        _ => return Ok(()),
    }
    pay(state, value)
}

/// Pays for appended values.
pub(crate) fn pay_to_append(state: &mut MacroState, target: &MacroValue, more: &MacroValue) -> Outcome<()> {
    match (target, more) {
        (MacroValue::Text(_), MacroValue::Text(more)) => state.grow(more.len()),
        (MacroValue::Sequence(_), MacroValue::Sequence(more)) => state.grow(more.len() * memory::ELEMENT),
        (MacroValue::Sequence(_), _) => state.grow(memory::ELEMENT),
        _ => {}
    }
    pay(state, more)
}

/// Bytes that a value can add to its owner; a value without text or elements adds none.
pub(crate) fn weight(value: &MacroValue) -> usize {
    if !matches!(value, MacroValue::Text(_) | MacroValue::Sequence(_) | MacroValue::Array(_)) {
        return 0;
    }
    let mut scale = memory::MemoryTally::default();
    scale.add(value);
    usize::try_from(scale.bytes).unwrap_or(usize::MAX)
}

/// A copy that shares no memory with the value: kernels must not notice the effect of other kernels on exchanged
/// values.
pub(crate) fn detached(state: &mut MacroState, value: &MacroValue) -> Outcome<MacroValue> {
    let own = |value: &MacroValue| match value {
        MacroValue::Text(text) if text.len() >= 64 => MacroValue::text(text.as_str()),
        other => other.clone(),
    };
    match value {
        MacroValue::Text(text) if text.len() >= 64 => state.spend(text.len() / 64)?,
        MacroValue::Sequence(elements) => pay_to_look_inside(state, elements)?,
        MacroValue::Array(array) => pay_to_look_inside(state, &array.elements)?,
        _ => {}
    }
    Ok(match value {
        MacroValue::Sequence(elements) => MacroValue::sequence(elements.iter().map(own).collect()),
        MacroValue::Array(array) => {
            let elements = array.elements.iter().map(own).collect();
            MacroValue::Array(Box::new(Array { elements, sizes: array.sizes.clone(), ..**array }))
        }
        single => own(single),
    })
}

/// The elements or characters `from` to `to`, cut at the end; nothing if `to` lies before `from`.
///
/// # Errors
/// An index below 1, or a value without a range.
pub fn range(value: &MacroValue, from: i64, to: i64) -> Outcome<MacroValue> {
    if from < 1 || to < 0 {
        return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "a range starts at 1 or later"));
    }
    let start = usize::try_from(from - 1).unwrap_or(usize::MAX);
    let count = usize::try_from(to.saturating_sub(from).saturating_add(1)).unwrap_or(0);
    match value {
        MacroValue::Sequence(elements) => {
            Ok(MacroValue::sequence(elements.iter().skip(start).take(count).cloned().collect()))
        }
        MacroValue::Text(text) => {
            if text.is_ascii() {
                let start = start.min(text.len());
                let end = start.saturating_add(count).min(text.len());
                return Ok(MacroValue::text(text.get(start..end).unwrap_or("")));
            }
            Ok(MacroValue::text(text.chars().skip(start).take(count).collect::<String>()))
        }
        MacroValue::Unset => Ok(MacroValue::text("")),
        other => Err(MacroFault::kind("a text or a sequence", other)),
    }
}

/// Joins values into one flat sequence.
///
/// # Errors
/// There are too many elements.
pub fn sequence_of<'a>(state: &MacroState, values: impl Iterator<Item = &'a MacroValue>) -> Outcome<MacroValue> {
    let mut elements = Vec::new();
    for value in values {
        match value {
            MacroValue::Sequence(inner) => elements.extend(inner.iter().cloned()),
            MacroValue::Array(_) => return Err(MacroFault::kind("a single value", value)),
            single => elements.push(single.clone()),
        }
        state.check_elements(elements.len())?;
    }
    Ok(MacroValue::sequence(elements))
}
