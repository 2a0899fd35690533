//! The loop over the instructions of a macro and of the functions it calls.
//!
//! *Invariant:* a call costs no stack of the computer, its caller waits in a list; short forms have exactly the results
//! of [`super::step`], or are not taken.

use super::calls;
use super::fast::{self, Place};
use super::{End, step, weigh};
use crate::bytecode::{Code, Op, Relation, Slot, Target};
use crate::fault::Fault;
use crate::host::Host;
use crate::program::Program;
use crate::state::{Frame, State};
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

/// Stores a number. The previous value is mostly a number too, so all other cases are kept out of the fast path.
#[inline(always)]
pub(super) fn put(register: &mut Value, number: f64) {
    if !matches!(register, Value::Real(_)) {
        become_number(register);
    }
    if let Value::Real(old) = register {
        *old = number;
    }
}

#[cold]
#[inline(never)]
fn become_number(register: &mut Value) {
    become_plain(register, Value::Real(0.0));
}

/// Replaces a value by one that holds no memory. Most of those that were there before do not hold any either.
#[inline(always)]
pub(super) fn become_plain(register: &mut Value, value: Value) {
    match register {
        Value::Text(_) | Value::Sequence(_) | Value::Array(_) => replace(register, value),
        _ => std::mem::forget(std::mem::replace(register, value)),
    }
}

/// Replaces a value that may have to give memory back.
#[inline(never)]
pub(super) fn replace(register: &mut Value, value: Value) {
    *register = value;
}

/// The successor of an instruction.
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
    let Some(code) = program.macros.get(usize::from(frame.index)).map(Arc::as_ref) else { return End::Error };
    let mut place = Place { code, frame, at: 0 };
    loop {
        let end = match execute(program, state, host, &mut place) {
            Ok(Pause::Call(to, callee, list)) => match calls::call(program, state, callee) {
                Ok((function, called)) => {
                    let waiting = std::mem::replace(place.frame, called);
                    let given = slots(place.code, list);
                    let filled = calls::fill(function, &mut place.frame.registers, &waiting.registers, given);
                    place.frame.wait(waiting, place.at, to);
                    (place.code, place.at) = (function, 0);
                    calls::begin(state, host, function);
                    match filled {
                        Ok(()) => continue,
                        Err(fault) => calls::stopped(state, host, function, Stop::Fault(0, fault)),
                    }
                }
                Err(fault) => calls::stopped(state, host, place.code, Stop::Fault(place.at, *fault)),
            },
            Ok(Pause::End) => calls::finished(state, host, place.code, &place.frame.registers),
            Err(stop) => calls::stopped(state, host, place.code, *stop),
        };
        // Back to the caller; with a used-up budget to the outermost macro.
        loop {
            let Some(caller) = place.frame.caller.take() else { return end };
            calls::leave(state, host, place.code);
            let ended = std::mem::replace(place.frame, caller);
            calls::give(place.code, &ended.registers, &mut place.frame.registers, ended.to);
            place.at = ended.at + 1;
            calls::put_back(state, ended);
            match program.macros.get(usize::from(place.frame.index)) {
                Some(caller) => place.code = caller,
                None => return End::Error,
            }
            if end != End::Budget {
                break;
            }
        }
    }
}

/// Ticks after which a stop of the run is looked at.
const LOOK_EVERY: u64 = 10_000;

/// Runs until the macro calls a function that needs more than the short form of a call, or ends.
fn execute<'p>(
    program: &'p Program,
    state: &mut State,
    host: &mut dyn Host,
    place: &mut Place<'_, 'p>,
) -> Result<Pause, Box<Stop>> {
    loop {
        fast::run(program, state, host, place);
        if state.looked.abs_diff(state.ticks) >= LOOK_EVERY {
            state.looked = state.ticks;
            if host.stopped() {
                return Err(Box::new(Stop::Fault(place.at, stopped(state))));
            }
        }
        let (code, at) = (place.code, place.at);
        match code.ops.get(at) {
            None | Some(Op::Return) => return Ok(Pause::End),
            Some(Op::CallMacro { to, callee, list }) => return Ok(Pause::Call(*to, *callee, *list)),
            Some(_) => {}
        }
        if state.is_vague() && matches!(code.ops.get(at), Some(Op::Command { .. } | Op::Call { .. })) {
            weigh::weigh(program, state, host, place.frame).map_err(|fault| Box::new(Stop::Fault(at, fault)))?;
        }
        match step::step(state, host, code, &mut place.frame.registers, at) {
            Ok(Next::Step) => place.at += 1,
            Ok(Next::Jump(target)) => match fast::passed(at, target, state.ticks + traces(code, target, at)) {
                Some(left) => (place.at, state.ticks) = (usize::from(target), left),
                None => return Err(Box::new(Stop::Fault(at, used_up(state)))),
            },
            Err(stop) => return Err(Box::new(stop)),
        }
        if state.is_full() {
            weigh::weigh(program, state, host, place.frame).map_err(|fault| Box::new(Stop::Fault(at, fault)))?;
        }
    }
}

/// Trace instructions that a backward jump crosses: they cost no steps, so a trace does not change the run.
fn traces(code: &Code, target: Target, at: usize) -> u64 {
    if code.statements.is_empty() {
        return 0;
    }
    let over = code.ops.get(usize::from(target)..=at).unwrap_or(&[]);
    over.iter().filter(|op| matches!(op, Op::Trace { .. })).count() as u64
}

/// The run is to end: no macro continues.
#[cold]
#[inline(never)]
fn stopped(state: &mut State) -> Fault {
    state.ticks = 0;
    Fault::new(crate::diag::Number::TICKS, "the run is stopped")
}

#[cold]
#[inline(never)]
fn used_up(state: &mut State) -> Fault {
    match state.spend(usize::MAX) {
        Err(fault) => fault,
        Ok(()) => Fault::new(crate::diag::Number::TICKS, "the budget of steps is exhausted"),
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
