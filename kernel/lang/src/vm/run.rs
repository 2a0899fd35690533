//! The loop over the instructions.
//!
//! Invariant: a short way here gives exactly what [`super::step`] gives, or is not taken.

use super::{State, data, step};
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
    /// Nothing: the macro ends.
    Return,
}

/// Runs the code in its frame.
#[inline(never)]
pub(super) fn run(
    program: &Program,
    state: &mut State,
    host: &mut dyn Host,
    code: &Code,
    frame: &mut [Value],
) -> Result<(), Stop> {
    let mut at = 0usize;
    macro_rules! jump {
        ($target:expr) => {{
            let target = usize::from($target);
            if target <= at {
                let cost = (at - target) as u64 + 1;
                if state.ticks < cost {
                    return Err(Stop::Fault(at, used_up(state)));
                }
                state.ticks -= cost;
            }
            at = target;
            continue;
        }};
    }
    macro_rules! short {
        ($to:expr, $a:expr, $b:expr, $work:expr) => {
            if let (Some(a), Some(b)) = (number(frame, $a), number(frame, $b)) {
                let result: f64 = $work(a, b);
                if result.is_finite() {
                    set_number(frame, $to, result);
                    at += 1;
                    continue;
                }
            }
        };
    }
    while let Some(op) = code.ops.get(at) {
        match *op {
            Op::Add { to, a, b } => short!(to, a, b, |a: f64, b: f64| a + b),
            Op::Subtract { to, a, b } => short!(to, a, b, |a: f64, b: f64| a - b),
            Op::Multiply { to, a, b } => short!(to, a, b, |a: f64, b: f64| a * b),
            Op::Divide { to, a, b } => short!(to, a, b, |a: f64, b: f64| a / b),
            Op::AddTo { to, a } => short!(to, to, a, |a: f64, b: f64| a + b),
            Op::Move { to, a } => {
                match number(frame, a) {
                    Some(number) => set_number(frame, to, number),
                    None => copy(frame, to, a),
                }
                at += 1;
                continue;
            }
            Op::Element { to, a, index } => {
                if let Some(position) = number(frame, index)
                    && let Some(found) = data::element_number(get(frame, a), position)
                {
                    set_number(frame, to, found);
                    at += 1;
                    continue;
                }
            }
            Op::SetElement { to, index, a } => {
                if let (Some(position), Some(value)) = (number(frame, index), number(frame, a))
                    && data::set_element_number(frame, to, position, value)
                {
                    at += 1;
                    continue;
                }
            }
            Op::Jump { target } => jump!(target),
            Op::JumpUnlessCompare { relation, a, b, target } => {
                if let (Some(a), Some(b)) = (number(frame, a), number(frame, b)) {
                    if relate(relation, a, b) {
                        at += 1;
                        continue;
                    }
                    jump!(target);
                }
            }
            Op::DoNext { variable, end, target } => {
                let known = (number(frame, variable), number(frame, end), number(frame, end + 1));
                if let (Some(value), Some(last), Some(step)) = known {
                    let value = value + step;
                    set_number(frame, variable, value);
                    if past(value, last, step) {
                        at += 1;
                        continue;
                    }
                    jump!(target);
                }
            }
            Op::Return => return Ok(()),
            _ => {}
        }
        match step::step(program, state, host, code, frame, at)? {
            Next::Step => at += 1,
            Next::Jump(target) => jump!(target),
            Next::Return => return Ok(()),
        }
    }
    Ok(())
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
