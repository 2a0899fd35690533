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

/// Why a macro ends early.
pub(super) enum Stop {
    /// A fault at an instruction.
    Fault(usize, Fault),
    /// A diagnostic of severity 8 was issued by the macro itself.
    Raised(usize),
    /// A budget of the whole run is used up; it is reported already.
    Budget,
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
    match frame.get_mut(usize::from(slot)) {
        Some(Value::Real(register)) => *register = number,
        Some(register) => *register = Value::Real(number),
        None => {}
    }
}

/// What comes after an instruction.
pub(super) enum Next {
    /// The next instruction.
    Step,
    /// Another one.
    Jump(Target),
}

/// A call: register of the result, function, registers of the arguments.
pub(super) type Call = (Slot, u16, u16);

/// A macro that waits for a function it called.
struct Caller<'p> {
    code: &'p Code,
    frame: Frame,
    /// The call.
    at: usize,
    /// Register of the result, and the function.
    to: Slot,
    callee: u16,
}

/// Runs a macro that has been entered, with everything it calls.
pub(super) fn run<'p>(
    program: &'p Program,
    state: &mut State,
    host: &mut dyn Host,
    mut code: &'p Code,
    frame: &mut Frame,
) -> End {
    let mut callers: Vec<Caller<'p>> = Vec::new();
    let mut at = 0usize;
    loop {
        let mut outcome = match execute(state, host, code, frame, &mut at) {
            Ok(None) => Ok(()),
            Err(stop) => Err(stop),
            Ok(Some((to, callee, list))) => match calls::call(program, state, callee) {
                Ok((callee_code, callee_frame)) => {
                    let waiting = std::mem::replace(frame, callee_frame);
                    let filled = calls::fill(callee_code, frame, &waiting, slots(code, list));
                    callers.push(Caller { code, frame: waiting, at, to, callee });
                    (code, at) = (callee_code, 0);
                    calls::begin(state, host, code);
                    match filled {
                        Ok(()) => continue,
                        Err(fault) => Err(Stop::Fault(0, fault)),
                    }
                }
                Err(fault) => Err(Stop::Fault(at, fault)),
            },
        };
        // The macro has ended; so do its callers if a budget is used up.
        loop {
            let end = calls::finish(state, host, code, frame, outcome);
            let Some(caller) = callers.pop() else { return end };
            calls::leave(state, host, code);
            let ended = std::mem::replace(frame, caller.frame);
            calls::give(code, &ended, frame, caller.to);
            calls::put_back(state, caller.callee, ended);
            (code, at) = (caller.code, caller.at + 1);
            if end != End::Budget {
                break;
            }
            outcome = Err(Stop::Budget);
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
) -> Result<Option<Call>, Stop> {
    let mut at = *position;
    loop {
        if let Some(window) = frame.first_chunk_mut::<WINDOW>() {
            let elements = state.limits.elements;
            let work = fast::Work { forms: &code.fast, functions: &code.functions, elements };
            (at, state.ticks) = fast::run(&work, window, at, state.ticks);
        }
        match code.ops.get(at) {
            None | Some(Op::Return) => return Ok(None),
            Some(Op::CallMacro { to, callee, list }) => {
                *position = at;
                return Ok(Some((*to, *callee, *list)));
            }
            Some(_) => {}
        }
        match step::step(state, host, code, frame, at)? {
            Next::Step => at += 1,
            Next::Jump(target) => {
                let Some(left) = fast::passed(at, target, state.ticks) else {
                    return Err(Stop::Fault(at, used_up(state)));
                };
                (at, state.ticks) = (usize::from(target), left);
            }
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
