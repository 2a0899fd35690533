//! Texts, sequences, arrays, shared variables and declarations.
//!
//! Facts: reference macro-language.md 1.5, 1.7 and 2.

use super::slots::{get, slots};
use crate::bytecode::{CompiledMacro, NO_SLOT, SharedVariable, Slot};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::host::MacroHost;
use crate::state::{
    MacroState, detached, memory, pay_if_shared, pay_to_look, range, sequence_of, typed, weight, whole,
};
use crate::value::{Array, Elements, MacroValue, ValueType};
use std::sync::Arc;

fn outside(index: i64, length: usize) -> MacroFault {
    MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, format!("index {index} is outside 1 to {length}"))
}

pub(super) fn add(state: &MacroState, a: &MacroValue, b: &MacroValue) -> Outcome<MacroValue> {
    if matches!(a, MacroValue::Text(_)) || matches!(b, MacroValue::Text(_)) {
        return join(state, a, b);
    }
    let (x, y) = (a.as_real(), b.as_real());
    match (x, y) {
        (Some(x), Some(y)) if (x + y).is_finite() => Ok(MacroValue::Real(x + y)),
        (Some(_), Some(_)) => Err(MacroFault::new(DiagnosticNumber::BAD_ARITHMETIC, "the result is too large")),
        (Some(_), None) => Err(MacroFault::kind("a number", b)),
        _ => Err(MacroFault::kind("a number or a text", a)),
    }
}

pub(super) fn join(state: &MacroState, a: &MacroValue, b: &MacroValue) -> Outcome<MacroValue> {
    let x = a.as_text().ok_or_else(|| MacroFault::kind("a text", a))?;
    let y = b.as_text().ok_or_else(|| MacroFault::kind("a text", b))?;
    state.check_text(x.len() + y.len())?;
    let mut text = String::with_capacity(x.len() + y.len());
    text.push_str(x);
    text.push_str(y);
    Ok(MacroValue::text(text))
}

/// `+=`: appends to texts and sequences in place.
pub(super) fn add_to(state: &MacroState, frame: &mut [MacroValue], to: Slot, a: Slot) -> Outcome<()> {
    let value = get(frame, a).clone();
    let Some(target) = frame.get_mut(usize::from(to)) else { return Ok(()) };
    match (target, &value) {
        (MacroValue::Text(text), value) => {
            let more = value.as_text().ok_or_else(|| MacroFault::kind("a text", value))?;
            state.check_text(text.len() + more.len())?;
            Arc::make_mut(text).push_str(more);
        }
        (MacroValue::Sequence(elements), MacroValue::Sequence(more)) => {
            state.check_elements(elements.len() + more.len())?;
            Elements::make_mut(elements).extend(more.iter().cloned());
        }
        (MacroValue::Sequence(elements), value) => {
            if matches!(value, MacroValue::Array(_)) {
                return Err(MacroFault::kind("a single value", value));
            }
            state.check_elements(elements.len() + 1)?;
            Elements::make_mut(elements).push(value.clone());
        }
        (target @ MacroValue::Unset, MacroValue::Sequence(_)) => *target = value,
        (target, value) => *target = add(state, target, value)?,
    }
    Ok(())
}

/// Element of a sequence or one-dimensional array that is a number.
#[inline]
pub(super) fn element_number(value: &MacroValue, index: f64) -> Option<f64> {
    let elements = match value {
        MacroValue::Array(array) if array.sizes.len() == 1 => &array.elements,
        MacroValue::Sequence(elements) => elements.as_ref(),
        _ => return None,
    };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let position = if index >= 1.0 { index as usize - 1 } else { return None };
    match elements.get(position) {
        Some(MacroValue::Real(number)) => Some(*number),
        _ => None,
    }
}

/// Stores a number into a one-dimensional array of numbers or a sequence; false if it is neither.
#[inline]
pub(super) fn set_element_number(frame: &mut [MacroValue], to: Slot, index: f64, number: f64) -> bool {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let position = if index >= 1.0 { index as usize - 1 } else { return false };
    let Some(MacroValue::Array(array)) = frame.get_mut(usize::from(to)) else { return false };
    if array.sizes.len() != 1 {
        return false;
    }
    match array.elements.get_mut(position) {
        Some(MacroValue::Real(element)) => {
            *element = number;
            true
        }
        _ => false,
    }
}

pub(super) fn element(state: &MacroState, value: &MacroValue, indices: &[i64]) -> Outcome<MacroValue> {
    let index = indices.first().copied().unwrap_or(0);
    let position = usize::try_from(index.saturating_sub(1)).ok();
    match value {
        MacroValue::Array(array) => {
            let position = array_position(state, array, indices)?;
            Ok(array.elements.get(position).cloned().unwrap_or(MacroValue::Unset))
        }
        MacroValue::Sequence(elements) => {
            position.and_then(|at| elements.get(at)).cloned().ok_or_else(|| outside(index, elements.len()))
        }
        MacroValue::Text(text) => {
            if text.is_empty() && index == 1 {
                return Ok(MacroValue::text(" "));
            }
            let found = position.and_then(|at| text.chars().nth(at));
            found.map(|c| MacroValue::text(c.to_string())).ok_or_else(|| outside(index, text.chars().count()))
        }
        other => Err(MacroFault::kind("an array, a text or a sequence", other)),
    }
}

fn array_position(state: &MacroState, array: &Array, indices: &[i64]) -> Outcome<usize> {
    let with_channel;
    let full = if array.channel && indices.len() + 1 == array.sizes.len() {
        with_channel = indices.iter().copied().chain([i64::from(state.channel)]).collect::<Vec<_>>();
        &with_channel
    } else {
        indices
    };
    array.position(full).ok_or_else(|| {
        let sizes: Vec<String> = array.sizes.iter().map(u32::to_string).collect();
        let given: Vec<String> = full.iter().map(i64::to_string).collect();
        let message = format!("index ({}) is outside the array of size ({})", given.join(","), sizes.join(","));
        MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, message)
    })
}

pub(super) fn indices(code: &CompiledMacro, frame: &[MacroValue], list: u16) -> Outcome<Vec<i64>> {
    slots(code, list)
        .iter()
        .map(|slot| {
            let value = get(frame, *slot);
            value.as_real().map(whole).ok_or_else(|| MacroFault::kind("a number as index", value))
        })
        .collect()
}

/// Element by a list of registers; a list that begins with no register asks for the rest of an array.
pub(super) fn elements(
    state: &mut MacroState,
    code: &CompiledMacro,
    frame: &[MacroValue],
    value: &MacroValue,
    list: u16,
) -> Outcome<MacroValue> {
    let all = slots(code, list);
    if all.first() != Some(&NO_SLOT) {
        if let MacroValue::Text(_) = value {
            pay_to_look(state, value)?;
        }
        return element(state, value, &indices(code, frame, list)?);
    }
    let MacroValue::Array(array) = value else { return Ok(value.clone()) };
    let indices: Vec<i64> = all.iter().skip(1).map(|slot| get(frame, *slot).as_real().map_or(0, whole)).collect();
    let from = array_position(state, array, &indices)?;
    Ok(MacroValue::sequence(array.elements.get(from..).unwrap_or(&[]).to_vec()))
}

pub(super) fn set_element(
    state: &MacroState,
    frame: &mut [MacroValue],
    to: Slot,
    indices: &[i64],
    a: Slot,
) -> Outcome<()> {
    let value = get(frame, a).clone();
    match frame.get_mut(usize::from(to)) {
        Some(target) => set_in(state, target, indices, value),
        None => Ok(()),
    }
}

fn set_in(state: &MacroState, target: &mut MacroValue, indices: &[i64], value: MacroValue) -> Outcome<()> {
    match target {
        MacroValue::Array(array) => {
            let position = array_position(state, array, indices)?;
            if matches!(value, MacroValue::Sequence(_) | MacroValue::Array(_)) {
                return Err(MacroFault::kind("a single value", &value));
            }
            let value = match array.kind {
                Some(kind) => typed(&value, kind)?,
                None => value,
            };
            if let Some(element) = array.elements.get_mut(position) {
                *element = value;
            }
            Ok(())
        }
        MacroValue::Sequence(elements) => {
            let index = indices.first().copied().unwrap_or(0);
            if matches!(value, MacroValue::Sequence(_) | MacroValue::Array(_)) {
                return Err(MacroFault::kind("a single value", &value));
            }
            let length = elements.len();
            let place = usize::try_from(index.saturating_sub(1))
                .ok()
                .filter(|at| *at < length)
                .ok_or_else(|| outside(index, length))?;
            if let Some(element) = Elements::make_mut(elements).get_mut(place) {
                *element = value;
            }
            Ok(())
        }
        other => Err(MacroFault::kind("an array or a sequence", other)),
    }
}

pub(super) fn range_of(
    code: &CompiledMacro,
    frame: &[MacroValue],
    value: &MacroValue,
    list: u16,
) -> Outcome<MacroValue> {
    let mut ends = [None, None];
    for (end, slot) in ends.iter_mut().zip(slots(code, list)) {
        if *slot != NO_SLOT {
            let number = get(frame, *slot);
            *end = Some(number.as_real().map(whole).ok_or_else(|| MacroFault::kind("a number as index", number))?);
        }
    }
    let [from, to] = ends;
    range(value, from.unwrap_or(1), to.unwrap_or(i64::MAX))
}

pub(super) fn sequence(
    state: &MacroState,
    code: &CompiledMacro,
    frame: &[MacroValue],
    list: u16,
) -> Outcome<MacroValue> {
    sequence_of(state, slots(code, list).iter().map(|slot| get(frame, *slot)))
}

fn with_shared<R>(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    shared: SharedVariable,
    growth: Option<usize>,
    access: impl FnOnce(&mut MacroState, &mut MacroValue) -> R,
) -> Option<R> {
    match shared {
        SharedVariable::Object(index) => {
            let mut value = std::mem::take(state.object(index)?);
            let result = access(state, &mut value);
            *state.object(index)? = value;
            Some(result)
        }
        SharedVariable::Global(index) => {
            let (mut access, mut result) = (Some(access), None);
            host.global(index, growth, &mut |value| {
                if let Some(access) = access.take() {
                    result = Some(access(state, value));
                }
            });
            result
        }
    }
}

fn shared_of(code: &CompiledMacro, shared: u16) -> (SharedVariable, Option<ValueType>) {
    code.shared.get(usize::from(shared)).copied().unwrap_or((SharedVariable::Object(0), None))
}

/// A value for the other side of a GLOBAL variable; an OBJECT variable has only one side.
fn across(state: &mut MacroState, shared: SharedVariable, value: &MacroValue) -> Outcome<MacroValue> {
    match shared {
        SharedVariable::Global(_) => detached(state, value),
        SharedVariable::Object(_) => Ok(value.clone()),
    }
}

pub(super) fn read_shared(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    shared: u16,
) -> Outcome<MacroValue> {
    let (place, _) = shared_of(code, shared);
    let value = with_shared(state, host, place, None, |state, value| {
        pay_to_look(state, value).and_then(|()| across(state, place, value))
    });
    let value = value.unwrap_or(Ok(MacroValue::Unset))?;
    state.made(&value)?;
    Ok(value)
}

pub(super) fn write_shared(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    shared: u16,
    value: &MacroValue,
) -> Outcome<()> {
    let (place, kind) = shared_of(code, shared);
    let value = match kind {
        Some(kind) => typed(value, kind)?,
        None => value.clone(),
    };
    let value = across(state, place, &value)?;
    let growth = if let SharedVariable::Global(_) = place { weight(&value) } else { 0 };
    with_shared(state, host, place, Some(growth), |_, target| *target = value);
    Ok(())
}

pub(super) fn shared_elements(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
    shared: u16,
    list: u16,
) -> Outcome<MacroValue> {
    let (place, _) = shared_of(code, shared);
    let work = |state: &mut MacroState, value: &mut MacroValue| {
        let found = elements(state, code, frame, value, list)?;
        across(state, place, &found)
    };
    with_shared(state, host, place, None, work).unwrap_or(Ok(MacroValue::Null))
}

pub(super) fn set_shared_elements(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
    (shared, list): (u16, u16),
    a: Slot,
) -> Outcome<()> {
    let indices = indices(code, frame, list)?;
    let (place, _) = shared_of(code, shared);
    let value = across(state, place, get(frame, a))?;
    let growth = if let SharedVariable::Global(_) = place { weight(&value) } else { 0 };
    let work = |state: &mut MacroState, target: &mut MacroValue| {
        pay_if_shared(state, target)?;
        set_in(state, target, &indices, value)
    };
    with_shared(state, host, place, Some(growth), work).unwrap_or(Ok(()))
}

/// The first value of a declared variable.
pub(super) fn declared(
    state: &mut MacroState,
    code: &CompiledMacro,
    frame: &[MacroValue],
    declaration: u16,
) -> Outcome<MacroValue> {
    let Some(declaration) = code.declarations.get(usize::from(declaration)) else { return Ok(MacroValue::Unset) };
    let value = match (declaration.value, declaration.kind) {
        (Some(slot), Some(kind)) => typed(get(frame, slot), kind)?,
        (Some(slot), None) => get(frame, slot).clone(),
        (None, Some(kind)) => kind.initial(),
        (None, None) => MacroValue::Null,
    };
    if declaration.sizes.is_empty() && !declaration.channel {
        return Ok(value);
    }
    let mut sizes = Vec::new();
    let mut count = 1usize;
    for slot in &declaration.sizes {
        let size = get(frame, *slot).as_real().map_or(0, whole);
        let size = u32::try_from(size).ok().filter(|size| *size > 0);
        let size = size
            .ok_or_else(|| MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "the size of an array must be 1 or more"))?;
        count = count.saturating_mul(size as usize);
        sizes.push(size);
    }
    if declaration.channel {
        count = count.saturating_mul(state.channels as usize);
        sizes.push(state.channels);
    }
    state.check_elements(count)?;
    state.spend(count / 4)?;
    state.grow(memory::array(count));
    let array = Array { sizes, kind: declaration.kind, channel: declaration.channel, elements: vec![value; count] };
    Ok(MacroValue::Array(Box::new(array)))
}

/// Initialises a shared variable unless another macro has done so.
pub(super) fn declare_shared(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
    shared: u16,
    declaration: u16,
) -> Outcome<()> {
    let (place, _) = shared_of(code, shared);
    let value = declared(state, code, frame, declaration)?;
    let value = across(state, place, &value)?;
    let growth = if let SharedVariable::Global(_) = place { weight(&value) } else { 0 };
    with_shared(state, host, place, Some(growth), |_, target| {
        if matches!(target, MacroValue::Unset) {
            *target = value;
        }
    });
    Ok(())
}
