//! The loop over short forms.
//!
//! Invariant: it stops in front of the first instruction that has no short form or whose operands do not fit, having
//! changed nothing of it; numbers that it stores exist. It allocates only to let a sequence grow.

use super::State;
use super::calls::{self, Frame};
use super::memory::ELEMENT;
use crate::bytecode::fast::{Fast, Near, WINDOW};
use crate::bytecode::{Code, Target};
use crate::compile::Program;
use crate::func::{Function, Way};
use crate::value::Value;
use std::sync::Arc;

/// Ticks that are used up at most before a stop of the run is looked at.
const SLICE: u64 = 20_000;

/// The registers that short forms name.
pub(super) type Window = [Value; WINDOW];

/// Where the loop is: the macro that runs, its frame and the next instruction.
pub(super) struct Place<'a, 'p> {
    pub(super) code: &'p Code,
    pub(super) frame: &'a mut Box<Frame>,
    pub(super) at: usize,
}

/// Runs on from `place` and leaves there where it stopped.
#[allow(clippy::too_many_lines, reason = "one arm per form; kept together so that operands stay in machine registers")]
#[inline(never)]
pub(super) fn run<'p>(program: &'p Program, state: &mut State, place: &mut Place<'_, 'p>) {
    // The rest of the ticks waits, so that a long run comes back to where a stop of the run is looked at.
    let rest = state.ticks.saturating_sub(SLICE);
    let (mut at, mut ticks) = (place.at, state.ticks - rest);
    let mut code = place.code;
    let mut forms = code.fast.as_slice();
    let frame = &mut *place.frame;
    let Some(mut window) = frame.registers.first_chunk_mut::<WINDOW>() else { return };
    macro_rules! number {
        ($register:expr) => {
            match window.get(usize::from($register)) {
                Some(Value::Real(number)) => *number,
                _ => break,
            }
        };
    }
    macro_rules! exists {
        ($result:expr) => {{
            let result: f64 = $result;
            if !result.is_finite() {
                break;
            }
            result
        }};
    }
    macro_rules! store {
        ($to:expr, $result:expr, $forms:expr) => {{
            let result = exists!($result);
            put(window, $to, result);
            at += $forms;
        }};
    }
    macro_rules! jump {
        ($target:expr) => {
            match passed(at, $target, ticks) {
                Some(left) => (at, ticks) = (usize::from($target), left),
                None => break,
            }
        };
    }
    macro_rules! unless {
        ($holds:expr, $target:expr) => {
            if $holds {
                at += 1;
            } else {
                jump!($target);
            }
        };
    }
    while let Some(form) = forms.get(at) {
        match *form {
            Fast::None => break,
            Fast::Move { to, a } => {
                let value = number!(a);
                put(window, to, value);
                at += 1;
            }
            Fast::Negate { to, a } => {
                let value = number!(a);
                put(window, to, -value);
                at += 1;
            }
            Fast::Add { to, a, b } => store!(to, number!(a) + number!(b), 1),
            Fast::Subtract { to, a, b } => store!(to, number!(a) - number!(b), 1),
            Fast::Multiply { to, a, b } => store!(to, number!(a) * number!(b), 1),
            Fast::Divide { to, a, b } => store!(to, number!(a) / number!(b), 1),
            // A sum or quotient that does not exist makes no sum or difference that does, so one check is enough.
            Fast::MultiplyAdd { to, a, b, c } => store!(to, number!(c) + number!(a) * number!(b), 2),
            Fast::DivideFrom { to, a, b, c } => store!(to, number!(c) - number!(a) / number!(b), 2),
            Fast::Two { first, then, to, a, b, c } => {
                let value = exists!(first.of(number!(a), number!(b)));
                store!(to, then.of(value, number!(c)), 2);
            }
            Fast::AddTo { to, a } => {
                let more = number!(a);
                match window.get_mut(usize::from(to)) {
                    Some(Value::Real(number)) => *number = exists!(*number + more),
                    Some(Value::Sequence(sequence)) if sequence.len() < state.limits.elements => {
                        if !push(state, sequence, more) {
                            break;
                        }
                    }
                    _ => break,
                }
                at += 1;
            }
            Fast::Pair { to, a, b, function } => {
                let (a, b) = (number!(a), number!(b));
                let (Some(result), Some(left)) = (pair(&code.functions, function, a, b), ticks.checked_sub(3)) else {
                    break;
                };
                ticks = left;
                store!(to, result, 1);
            }
            Fast::Element { to, array, index } => {
                let index = number!(index);
                let Some(found) = element(window, array, index) else { break };
                put(window, to, found);
                at += 1;
            }
            Fast::ElementThen { then, to, array, index, c } => {
                let (index, c) = (number!(index), number!(c));
                let Some(found) = element(window, array, index) else { break };
                store!(to, then.of(found, c), 2);
            }
            Fast::SetElement { array, index, a } => {
                let (index, value) = (number!(index), number!(a));
                let Some(place) = element_place(window, array, index) else { break };
                *place = value;
                at += 1;
            }
            Fast::UpdateAdd { array, index, c } => {
                let (index, c) = (number!(index), number!(c));
                let Some(place) = element_place(window, array, index) else { break };
                *place = exists!(*place + c);
                at += 3;
            }
            Fast::Update { then, array, index, c } => {
                let (index, c) = (number!(index), number!(c));
                let Some(place) = element_place(window, array, index) else { break };
                *place = exists!(then.of(*place, c));
                at += 3;
            }
            Fast::Call { to, callee, list } => {
                state.ticks = ticks;
                let Some(callee) = calls::quick_call(program, state, code, frame, (at, to, callee, list)) else {
                    break;
                };
                (code, at, ticks) = (callee, 0, state.ticks);
                forms = code.fast.as_slice();
                let Some(registers) = frame.registers.first_chunk_mut::<WINDOW>() else { break };
                window = registers;
            }
            Fast::Return => {
                let Some((caller, call)) = calls::quick_return(program, state, code, frame) else { break };
                (code, at) = (caller, call + 1);
                forms = code.fast.as_slice();
                let Some(registers) = frame.registers.first_chunk_mut::<WINDOW>() else { break };
                window = registers;
            }
            Fast::Jump { target } => jump!(target),
            Fast::JumpIf { a, target } => match window.get(usize::from(a)) {
                Some(Value::Logical(true)) => jump!(target),
                Some(Value::Logical(false)) => at += 1,
                _ => break,
            },
            Fast::JumpUnless { a, target } => match window.get(usize::from(a)) {
                Some(Value::Logical(false)) => jump!(target),
                Some(Value::Logical(true)) => at += 1,
                _ => break,
            },
            Fast::UnlessEqual { a, b, target } => unless!(number!(a) == number!(b), target),
            Fast::UnlessNotEqual { a, b, target } => {
                let (a, b) = (number!(a), number!(b));
                #[allow(clippy::double_comparisons, reason = "false for what is no number, as in the full instruction")]
                let differ = a < b || a > b;
                unless!(differ, target);
            }
            Fast::UnlessLess { a, b, target } => unless!(number!(a) < number!(b), target),
            Fast::UnlessLessEqual { a, b, target } => unless!(number!(a) <= number!(b), target),
            Fast::UnlessGreater { a, b, target } => unless!(number!(a) > number!(b), target),
            Fast::UnlessGreaterEqual { a, b, target } => unless!(number!(a) >= number!(b), target),
            Fast::DoNext { variable, end, step, target } => {
                let (last, step) = (number!(end), number!(step));
                let value = exists!(number!(variable) + step);
                let Some(left) = passed(at, target, ticks) else { break };
                put(window, variable, value);
                if super::run::past(value, last, step) {
                    at += 1;
                } else {
                    (at, ticks) = (usize::from(target), left);
                }
            }
        }
    }
    (place.code, place.at, state.ticks) = (code, at, ticks + rest);
}

/// Ticks left after a jump from `at`: a jump back costs the instructions it goes back over.
#[inline(always)]
pub(super) fn passed(at: usize, target: Target, ticks: u64) -> Option<u64> {
    let target = usize::from(target);
    if target > at { Some(ticks) } else { ticks.checked_sub((at - target) as u64 + 1) }
}

#[inline(always)]
fn put(window: &mut Window, to: Near, number: f64) {
    if let Some(register) = window.get_mut(usize::from(to)) {
        super::run::put(register, number);
    }
}

/// Appends to a sequence that nobody else has; the copy that another one needs is paid for by the full instruction.
#[inline(never)]
fn push(state: &mut State, elements: &mut Arc<Vec<Value>>, number: f64) -> bool {
    match Arc::get_mut(elements) {
        Some(elements) if state.has_room() => {
            elements.push(Value::Real(number));
            state.grow(ELEMENT);
            true
        }
        _ => false,
    }
}

/// Position of a 1-based index; what is below 1 or too large lies behind every end.
#[inline(always)]
fn position(index: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let whole = index as u32;
    whole.wrapping_sub(1) as usize
}

/// Element of a sequence or a one-dimensional array that is a number.
#[inline(always)]
fn element(window: &Window, array: Near, index: f64) -> Option<f64> {
    let elements = match window.get(usize::from(array)) {
        Some(Value::Array(array)) if array.sizes.len() == 1 => &array.elements,
        Some(Value::Sequence(elements)) => elements.as_ref(),
        _ => return None,
    };
    match elements.get(position(index)) {
        Some(Value::Real(number)) => Some(*number),
        _ => None,
    }
}

/// Where a one-dimensional array holds a number.
#[inline(always)]
fn element_place(window: &mut Window, array: Near, index: f64) -> Option<&mut f64> {
    match window.get_mut(usize::from(array)) {
        Some(Value::Array(array)) if array.sizes.len() == 1 => match array.elements.get_mut(position(index)) {
            Some(Value::Real(number)) => Some(number),
            _ => None,
        },
        _ => None,
    }
}

#[inline(never)]
fn pair(functions: &[&'static Function], function: u16, a: f64, b: f64) -> Option<f64> {
    match functions.get(usize::from(function))?.way {
        Way::Pair(compute, _) => compute(a, b),
        _ => None,
    }
}
