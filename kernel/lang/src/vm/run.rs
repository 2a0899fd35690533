//! The loop over the instructions of a macro and of the functions it calls.
//!
//! Invariant: a call costs no stack of the computer, its caller waits in a list; short forms give exactly what
//! [`super::step`] gives, or are not taken.

use super::calls::{self, Frame};
use super::{End, State, fast, step};
use crate::bytecode::fast::WINDOW;
use crate::bytecode::{Code, Op, Relation, Slot, Target};
use crate::compile::Program;
use crate::fault::Fault;
use crate::host::Host;
use crate::value::Value;
use std::sync::Arc;

/// Why a macro ends early.
pub(super) enum Stop {
    /// A fault at an instruction.
    Fault(usize, Fault),
    /// A diagnostic of severity 8 was issued by the macro itself.
    Raised(usize),
}

#[inline]
pub(super) fn number(frame: &[Value], slot: Slot) -> Option<f64> {
    match frame.get(usize::from(slot)) {
        Some(Value::Real(number)) => Some(*number),
        _ => None,
    }
}

#[inline]
pub(super) fn get(frame: &[Value], slot: Slot) -> &Value {
    static UNSET: Value = Value::Unset;
    frame.get(usize::from(slot)).unwrap_or(&UNSET)
}

#[inline]
pub(super) fn set(frame: &mut [Value], slot: Slot, value: Value) {
    if let Some(register) = frame.get_mut(usize::from(slot)) {
        *register = value;
    }
}

#[inline]
pub(super) fn set_number(frame: &mut [Value], slot: Slot, number: f64) {
    if let Some(register) = frame.get_mut(usize::from(slot)) {
        put(register, number);
    }
}

/// Stores a number.
#[inline(always)]
pub(super) fn put(register: &mut Value, number: f64) {
    match register {
        Value::Real(old) => *old = number,
        Value::Text(_) | Value::Sequence(_) | Value::Array(_) => free(register, Value::Real(number)),
        _ => *register = Value::Real(number),
    }
}

/// Stores over a value that has memory to free.
#[cold]
#[inline(never)]
pub(super) fn free(register: &mut Value, value: Value) {
    *register = value;
}

/// What comes after an instruction.
pub(super) enum Next {
    /// The next instruction.
    Step,
    /// Another one.
    Jump(Target),
}

/// Why the loop pauses without a fault.
enum Pause {
    /// The macro is at its end.
    End,
    /// A call: register of the result, function, registers of the arguments.
    Call(Slot, u16, u16),
}

/// Runs a macro that has been entered, with everything it calls.
pub(super) fn run(program: &Program, state: &mut State, host: &mut dyn Host, frame: &mut Box<Frame>) -> End {
    let Some(mut code) = program.macros.get(usize::from(frame.index)).map(Arc::as_ref) else { return End::Error };
    let mut at = 0usize;
    loop {
        let end = match execute(state, host, code, &mut frame.registers, &mut at) {
            Ok(Pause::Call(to, callee, list)) => match calls::call(program, state, callee) {
                Ok((function, called)) => {
                    let waiting = std::mem::replace(frame, called);
                    let filled = calls::fill(function, &mut frame.registers, &waiting.registers, slots(code, list));
                    frame.wait(waiting, at, to);
                    (code, at) = (function, 0);
                    calls::begin(state, host, code);
                    match filled {
                        Ok(()) => continue,
                        Err(fault) => calls::stopped(state, host, code, Stop::Fault(0, fault)),
                    }
                }
                Err(fault) => calls::stopped(state, host, code, Stop::Fault(at, *fault)),
            },
            Ok(Pause::End) => calls::finished(state, host, code, &frame.registers),
            Err(stop) => calls::stopped(state, host, code, *stop),
        };
        // Back to the caller; with a used-up budget to the outermost macro.
        loop {
            let Some(caller) = frame.caller.take() else { return end };
            calls::leave(state, host, code);
            let ended = std::mem::replace(frame, caller);
            calls::give(code, &ended.registers, &mut frame.registers, ended.to);
            at = ended.at + 1;
            calls::put_back(state, ended);
            match program.macros.get(usize::from(frame.index)) {
                Some(caller) => code = caller,
                None => return End::Error,
            }
            if end != End::Budget {
                break;
            }
        }
    }
}

/// Runs until the macro calls a function or ends.
fn execute(
    state: &mut State,
    host: &mut dyn Host,
    code: &Code,
    frame: &mut [Value],
    position: &mut usize,
) -> Result<Pause, Box<Stop>> {
    let mut at = *position;
    loop {
        if let Some(window) = frame.first_chunk_mut::<WINDOW>() {
            (at, state.ticks) = fast::run(code, window, state.limits.elements, at, state.ticks);
        }
        match code.ops.get(at) {
            None | Some(Op::Return) => return Ok(Pause::End),
            Some(Op::CallMacro { to, callee, list }) => {
                *position = at;
                return Ok(Pause::Call(*to, *callee, *list));
            }
            Some(_) => {}
        }
        match step::step(state, host, code, frame, at) {
            Ok(Next::Step) => at += 1,
            Ok(Next::Jump(target)) => match fast::passed(at, target, state.ticks) {
                Some(left) => (at, state.ticks) = (usize::from(target), left),
                None => return Err(Box::new(Stop::Fault(at, used_up(state)))),
            },
            Err(stop) => return Err(Box::new(stop)),
        }
    }
}

#[cold]
#[inline(never)]
fn used_up(state: &mut State) -> Fault {
    match state.spend(usize::MAX) {
        Err(fault) => fault,
        Ok(()) => Fault::new(crate::diag::Number::TICKS, "the budget of steps is used up"),
    }
}

pub(super) fn slots(code: &Code, list: u16) -> &[Slot] {
    code.lists.get(usize::from(list)).map_or(&[], Vec::as_slice)
}

#[inline(never)]
pub(super) fn copy(frame: &mut [Value], to: Slot, a: Slot) {
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
