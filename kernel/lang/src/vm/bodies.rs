//! Beginning and end of functions that are executed in registers of their callers.
//!
//! *Invariant:* nothing but registers of the body changes until its result is given; see [`Body`].

use super::window::Window;
use crate::bytecode::CompiledMacro;
use crate::bytecode::body::Body;
use crate::bytecode::fast::Near;
use crate::value::{MacroValue, ValueType};

/// A call whose body runs.
#[derive(Clone, Copy)]
pub(super) struct InlineCall<'p> {
    /// The caller, and its instruction.
    pub(super) code: &'p CompiledMacro,
    pub(super) at: usize,
    /// Ticks before the call.
    pub(super) ticks: u64,
    /// Register for the result.
    pub(super) to: Near,
    pub(super) body: &'p Body,
}

/// Prepares the registers of a body; false if the arguments do not have the types that the body is for.
#[inline(always)]
pub(super) fn begin(window: &mut Window, body: &Body) -> bool {
    let is_plain = body.typed.is_empty() & body.copied.is_empty() & body.cleared.is_empty() & !body.is_null_first;
    is_plain || prepare(window, body)
}

#[inline(never)]
fn prepare(window: &mut Window, body: &Body) -> bool {
    for (argument, kind) in &body.typed {
        if window.get(usize::from(*argument)).and_then(MacroValue::kind) != Some(*kind) {
            return false;
        }
    }
    for (parameter, argument) in &body.copied {
        copy(window, *parameter, *argument);
    }
    for variable in &body.cleared {
        if let Some(register) = window.get_mut(usize::from(*variable)) {
            super::slots::become_plain(register, MacroValue::Unset);
        }
    }
    if body.is_null_first
        && let Some(register) = window.get_mut(usize::from(body.result))
    {
        super::slots::become_plain(register, MacroValue::Null);
    }
    true
}

fn copy(window: &mut Window, to: Near, from: Near) {
    let Some(value) = window.get(usize::from(from)) else { return };
    let value = value.clone();
    if let Some(register) = window.get_mut(usize::from(to)) {
        *register = value;
    }
}

/// Returns the result of a body to its caller; false if it is not of its type.
#[inline(always)]
pub(super) fn give(window: &mut Window, running: &InlineCall<'_>) -> bool {
    match window.get(usize::from(running.body.result)) {
        Some(MacroValue::Real(number)) if matches!(running.body.kind, None | Some(ValueType::Real)) => {
            let number = *number;
            if let Some(register) = window.get_mut(usize::from(running.to)) {
                super::slots::put(register, number);
            }
            true
        }
        _ => give_any(window, running),
    }
}

#[inline(never)]
fn give_any(window: &mut Window, running: &InlineCall<'_>) -> bool {
    let Some(value) = window.get(usize::from(running.body.result)) else { return false };
    if !matches!(value, MacroValue::Null) && running.body.kind.is_some_and(|kind| value.kind() != Some(kind)) {
        return false;
    }
    let value = value.clone();
    if let Some(register) = window.get_mut(usize::from(running.to)) {
        *register = value;
    }
    true
}
