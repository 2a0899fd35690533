//! Values in the slots of a frame, and the ends of instructions and macros.

use crate::bytecode::{CompiledMacro, Relation, Slot, Target};
use crate::fault::MacroFault;
use crate::value::MacroValue;

/// Why a macro ends early.
pub(super) enum MacroStop {
    /// A fault at an instruction.
    Fault(usize, MacroFault),
    /// A diagnostic of severity 8 was issued by the macro itself.
    Raised(usize),
}

#[inline]
pub(super) fn number(frame: &[MacroValue], slot: Slot) -> Option<f64> {
    match frame.get(usize::from(slot)) {
        Some(MacroValue::Real(number)) => Some(*number),
        _ => None,
    }
}

#[inline]
pub(super) fn get(frame: &[MacroValue], slot: Slot) -> &MacroValue {
    static UNSET: MacroValue = MacroValue::Unset;
    frame.get(usize::from(slot)).unwrap_or(&UNSET)
}

#[inline]
pub(super) fn set(frame: &mut [MacroValue], slot: Slot, value: MacroValue) {
    if let Some(register) = frame.get_mut(usize::from(slot)) {
        *register = value;
    }
}

#[inline]
pub(super) fn set_number(frame: &mut [MacroValue], slot: Slot, number: f64) {
    if let Some(register) = frame.get_mut(usize::from(slot)) {
        put(register, number);
    }
}

/// Stores a number. The previous value is mostly a number too, so all other cases are kept out of the fast path.
#[inline(always)]
pub(super) fn put(register: &mut MacroValue, number: f64) {
    if !matches!(register, MacroValue::Real(_)) {
        become_number(register);
    }
    if let MacroValue::Real(old) = register {
        *old = number;
    }
}

#[cold]
#[inline(never)]
fn become_number(register: &mut MacroValue) {
    become_plain(register, MacroValue::Real(0.0));
}

/// Replaces a value by one that holds no memory. Most of those that were there before do not hold any either.
#[inline(always)]
pub(super) fn become_plain(register: &mut MacroValue, value: MacroValue) {
    match register {
        MacroValue::Text(_) | MacroValue::Sequence(_) | MacroValue::Array(_) => replace(register, value),
        _ => std::mem::forget(std::mem::replace(register, value)),
    }
}

/// Replaces a value that may have to give memory back.
#[inline(never)]
pub(super) fn replace(register: &mut MacroValue, value: MacroValue) {
    *register = value;
}

/// The successor of an instruction.
pub(super) enum NextInstruction {
    /// The next instruction.
    Step,
    /// Another one.
    Jump(Target),
}

pub(super) fn slots(code: &CompiledMacro, list: u16) -> &[Slot] {
    code.lists.get(usize::from(list)).map_or(&[], Vec::as_slice)
}

#[inline(never)]
pub(super) fn copy(frame: &mut [MacroValue], to: Slot, a: Slot) {
    let value = get(frame, a).clone();
    set(frame, to, value);
}

pub(super) fn past(value: f64, last: f64, step: f64) -> bool {
    if step > 0.0 { value > last } else { value < last }
}

/// Compares two numbers without a branch.
#[inline]
pub(super) fn relate(relation: Relation, a: f64, b: f64) -> bool {
    let wanted = match relation {
        Relation::Equal => 0b010u8,
        Relation::NotEqual => 0b101,
        Relation::Less => 0b001,
        Relation::LessEqual => 0b011,
        Relation::Greater => 0b100,
        Relation::GreaterEqual => 0b110,
    };
    wanted & (u8::from(a < b) | u8::from(a == b) << 1 | u8::from(a > b) << 2) != 0
}

/// A number to the power of another number.
#[inline(never)]
pub(super) fn power(a: f64, b: f64) -> f64 {
    if b == 2.0 { a * a } else { libm::pow(a, b) }
}
