//! Entering and leaving macros.

use super::slots;
use super::slots::MacroStop;
use super::{MacroEnd, report, shown};
use crate::bytecode::fast::WINDOW;
use crate::bytecode::{CompiledMacro, Slot};
use crate::diag::DiagnosticNumber;
use crate::fault::MacroFault;
use crate::host::{MacroHost, TraceStep};
use crate::program::MacroProgram;
use crate::source::Span;
use crate::state::{MacroFrame, MacroState, typed};
use crate::value::{MacroValue, ValueType};
use std::sync::Arc;

/// Finds a function to be called and its registers.
#[inline]
pub(super) fn call<'p>(
    program: &'p MacroProgram,
    state: &mut MacroState,
    callee: u16,
) -> Result<(&'p CompiledMacro, Box<MacroFrame>), Box<MacroFault>> {
    state.spend(5)?;
    match program.macros.get(usize::from(callee)) {
        Some(code) => Ok((code, take(program, state, code, callee)?)),
        None => Err(Box::new(MacroFault::new(DiagnosticNumber::UNKNOWN_FUNCTION, "this function does not exist"))),
    }
}

/// Notes that a macro runs.
#[inline]
pub(super) fn begin(state: &mut MacroState, host: &mut dyn MacroHost, code: &CompiledMacro) {
    state.depth += 1;
    if !code.statements.is_empty() {
        host.trace(TraceStep::Entering(shown(code)));
        state.calls.names.push(code.name.clone());
    }
}

/// Notes that a macro has ended.
#[inline]
pub(super) fn leave(state: &mut MacroState, host: &mut dyn MacroHost, code: &CompiledMacro) {
    state.depth -= 1;
    if !code.statements.is_empty() {
        state.calls.names.pop();
        host.trace(TraceStep::Leaving(shown(code), state.calls.names.last().map(String::as_str)));
    }
}

/// Makes the registers of a macro free for its next run.
#[inline]
pub(super) fn put_back(state: &mut MacroState, frame: Box<MacroFrame>) {
    if let Some(place) = state.calls.frames.get_mut(usize::from(frame.index)) {
        *place = Some(frame);
    }
}

/// Result of the last run of a function.
pub(super) fn result<'a>(state: &'a MacroState, code: &CompiledMacro, index: u16) -> &'a MacroValue {
    static NULL: MacroValue = MacroValue::Null;
    match (code.signature.result, state.calls.frames.get(usize::from(index))) {
        (Some((slot, _)), Some(Some(frame))) => slots::get(&frame.registers, slot),
        _ => &NULL,
    }
}

/// Returns the result of a function to its caller.
#[inline]
pub(super) fn give(code: &CompiledMacro, frame: &[MacroValue], caller: &mut [MacroValue], to: Slot) {
    let Some((result, _)) = code.signature.result else { return slots::set(caller, to, MacroValue::Null) };
    match slots::number(frame, result) {
        Some(number) => slots::set_number(caller, to, number),
        None => slots::set(caller, to, slots::get(frame, result).clone()),
    }
}

/// The registers of a macro, ready for a run: constants filled in, variables unset, the result `$NULL`. A macro that is
/// running already is refused, and too many macros at once.
#[inline]
pub(super) fn take(
    program: &MacroProgram,
    state: &mut MacroState,
    code: &CompiledMacro,
    index: u16,
) -> Result<Box<MacroFrame>, Box<MacroFault>> {
    let mut frame = match state.calls.frames.get_mut(usize::from(index)) {
        // Short forms work on a window of fixed size, so every frame has that much more than it needs.
        Some(place) if state.depth < state.limits.depth => match place.take() {
            Some(frame) if frame.registers.len() == code.registers.count + WINDOW => frame,
            other => fresh(program, state, code, (index, other))?,
        },
        _ => fresh(program, state, code, (index, None))?,
    };
    clear(code, &mut frame.registers);
    Ok(frame)
}

/// Unsets the variables of a macro and its result.
#[inline(always)]
fn clear(code: &CompiledMacro, registers: &mut [MacroValue]) {
    for slot in &code.registers.locals {
        if let Some(register) = registers.get_mut(usize::from(*slot)) {
            slots::become_plain(register, MacroValue::Unset);
        }
    }
    if let Some(register) = code.signature.result.and_then(|(result, _)| registers.get_mut(usize::from(result))) {
        slots::become_plain(register, MacroValue::Null);
    }
}

/// The registers of a macro that has not run yet in this state, or did with other code.
#[cold]
#[inline(never)]
fn fresh(
    program: &MacroProgram,
    state: &mut MacroState,
    code: &CompiledMacro,
    (index, old): (u16, Option<Box<MacroFrame>>),
) -> Result<Box<MacroFrame>, Box<MacroFault>> {
    if state.depth >= state.limits.depth {
        let message = format!("more than {} macros are active", state.limits.depth);
        return Err(Box::new(MacroFault::new(DiagnosticNumber::DEPTH, message)));
    }
    let slot = usize::from(index);
    if old.is_none() && slot < state.calls.frames.len() {
        let name = program.macros.get(slot).map_or("the macro", |code| code.name.as_str());
        return Err(Box::new(MacroFault::new(DiagnosticNumber::RE_ENTERED, format!("{name} is already running"))));
    }
    if state.calls.frames.len() <= slot {
        state.calls.frames.resize_with(slot, || Some(Box::default()));
        state.calls.frames.push(None);
    }
    let mut registers = vec![MacroValue::Unset; code.registers.count + WINDOW];
    for (slot, value) in &code.registers.constants {
        slots::set(&mut registers, *slot, value.clone());
    }
    Ok(Box::new(MacroFrame { registers, index, ..MacroFrame::default() }))
}

/// Calls a function if nothing prevents it and it is not traced: `frame` becomes that of the function. `call`
/// is the place of the call, the register of the result, the function, and the list of the arguments.
#[inline(never)]
pub(super) fn quick_call<'p>(
    program: &'p MacroProgram,
    state: &mut MacroState,
    code: &CompiledMacro,
    frame: &mut Box<MacroFrame>,
    (at, to, callee, list): (usize, u8, u16, u16),
) -> Option<&'p CompiledMacro> {
    let function = program.macros.get(usize::from(callee))?.as_ref();
    let given = code.lists.get(usize::from(list))?;
    let place = state.calls.frames.get_mut(usize::from(callee))?;
    if !function.statements.is_empty() || state.depth >= state.limits.depth || state.ticks < 5 {
        return None;
    }
    let called = place.as_mut()?;
    let (registers, own) = (called.registers.as_mut_slice(), frame.registers.as_slice());
    if registers.len() != function.registers.count + WINDOW {
        return None;
    }
    for ((parameter, kind), from) in function.signature.parameters.iter().zip(given) {
        let (value, parameter) = (own.get(usize::from(*from))?, registers.get_mut(usize::from(*parameter))?);
        match (value, parameter) {
            (MacroValue::Real(number), parameter) if kind.is_none_or(|kind| kind == ValueType::Real) => {
                slots::put(parameter, *number)
            }
            (value, parameter) if kind.is_none_or(|kind| value.kind() == Some(kind)) => give_value(parameter, value),
            _ => return None,
        }
    }
    clear(function, registers);
    let called = place.take()?;
    let waiting = std::mem::replace(frame, called);
    frame.wait(waiting, at, Slot::from(to));
    (state.ticks, state.depth) = (state.ticks - 5, state.depth + 1);
    Some(function)
}

#[inline(never)]
fn give_value(register: &mut MacroValue, value: &MacroValue) {
    match (&*register, value) {
        (MacroValue::Text(old), MacroValue::Text(new)) if Arc::ptr_eq(old, new) => {}
        _ => *register = value.clone(),
    }
}

/// Ends a function that was called by another macro, if it is not traced and its result has its type: `frame` becomes
/// that of the caller. Returns the caller and the place of the call.
#[inline(never)]
pub(super) fn quick_return<'p>(
    program: &'p MacroProgram,
    state: &mut MacroState,
    code: &CompiledMacro,
    frame: &mut Box<MacroFrame>,
) -> Option<(&'p CompiledMacro, usize)> {
    let (result, kind) = code.signature.result?;
    let value = frame.registers.get(usize::from(result))?;
    let fits = match value {
        MacroValue::Null => true,
        value => kind.is_none_or(|kind| value.kind() == Some(kind)),
    };
    if !fits || !code.statements.is_empty() {
        return None;
    }
    let caller = program.macros.get(usize::from(frame.caller.as_ref()?.index))?.as_ref();
    let place = state.calls.frames.get_mut(usize::from(frame.index))?;
    let waiting = frame.caller.take()?;
    let ended = std::mem::replace(frame, waiting);
    match (slots::number(&ended.registers, result), frame.registers.get_mut(usize::from(ended.to))) {
        (Some(number), Some(register)) => slots::put(register, number),
        (None, Some(register)) => give_value(register, slots::get(&ended.registers, result)),
        (_, None) => {}
    }
    let at = ended.at;
    if let Some(other) = place.replace(ended) {
        drop(other);
    }
    state.depth -= 1;
    Some((caller, at))
}

/// Copies arguments from the registers `list` of the caller into the parameters of a function.
#[inline]
pub(super) fn fill(
    code: &CompiledMacro,
    frame: &mut [MacroValue],
    caller: &[MacroValue],
    given: &[Slot],
) -> Result<(), MacroFault> {
    for ((slot, kind), from) in code.signature.parameters.iter().zip(given) {
        match (slots::get(caller, *from), kind, frame.get_mut(usize::from(*slot))) {
            (MacroValue::Real(number), None | Some(ValueType::Real), Some(parameter)) => slots::put(parameter, *number),
            (value, None, Some(parameter)) => *parameter = value.clone(),
            (value, Some(kind), Some(parameter)) => *parameter = typed(value, *kind)?,
            (_, _, None) => {}
        }
    }
    Ok(())
}

/// Checks the result of a macro that came to its end.
#[inline]
pub(super) fn finished(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
) -> MacroEnd {
    match code.signature.result {
        Some((slot, Some(kind))) => result_typed(state, host, code, slots::get(frame, slot), kind),
        _ => MacroEnd::Normal,
    }
}

/// Reports why a macro stopped.
#[cold]
pub(super) fn stopped(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    stop: MacroStop,
) -> MacroEnd {
    let place = |at: usize| code.places.get(at).copied().unwrap_or_default();
    match stop {
        MacroStop::Fault(at, fault) => fail(state, host, code, place(at), fault),
        MacroStop::Raised(at) => {
            ended(state, host, code, place(at));
            MacroEnd::Error
        }
    }
}

/// Checks the type of a result.
fn result_typed(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    value: &MacroValue,
    kind: ValueType,
) -> MacroEnd {
    if matches!(value, MacroValue::Null) || value.kind() == Some(kind) {
        return MacroEnd::Normal;
    }
    let message = format!("the result is of type {}, not {}", value.kind_name(), kind.name());
    let place = code.places.last().copied().unwrap_or_default();
    fail(state, host, code, place, MacroFault::new(DiagnosticNumber::TYPED_STORE, message))
}

/// Reports a fault and ends the macro.
fn fail(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    place: Span,
    fault: MacroFault,
) -> MacroEnd {
    let budget = matches!(fault.number, DiagnosticNumber::TICKS | DiagnosticNumber::MEMORY);
    report(code, place, fault, 8, state, host);
    ended(state, host, code, place);
    if budget { MacroEnd::Budget } else { MacroEnd::Error }
}

fn ended(state: &mut MacroState, host: &mut dyn MacroHost, code: &CompiledMacro, place: Span) {
    let fault = MacroFault::new(DiagnosticNumber::TERMAC_GENERATED, "TERMAC generated due to error(s).");
    report(code, place, fault, 0, state, host);
}
