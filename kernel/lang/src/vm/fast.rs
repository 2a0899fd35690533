//! The loop over short forms.
//!
//! Invariant: it stops in front of the first instruction that has no short form or whose operands do not fit, having
//! changed nothing of it; numbers that it stores exist. Shared variables that it uses lie in their homes meanwhile, and
//! in their own place whenever another macro or the host may look at them.

use super::calls::{self, Frame};
use super::{State, light};
use crate::bytecode::fast::{Fast, Near, WINDOW};
use crate::bytecode::{Code, Relation, Target};
use crate::compile::Program;
use crate::host::Host;
use crate::value::{Kind, Value};
use std::sync::Arc;

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
pub(super) fn run<'p>(program: &'p Program, state: &mut State, host: &mut dyn Host, place: &mut Place<'_, 'p>) {
    let (mut at, mut ticks) = (place.at, state.ticks);
    let mut at_home = 0u64;
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
    macro_rules! did {
        ($outcome:expr) => {
            match $outcome {
                Some(()) => at += 1,
                None => break,
            }
        };
    }
    macro_rules! register {
        ($register:expr) => {
            match window.get(usize::from($register)) {
                Some(value) => value,
                None => break,
            }
        };
    }
    macro_rules! related {
        ($relation:expr, $a:expr, $b:expr, $work:expr) => {
            match (register!($a), register!($b)) {
                (Value::Real(a), Value::Real(b)) => $work(*a, *b),
                (a, b) => match light::related($relation, a, b) {
                    Some(holds) => holds,
                    None => break,
                },
            }
        };
    }
    macro_rules! truth {
        ($register:expr) => {
            match window.get(usize::from($register)) {
                Some(Value::Logical(truth)) => *truth,
                _ => break,
            }
        };
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
    'run: loop {
        while let Some(form) = forms.get(at) {
            match *form {
                Fast::None => break,
                Fast::Move { to, a } => match window.get(usize::from(a)) {
                    Some(Value::Real(value)) => {
                        let value = *value;
                        put(window, to, value);
                        at += 1;
                    }
                    _ => did!(light::move_any(window, to, a)),
                },
                Fast::MoveNumber { to, a } => {
                    let value = number!(a);
                    put(window, to, value);
                    at += 1;
                }
                Fast::MoveTyped { to, a, kind } => did!(light::move_light(window, to, a, Some(kind))),
                Fast::Read { to, home, shared } => {
                    if at_home >> (shared & 63) & 1 == 0 {
                        break;
                    }
                    match window.get(usize::from(home)) {
                        Some(Value::Real(value)) => {
                            let value = *value;
                            put(window, to, value);
                            at += 1;
                        }
                        _ => did!(light::move_light(window, to, home, None)),
                    }
                }
                Fast::Write { home, shared, a } => {
                    if at_home >> (shared & 63) & 1 == 0 {
                        break;
                    }
                    match window.get(usize::from(a)) {
                        Some(Value::Real(value)) => {
                            let value = *value;
                            put(window, home, value);
                            at += 1;
                        }
                        _ => did!(light::move_light(window, home, a, None)),
                    }
                }
                Fast::WriteTyped { home, shared, a, kind } => {
                    if at_home >> (shared & 63) & 1 == 0 {
                        break;
                    }
                    match window.get(usize::from(a)) {
                        Some(Value::Real(value)) if kind == Kind::Real => {
                            let value = *value;
                            put(window, home, value);
                            at += 1;
                        }
                        _ => did!(light::move_light(window, home, a, Some(kind))),
                    }
                }
                Fast::Negate { to, a } => {
                    let value = number!(a);
                    put(window, to, -value);
                    at += 1;
                }
                Fast::Add { to, a, b } => match (register!(a), register!(b)) {
                    (Value::Real(a), Value::Real(b)) => store!(to, a + b, 1),
                    _ => match light::join(state, window, (to, a, b), ticks) {
                        Some(left) => (at, ticks) = (at + 1, left),
                        None => break,
                    },
                },
                Fast::Subtract { to, a, b } => store!(to, number!(a) - number!(b), 1),
                Fast::Multiply { to, a, b } => store!(to, number!(a) * number!(b), 1),
                Fast::Divide { to, a, b } => store!(to, number!(a) / number!(b), 1),
                Fast::Power { to, a, b } => store!(to, super::step::power(number!(a), number!(b)), 1),
                Fast::Join { to, a, b } => match light::join(state, window, (to, a, b), ticks) {
                    Some(left) => (at, ticks) = (at + 1, left),
                    None => break,
                },
                Fast::Not { to, a } => {
                    let truth = truth!(a);
                    put_truth(window, to, !truth);
                    at += 1;
                }
                Fast::Truth { to, a } => {
                    let truth = truth!(a);
                    put_truth(window, to, truth);
                    at += 1;
                }
                Fast::Compare { relation, to, a, b } => {
                    let holds = related!(relation, a, b, |a, b| super::run::relate(relation, a, b));
                    put_truth(window, to, holds);
                    at += 1;
                }
                Fast::Math { to, a, function } => {
                    let Some(result) = light::math(&code.functions, function, number!(a)) else { break };
                    store!(to, result, 1);
                }
                Fast::Sequence { to, list } => {
                    let Some(slots) = code.lists.get(usize::from(list)) else { break };
                    match light::sequence(state, window, to, slots, ticks) {
                        Some(left) => (at, ticks) = (at + 1, left),
                        None => break,
                    }
                }
                // A sum or quotient that does not exist makes no sum or difference that does, so one check is enough.
                Fast::MultiplyAdd { to, a, b, c } => store!(to, number!(c) + number!(a) * number!(b), 2),
                Fast::DivideFrom { to, a, b, c } => store!(to, number!(c) - number!(a) / number!(b), 2),
                Fast::Two { first, then, to, a, b, c } => {
                    let value = exists!(first.of(number!(a), number!(b)));
                    store!(to, then.of(value, number!(c)), 2);
                }
                Fast::AddTo { to, a } => match window.get(usize::from(a)) {
                    Some(Value::Real(more)) => {
                        let more = *more;
                        match window.get_mut(usize::from(to)) {
                            Some(Value::Real(number)) => *number = exists!(*number + more),
                            Some(Value::Sequence(sequence)) if sequence.len() < state.limits.elements => {
                                push(sequence, more);
                            }
                            _ => break,
                        }
                        at += 1;
                    }
                    _ => did!(light::append(state, window, to, a)),
                },
                Fast::Pair { to, a, b, function } => {
                    let (a, b) = (number!(a), number!(b));
                    let (Some(result), Some(left)) =
                        (light::pair(&code.functions, function, a, b), ticks.checked_sub(3))
                    else {
                        break;
                    };
                    ticks = left;
                    store!(to, result, 1);
                }
                Fast::Element { to, array, index } => {
                    let index = number!(index);
                    match element(window, array, index) {
                        Some(found) => {
                            put(window, to, found);
                            at += 1;
                        }
                        None => did!(light::element(window, to, array, (index, None))),
                    }
                }
                Fast::ElementThen { then, to, array, index, c } => {
                    let (index, c) = (number!(index), number!(c));
                    let Some(found) = element(window, array, index) else { break };
                    store!(to, then.of(found, c), 2);
                }
                Fast::Cell { to, array, row, column } => {
                    let (row, column) = (number!(row), number!(column));
                    match cell(window, array, row, column) {
                        Some(found) => {
                            put(window, to, found);
                            at += 1;
                        }
                        None => did!(light::element(window, to, array, (row, Some(column)))),
                    }
                }
                Fast::SetElement { array, index, a } => {
                    let index = number!(index);
                    match (window.get(usize::from(a)), index) {
                        (Some(Value::Real(value)), index) => {
                            let value = *value;
                            match element_place(window, array, index) {
                                Some(place) => {
                                    *place = value;
                                    at += 1;
                                }
                                None => did!(light::set_element(window, array, (index, None), a)),
                            }
                        }
                        _ => did!(light::set_element(window, array, (index, None), a)),
                    }
                }
                Fast::SetCell { array, row, column, a } => {
                    let (row, column) = (number!(row), number!(column));
                    match window.get(usize::from(a)) {
                        Some(Value::Real(value)) => {
                            let value = *value;
                            match cell_place(window, array, row, column) {
                                Some(place) => {
                                    *place = value;
                                    at += 1;
                                }
                                None => did!(light::set_element(window, array, (row, Some(column)), a)),
                            }
                        }
                        _ => did!(light::set_element(window, array, (row, Some(column)), a)),
                    }
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
                Fast::UpdateCell { then, array, row, column, c } => {
                    let (row, column, c) = (number!(row), number!(column), number!(c));
                    let Some(place) = cell_place(window, array, row, column) else { break };
                    *place = exists!(then.of(*place, c));
                    at += 3;
                }
                Fast::UnlessElement { relation, array, index, b, target } => {
                    let index = (number!(index), None);
                    let Some(holds) = light::element_related(window, relation, array, index, b) else { break };
                    if holds {
                        at += 2;
                    } else {
                        // The jump is the second of the two instructions.
                        match passed(at + 1, target, ticks) {
                            Some(left) => (at, ticks) = (usize::from(target), left),
                            None => break,
                        }
                    }
                }
                Fast::UnlessCell { relation, array, row, column, b, target } => {
                    let indices = (number!(row), Some(number!(column)));
                    let Some(holds) = light::element_related(window, relation, array, indices, b) else { break };
                    if holds {
                        at += 2;
                    } else {
                        match passed(at + 1, target, ticks) {
                            Some(left) => (at, ticks) = (usize::from(target), left),
                            None => break,
                        }
                    }
                }
                Fast::Call { to, callee, list } => {
                    if at_home != 0 {
                        light::take_back(code, state, host, window, &mut at_home);
                    }
                    state.ticks = ticks;
                    let Some(callee) = calls::quick_call(program, state, code, frame, (at, to, callee, list)) else {
                        break 'run;
                    };
                    (code, at, ticks) = (callee, 0, state.ticks);
                    forms = code.fast.as_slice();
                    let Some(registers) = frame.registers.first_chunk_mut::<WINDOW>() else { break 'run };
                    window = registers;
                }
                Fast::Return => {
                    if at_home != 0 {
                        light::take_back(code, state, host, window, &mut at_home);
                    }
                    let Some((caller, call)) = calls::quick_return(program, state, code, frame) else { break 'run };
                    (code, at) = (caller, call + 1);
                    forms = code.fast.as_slice();
                    let Some(registers) = frame.registers.first_chunk_mut::<WINDOW>() else { break 'run };
                    window = registers;
                }
                Fast::Jump { target } => jump!(target),
                Fast::JumpIf { a, target } => {
                    if truth!(a) {
                        jump!(target);
                    } else {
                        at += 1;
                    }
                }
                Fast::JumpUnless { a, target } => unless!(truth!(a), target),
                Fast::UnlessEqual { a, b, target } => {
                    unless!(related!(Relation::Equal, a, b, |a, b| a == b), target);
                }
                Fast::UnlessNotEqual { a, b, target } => {
                    #[allow(
                        clippy::double_comparisons,
                        reason = "false for what is no number, as in the full instruction"
                    )]
                    let differ = related!(Relation::NotEqual, a, b, |a, b| a < b || a > b);
                    unless!(differ, target);
                }
                Fast::UnlessLess { a, b, target } => unless!(related!(Relation::Less, a, b, |a, b| a < b), target),
                Fast::UnlessLessEqual { a, b, target } => {
                    unless!(related!(Relation::LessEqual, a, b, |a, b| a <= b), target);
                }
                Fast::UnlessGreater { a, b, target } => {
                    unless!(related!(Relation::Greater, a, b, |a, b| a > b), target);
                }
                Fast::UnlessGreaterEqual { a, b, target } => {
                    unless!(related!(Relation::GreaterEqual, a, b, |a, b| a >= b), target);
                }
                Fast::IfWhen { a, b, target } => {
                    let equal = match (register!(a), register!(b)) {
                        (Value::Real(a), Value::Real(b)) => a == b,
                        (a, b) => match light::same(a, b) {
                            Some(equal) => equal,
                            None => break,
                        },
                    };
                    unless!(!equal, target);
                }
                Fast::IfThru { a, low, high, target } => {
                    let (value, low, high) = (number!(a), number!(low), number!(high));
                    unless!(!(low..=high).contains(&value), target);
                }
                Fast::DoStart { variable, end, step, target } => {
                    let (value, last, step) = (number!(variable), number!(end), number!(step));
                    if step == 0.0 {
                        break;
                    }
                    unless!(!super::run::past(value, last, step), target);
                }
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
        // It may be that a shared variable is not at home yet.
        let waits = !code.homes.is_empty() && forms.get(at).is_some_and(|form| *form != Fast::None);
        if !waits || !light::bring(code, at, (&mut *state, &mut *host), window, &mut at_home) {
            if at_home != 0 {
                light::take_back(code, state, host, window, &mut at_home);
            }
            break;
        }
    }
    (place.code, place.at, state.ticks) = (code, at, ticks);
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

#[inline(never)]
fn push(elements: &mut Arc<Vec<Value>>, number: f64) {
    Arc::make_mut(elements).push(Value::Real(number));
}

/// Position of a 1-based index; what is below 1 or too large lies after every end.
#[inline(always)]
pub(super) fn position(index: f64) -> usize {
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

/// Where a one-dimensional array, or a sequence that nobody else has, holds a number.
#[inline(always)]
fn element_place(window: &mut Window, array: Near, index: f64) -> Option<&mut f64> {
    match window.get_mut(usize::from(array)) {
        Some(Value::Array(array)) if array.sizes.len() == 1 => match array.elements.get_mut(position(index)) {
            Some(Value::Real(number)) => Some(number),
            _ => None,
        },
        Some(Value::Sequence(elements)) => own_place(elements, index),
        _ => None,
    }
}

#[inline(never)]
fn own_place(elements: &mut Arc<Vec<Value>>, index: f64) -> Option<&mut f64> {
    match Arc::get_mut(elements)?.get_mut(position(index)) {
        Some(Value::Real(number)) => Some(number),
        _ => None,
    }
}

/// Element of an array with two indices that is a number.
#[inline(always)]
fn cell(window: &Window, array: Near, row: f64, column: f64) -> Option<f64> {
    match window.get(usize::from(array)) {
        Some(Value::Array(array)) => match array.elements.get(light::cell(array, row, column)?) {
            Some(Value::Real(number)) => Some(*number),
            _ => None,
        },
        _ => None,
    }
}

/// Where an array with two indices holds a number.
#[inline(always)]
fn cell_place(window: &mut Window, array: Near, row: f64, column: f64) -> Option<&mut f64> {
    match window.get_mut(usize::from(array)) {
        Some(Value::Array(array)) => {
            let at = light::cell(array, row, column)?;
            match array.elements.get_mut(at) {
                Some(Value::Real(number)) => Some(number),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Stores a truth value.
#[inline(always)]
fn put_truth(window: &mut Window, to: Near, truth: bool) {
    if let Some(register) = window.get_mut(usize::from(to)) {
        match register {
            Value::Logical(old) => *old = truth,
            Value::Real(_) | Value::Unset | Value::Null => *register = Value::Logical(truth),
            other => super::run::replace(other, Value::Logical(truth)),
        }
    }
}
