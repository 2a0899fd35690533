//! Short forms on values that are not numbers.
//!
//! *Invariant:* everything here has the effect and the cost of the full instruction, or does nothing and reports that.
//! It takes light values only: single values whose texts are too short to cost a step. Memory of texts and sequences
//! that no other value shares is used again.

use super::window::{Window, passed, position};
use crate::bytecode::fast::{Fast, Near};
use crate::bytecode::{CompiledMacro, Relation, Slot};
use crate::func::{BuiltInFunction, EvaluationMethod};
use crate::state::{MacroState, memory};
use crate::value::{Array, Elements, MacroValue, ValueType, padded};
use std::sync::Arc;

/// Bytes of a text from which on looking at it or copying it costs steps.
const LONG: usize = 64;

/// Takes one short form on values that may not be numbers. Returns the next instruction and the remaining ticks; if
/// that is the same instruction, nothing was done.
#[allow(clippy::too_many_lines, reason = "one arm per form")]
#[inline(never)]
pub(super) fn step(
    (code, forms): (&CompiledMacro, &[Fast]),
    state: &mut MacroState,
    window: &mut Window,
    at: usize,
    ticks: u64,
) -> (usize, u64) {
    let not_taken = (at, ticks);
    let Some(form) = forms.get(at) else { return not_taken };
    macro_rules! did {
        ($outcome:expr) => {
            if $outcome.is_some() { (at + 1, ticks) } else { not_taken }
        };
    }
    macro_rules! paid {
        ($left:expr) => {
            match $left {
                Some(left) => (at + 1, left),
                None => not_taken,
            }
        };
    }
    macro_rules! unless {
        ($holds:expr, $target:expr) => {
            match $holds {
                Some(true) => (at + 1, ticks),
                Some(false) => match passed(at, $target, ticks) {
                    Some(left) => (usize::from($target), left),
                    None => not_taken,
                },
                None => not_taken,
            }
        };
    }
    macro_rules! number {
        ($register:expr) => {
            match window.get(usize::from($register)) {
                Some(MacroValue::Real(number)) => *number,
                _ => return not_taken,
            }
        };
    }
    match *form {
        Fast::Move { to, a } => did!(move_any(window, to, a)),
        Fast::MoveTyped { to, a, kind } => did!(move_light(window, to, a, Some(kind))),
        Fast::Read { to, home, shared } if state.is_at_home(shared) => did!(move_light(window, to, home, None)),
        Fast::Write { home, shared, a } if state.is_at_home(shared) => did!(move_light(window, home, a, None)),
        Fast::WriteTyped { home, shared, a, kind } if state.is_at_home(shared) => {
            did!(move_light(window, home, a, Some(kind)))
        }
        Fast::Power { to, a, b } => {
            let result = super::slots::power(number!(a), number!(b));
            did!(stored(window, to, result))
        }
        Fast::Math { to, a, function } => {
            let result = math(&code.functions, function, number!(a));
            did!(result.and_then(|result| stored(window, to, result)))
        }
        Fast::Add { to, a, b } | Fast::Join { to, a, b } => paid!(join(state, window, (to, a, b), ticks)),
        Fast::AddTo { to, a } => did!(append(state, window, to, a)),
        Fast::Sequence { to, list } => {
            let slots = code.lists.get(usize::from(list)).map_or(&[][..], Vec::as_slice);
            paid!(sequence(state, window, to, slots, ticks))
        }
        Fast::Not { to, a } => did!(truth(window, a).and_then(|truth| put_truth(window, to, !truth))),
        Fast::Truth { to, a } => did!(truth(window, a).and_then(|truth| put_truth(window, to, truth))),
        Fast::Compare { relation, to, a, b } => {
            did!(compared(window, relation, a, b).and_then(|holds| put_truth(window, to, holds)))
        }
        Fast::Element { to, array, index } => did!(element(window, to, array, (number!(index), None))),
        Fast::Cell { to, array, row, column } => {
            did!(element(window, to, array, (number!(row), Some(number!(column)))))
        }
        Fast::SetElement { array, index, a } => did!(set_element(window, array, (number!(index), None), a)),
        Fast::SetCell { array, row, column, a } => {
            did!(set_element(window, array, (number!(row), Some(number!(column))), a))
        }
        Fast::UnlessLess { a, b, target } => unless!(compared(window, Relation::Less, a, b), target),
        Fast::UnlessLessEqual { a, b, target } => unless!(compared(window, Relation::LessEqual, a, b), target),
        Fast::UnlessGreater { a, b, target } => unless!(compared(window, Relation::Greater, a, b), target),
        Fast::UnlessGreaterEqual { a, b, target } => unless!(compared(window, Relation::GreaterEqual, a, b), target),
        Fast::IfWhen { a, b, target } => unless!(same(window, a, b).map(|equal| !equal), target),
        Fast::DoStart { variable, end, step, target } => {
            let (value, last, step) = (number!(variable), number!(end), number!(step));
            let passes = if step == 0.0 { None } else { Some(!super::slots::past(value, last, step)) };
            unless!(passes, target)
        }
        _ => not_taken,
    }
}

/// Stores a number if it exists.
#[inline]
fn stored(window: &mut Window, to: Near, number: f64) -> Option<()> {
    let register = window.get_mut(usize::from(to)).filter(|_| number.is_finite())?;
    super::slots::put(register, number);
    Some(())
}

#[inline]
fn truth(window: &Window, a: Near) -> Option<bool> {
    match window.get(usize::from(a))? {
        MacroValue::Logical(truth) => Some(*truth),
        _ => None,
    }
}

#[inline]
fn put_truth(window: &mut Window, to: Near, truth: bool) -> Option<()> {
    match window.get_mut(usize::from(to))? {
        MacroValue::Logical(old) => *old = truth,
        other => *other = MacroValue::Logical(truth),
    }
    Some(())
}

/// Compares two registers.
#[inline(never)]
pub(super) fn compared(window: &Window, relation: Relation, a: Near, b: Near) -> Option<bool> {
    values_related(relation, window.get(usize::from(a))?, window.get(usize::from(b))?)
}

/// Tells whether a value is a single one that can be copied and compared for nothing.
#[inline]
fn is_light(value: &MacroValue) -> bool {
    match value {
        MacroValue::Text(text) => text.len() < LONG,
        MacroValue::Sequence(_) | MacroValue::Array(_) => false,
        _ => true,
    }
}

/// Replaces a value by a copy of another one.
#[inline]
fn overwrite(target: &mut MacroValue, value: &MacroValue) {
    match (&*target, value) {
        (MacroValue::Text(old), MacroValue::Text(new)) if Arc::ptr_eq(old, new) => {}
        _ => *target = value.clone(),
    }
}

/// Copies a register.
#[inline]
fn copied(window: &mut Window, to: Near, a: Near) -> Option<()> {
    if let (Some(MacroValue::Text(old)), Some(MacroValue::Text(new))) =
        (window.get(usize::from(to)), window.get(usize::from(a)))
        && Arc::ptr_eq(old, new)
    {
        return Some(());
    }
    let value = window.get(usize::from(a))?.clone();
    *window.get_mut(usize::from(to))? = value;
    Some(())
}

/// Moves a value that is not an array.
#[inline]
fn move_any(window: &mut Window, to: Near, a: Near) -> Option<()> {
    match window.get(usize::from(a))? {
        MacroValue::Array(_) => None,
        _ => copied(window, to, a),
    }
}

/// Moves a light value, of one type if that is given.
#[inline]
fn move_light(window: &mut Window, to: Near, a: Near, kind: Option<ValueType>) -> Option<()> {
    let value = window.get(usize::from(a))?;
    if !is_light(value) || kind.is_some_and(|kind| value.kind() != Some(kind)) {
        return None;
    }
    copied(window, to, a)
}

/// Element of a sequence or an array that is a light value.
#[inline]
fn element(window: &mut Window, to: Near, array: Near, (row, column): (f64, Option<f64>)) -> Option<()> {
    let value = look(window, array, (row, column)).filter(|value| is_light(value))?;
    if let (MacroValue::Text(new), Some(MacroValue::Text(old))) = (value, window.get(usize::from(to)))
        && Arc::ptr_eq(old, new)
    {
        return Some(());
    }
    let value = value.clone();
    *window.get_mut(usize::from(to))? = value;
    Some(())
}

/// The element of a sequence or an array.
#[inline]
fn look(window: &Window, array: Near, (row, column): (f64, Option<f64>)) -> Option<&MacroValue> {
    match (window.get(usize::from(array))?, column) {
        (MacroValue::Array(array), Some(column)) => array.elements.get(cell(array, row, column)?),
        (MacroValue::Array(array), None) if array.sizes.len() == 1 => array.elements.get(position(row)),
        (MacroValue::Sequence(elements), None) => elements.get(position(row)),
        _ => None,
    }
}

/// Position in an array with two indices.
#[inline(always)]
pub(super) fn cell(array: &Array, row: f64, column: f64) -> Option<usize> {
    let [rows, columns] = *array.sizes.as_slice() else { return None };
    let (row, column) = (position(row), position(column));
    if row < rows as usize && column < columns as usize { Some(row * columns as usize + column) } else { None }
}

/// Stores a light value into an array, or into a sequence that no other value shares.
#[inline(never)]
fn set_element(window: &mut Window, array: Near, indices: (f64, Option<f64>), a: Near) -> Option<()> {
    let value = window.get(usize::from(a))?;
    if !is_light(value) || !takes(window.get(usize::from(array))?, value) {
        return None;
    }
    let value = value.clone();
    let (row, column) = indices;
    let element = match (window.get_mut(usize::from(array))?, column) {
        (MacroValue::Array(array), Some(column)) => {
            let at = cell(array, row, column)?;
            array.elements.get_mut(at)?
        }
        (MacroValue::Array(array), None) if array.sizes.len() == 1 => array.elements.get_mut(position(row))?,
        (MacroValue::Sequence(elements), None) => Elements::get_mut(elements)?.get_mut(position(row))?,
        _ => return None,
    };
    *element = value;
    Some(())
}

fn takes(target: &MacroValue, value: &MacroValue) -> bool {
    match target {
        MacroValue::Array(array) => array.kind.is_none_or(|kind| value.kind() == Some(kind)),
        MacroValue::Sequence(_) => true,
        _ => false,
    }
}

/// Equality of light values of one type that are not both numbers.
#[inline(never)]
pub(super) fn equal(a: &MacroValue, b: &MacroValue) -> Option<bool> {
    match (a, b) {
        (MacroValue::Logical(a), MacroValue::Logical(b)) => Some(a == b),
        (MacroValue::Text(a), MacroValue::Text(b)) => equal_texts(a, b),
        _ if is_light(a) && is_light(b) => a.equals(b),
        _ => None,
    }
}

/// Equality of short texts; the same memory holds the same text.
#[inline]
fn equal_texts(a: &Arc<String>, b: &Arc<String>) -> Option<bool> {
    let (x, y) = (a.as_bytes(), b.as_bytes());
    if x.len() >= LONG || y.len() >= LONG {
        return None;
    }
    if x.len() != y.len() {
        return Some(padded(a, b).is_eq());
    }
    Some(Arc::ptr_eq(a, b) || same_bytes(x, y))
}

/// Equality of bytes of one length, a few of which are compared faster in place than by a call.
#[inline]
fn same_bytes(x: &[u8], y: &[u8]) -> bool {
    match (x.first_chunk::<8>(), y.first_chunk::<8>(), x.first_chunk::<4>(), y.first_chunk::<4>()) {
        (Some(a), Some(b), ..) if x.len() <= 16 => a == b && x.last_chunk::<8>() == y.last_chunk::<8>(),
        (None, None, Some(a), Some(b)) => a == b && x.last_chunk::<4>() == y.last_chunk::<4>(),
        (None, None, None, None) => x.iter().zip(y).all(|(a, b)| a == b),
        _ => x == y,
    }
}

/// Compares values that are not both numbers.
#[inline]
fn related(relation: Relation, a: &MacroValue, b: &MacroValue) -> Option<bool> {
    match relation {
        Relation::Equal => equal(a, b),
        Relation::NotEqual => equal(a, b).map(|equal| !equal),
        _ => ordered(relation, a, b),
    }
}

#[inline(never)]
fn ordered(relation: Relation, a: &MacroValue, b: &MacroValue) -> Option<bool> {
    if !is_light(a) || !is_light(b) {
        return None;
    }
    let order = a.order(b)?;
    Some(match relation {
        Relation::Less => order.is_lt(),
        Relation::LessEqual => order.is_le(),
        Relation::Greater => order.is_gt(),
        _ => order.is_ge(),
    })
}

/// Compares an element with a register.
#[inline(never)]
pub(super) fn element_related(window: &Window, relation: Relation, array: Near, index: f64, b: Near) -> Option<bool> {
    let element = match window.get(usize::from(array))? {
        MacroValue::Sequence(elements) => elements.get(position(index))?,
        MacroValue::Array(array) if array.sizes.len() == 1 => array.elements.get(position(index))?,
        _ => return None,
    };
    values_related(relation, element, window.get(usize::from(b))?)
}

/// Compares an element with two indices with a register.
#[inline(never)]
pub(super) fn cell_related(
    window: &Window,
    relation: Relation,
    array: Near,
    (row, column): (f64, f64),
    b: Near,
) -> Option<bool> {
    let MacroValue::Array(array) = window.get(usize::from(array))? else { return None };
    let element = array.elements.get(cell(array, row, column)?)?;
    values_related(relation, element, window.get(usize::from(b))?)
}

#[inline(always)]
fn values_related(relation: Relation, a: &MacroValue, b: &MacroValue) -> Option<bool> {
    match (a, b) {
        (MacroValue::Real(a), MacroValue::Real(b)) => Some(super::slots::relate(relation, *a, *b)),
        (a, b) => related(relation, a, b),
    }
}

/// Equality of light values, for a CASE.
#[inline]
fn same(window: &Window, a: Near, b: Near) -> Option<bool> {
    let (a, b) = (window.get(usize::from(a))?, window.get(usize::from(b))?);
    if is_light(a) && is_light(b) { Some(a.equals(b) == Some(true)) } else { None }
}

/// Joins two texts; returns the remaining ticks.
#[inline(never)]
fn join(state: &mut MacroState, window: &mut Window, (to, a, b): (Near, Near, Near), ticks: u64) -> Option<u64> {
    let (MacroValue::Text(x), MacroValue::Text(y)) = (window.get(usize::from(a))?, window.get(usize::from(b))?) else {
        return None;
    };
    let length = x.len() + y.len();
    let left = ticks.checked_sub(length as u64 / 64)?;
    if length > state.limits.text || !state.grows(memory::text(length)) {
        return None;
    }
    if to == b {
        let text = [x.as_str(), y.as_str()].concat();
        *window.get_mut(usize::from(to))? = MacroValue::text(text);
        return Some(left);
    }
    // The text that was there before gives its memory.
    let mut text = match std::mem::take(window.get_mut(usize::from(to))?) {
        MacroValue::Text(text) => text,
        _ => Arc::default(),
    };
    if to == a {
        let y = window.get(usize::from(b)).and_then(MacroValue::as_text).unwrap_or_default();
        match Arc::get_mut(&mut text) {
            Some(own) => own.push_str(y),
            None => text = Arc::new([text.as_str(), y].concat()),
        }
    } else {
        let part = |slot: Near| window.get(usize::from(slot)).and_then(MacroValue::as_text).unwrap_or_default();
        let (x, y) = (part(a), part(b));
        match Arc::get_mut(&mut text) {
            Some(own) if own.capacity() <= 4 * LONG + 2 * length => {
                own.clear();
                own.push_str(x);
                own.push_str(y);
            }
            _ => text = Arc::new([x, y].concat()),
        }
    }
    *window.get_mut(usize::from(to))? = MacroValue::Text(text);
    Some(left)
}

/// Appends to a text or a sequence that no other value shares.
#[inline(never)]
fn append(state: &mut MacroState, window: &mut Window, to: Near, a: Near) -> Option<()> {
    let value = window.get(usize::from(a))?;
    if to == a || !is_light(value) {
        return None;
    }
    let (text, sequence) = (state.limits.text, state.limits.elements);
    match (window.get(usize::from(to))?, value) {
        (MacroValue::Text(own), MacroValue::Text(more)) if own.len() + more.len() <= text => {}
        (MacroValue::Sequence(own), _) if own.len() < sequence => {}
        _ => return None,
    }
    let value = value.clone();
    match (window.get_mut(usize::from(to))?, value) {
        (MacroValue::Text(own), MacroValue::Text(more)) => {
            let own = Arc::get_mut(own).filter(|_| state.grows(more.len()))?;
            own.push_str(&more);
        }
        (MacroValue::Sequence(own), value) => {
            let own = Elements::get_mut(own).filter(|_| state.grows(memory::ELEMENT))?;
            own.push(value);
        }
        _ => return None,
    }
    Some(())
}

/// Appends a number to a sequence that no other value shares; false if it cannot grow like this.
#[inline(never)]
pub(super) fn push(state: &mut MacroState, elements: &mut Elements, number: f64) -> bool {
    let room = elements.len() < state.limits.elements;
    match Elements::get_mut(elements) {
        Some(elements) if room && state.grows(memory::ELEMENT) => {
            elements.push(MacroValue::Real(number));
            true
        }
        _ => false,
    }
}

/// Makes a sequence of single values; returns the remaining ticks.
#[inline(never)]
fn sequence(state: &mut MacroState, window: &mut Window, to: Near, slots: &[Slot], ticks: u64) -> Option<u64> {
    let left = ticks.checked_sub(slots.len() as u64 / 4)?;
    let single = |slot: &Slot| {
        !matches!(window.get(usize::from(*slot)), None | Some(MacroValue::Sequence(_) | MacroValue::Array(_)))
    };
    if slots.len() > state.limits.elements || !slots.iter().all(single) || !state.grows(memory::sequence(slots.len())) {
        return None;
    }
    // A sequence of the same length that was there before gives its memory. It is none of the elements.
    if let Some(MacroValue::Sequence(old)) = window.get(usize::from(to))
        && old.len() == slots.len()
        && old.capacity() <= 2 * slots.len() + 8
        && Elements::strong_count(old) == 1
    {
        let mut target = std::mem::take(window.get_mut(usize::from(to))?);
        if let MacroValue::Sequence(old) = &mut target
            && let Some(elements) = Elements::get_mut(old)
        {
            for (element, slot) in elements.iter_mut().zip(slots) {
                overwrite(element, window.get(usize::from(*slot)).unwrap_or(&MacroValue::Unset));
            }
        }
        *window.get_mut(usize::from(to))? = target;
        return Some(left);
    }
    let elements = slots.iter().filter_map(|slot| window.get(usize::from(*slot)).cloned()).collect();
    *window.get_mut(usize::from(to))? = MacroValue::sequence(elements);
    Some(left)
}

/// A function of one number.
#[inline]
fn math(functions: &[&'static BuiltInFunction], function: u16, value: f64) -> Option<f64> {
    match functions.get(usize::from(function))?.way {
        EvaluationMethod::Math(compute) => compute(value),
        _ => None,
    }
}

/// A function of two numbers.
#[inline(never)]
pub(super) fn pair(functions: &[&'static BuiltInFunction], function: u16, a: f64, b: f64) -> Option<f64> {
    match functions.get(usize::from(function))?.way {
        EvaluationMethod::Pair(compute, _) => compute(a, b),
        _ => None,
    }
}
