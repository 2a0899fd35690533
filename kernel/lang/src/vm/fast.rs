//! The loop over short forms.
//!
//! *Invariant:* it stops in front of the first instruction that has no short form or whose operands do not fit, having
//! changed nothing of it; numbers that it stores exist. Shared variables that it uses lie in their homes meanwhile, and
//! in their own place whenever another macro or the host may look at them.

use super::bodies::{self, InlineCall};
use super::window::{InstructionCursor, Window, passed, position};
use super::{calls, homes, light};
use crate::bytecode::fast::{Fast, Near, WINDOW};
use crate::host::MacroHost;
use crate::program::MacroProgram;
use crate::state::MacroState;
use crate::value::{Elements, MacroValue};

/// Ticks that are used up at most before a stop of the run is looked at.
const SLICE: u64 = 20_000;

/// Ticks that a call costs.
const CALL: u64 = 5;

/// Runs on from `place` and leaves there where it stopped.
#[allow(
    clippy::too_many_lines,
    reason = "one arm per form; kept together, and kept small, so that operands stay in machine registers"
)]
#[inline(never)]
pub(super) fn run<'p>(
    program: &'p MacroProgram,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    place: &mut InstructionCursor<'_, 'p>,
) {
    // The rest of the ticks waits, so that a long run comes back to where a stop of the run is looked at.
    let rest = state.ticks.saturating_sub(SLICE);
    let (mut at, mut ticks) = (place.at, state.ticks - rest);
    let mut code = place.code;
    let mut forms = code.short.forms.as_slice();
    let frame = &mut *place.frame;
    let Some(mut window) = frame.registers.first_chunk_mut::<WINDOW>() else { return };
    macro_rules! number {
        ($register:expr) => {
            match window.get(usize::from($register)) {
                Some(MacroValue::Real(number)) => *number,
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
    macro_rules! truth {
        ($register:expr) => {
            match window.get(usize::from($register)) {
                Some(MacroValue::Logical(truth)) => *truth,
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
    // The jump is the second of the two instructions of the form.
    macro_rules! unless_second {
        ($holds:expr, $target:expr) => {
            if $holds {
                at += 2;
            } else {
                match passed(at + 1, $target, ticks) {
                    Some(left) => (at, ticks) = (usize::from($target), left),
                    None => break,
                }
            }
        };
    }
    let mut running: Option<InlineCall<'p>> = None;
    'run: loop {
        let mut call = 'forms: {
            while let Some(form) = forms.get(at) {
                match *form {
                    Fast::Move { to, a } | Fast::MoveNumber { to, a } => {
                        let value = number!(a);
                        put(window, to, value);
                        at += 1;
                    }
                    Fast::Read { to, home, shared } => {
                        if !state.is_at_home(shared) {
                            break;
                        }
                        let value = number!(home);
                        put(window, to, value);
                        at += 1;
                    }
                    Fast::Write { home, shared, a } | Fast::WriteNumber { home, shared, a } => {
                        if !state.is_at_home(shared) {
                            break;
                        }
                        let value = number!(a);
                        put(window, home, value);
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
                    // A sum or quotient that does not exist makes no sum or difference that does, so one check is
                    // enough.
                    Fast::MultiplyAdd { to, a, b, c } => store!(to, number!(c) + number!(a) * number!(b), 2),
                    Fast::DivideFrom { to, a, b, c } => store!(to, number!(c) - number!(a) / number!(b), 2),
                    Fast::Two { first, then, to, a, b, c } => {
                        let value = exists!(first.of(number!(a), number!(b)));
                        store!(to, then.of(value, number!(c)), 2);
                    }
                    Fast::AddTo { to, a } => {
                        let more = number!(a);
                        match window.get_mut(usize::from(to)) {
                            Some(MacroValue::Real(number)) => *number = exists!(*number + more),
                            Some(MacroValue::Sequence(sequence)) => {
                                if !light::push(state, sequence, more) {
                                    break;
                                }
                            }
                            _ => break,
                        }
                        at += 1;
                    }
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
                        let Some(found) = element(window, array, index) else { break };
                        put(window, to, found);
                        at += 1;
                    }
                    Fast::ElementThen { then, to, array, index, c } => {
                        let (index, c) = (number!(index), number!(c));
                        let Some(found) = element(window, array, index) else { break };
                        store!(to, then.of(found, c), 2);
                    }
                    Fast::Cell { to, array, row, column } => {
                        let (row, column) = (number!(row), number!(column));
                        let Some(found) = cell(window, array, row, column) else { break };
                        put(window, to, found);
                        at += 1;
                    }
                    Fast::SetElement { array, index, a } => {
                        let (index, value) = (number!(index), number!(a));
                        let Some(place) = element_place(window, array, index) else { break };
                        *place = value;
                        at += 1;
                    }
                    Fast::SetCell { array, row, column, a } => {
                        let (row, column, value) = (number!(row), number!(column), number!(a));
                        let Some(place) = cell_place(window, array, row, column) else { break };
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
                    Fast::UpdateCell { then, array, row, column, c } => {
                        let (row, column, c) = (number!(row), number!(column), number!(c));
                        let Some(place) = cell_place(window, array, row, column) else { break };
                        *place = exists!(then.of(*place, c));
                        at += 3;
                    }
                    Fast::Call { to, callee, list } => break 'forms Some((to, callee, list)),
                    Fast::Inline { to, body } => {
                        let Some(body) = code.short.bodies.get(usize::from(body)) else { break };
                        let (Some(callee), Some(left)) =
                            (program.macros.get(usize::from(body.callee)), ticks.checked_sub(CALL))
                        else {
                            break;
                        };
                        if state.depth < state.limits.depth && bodies::begin(window, body) {
                            running = Some(InlineCall { code, at, ticks, to, body });
                            (code, at, ticks) = (callee, 0, left);
                            forms = body.forms.as_slice();
                        } else {
                            break 'forms Some((to, body.callee, body.list));
                        }
                    }
                    Fast::Leave => {
                        let Some(ended) = &running else { break };
                        if !bodies::give(window, ended) {
                            break;
                        }
                        (code, at) = (ended.code, ended.at + 1);
                        forms = code.short.forms.as_slice();
                        running = None;
                    }
                    Fast::Return => {
                        homes::take_back(code, state, host, window);
                        let Some((caller, call)) = calls::quick_return(program, state, code, frame) else { break 'run };
                        (code, at) = (caller, call + 1);
                        forms = code.short.forms.as_slice();
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
                        let (Some(a), Some(b)) = (window.get(usize::from(a)), window.get(usize::from(b))) else {
                            break;
                        };
                        if let (MacroValue::Real(a), MacroValue::Real(b)) = (a, b) {
                            unless!(*a == *b, target);
                        } else {
                            let Some(equal) = light::equal(a, b) else { break };
                            unless!(equal, target);
                        }
                    }
                    Fast::UnlessNotEqual { a, b, target } => {
                        let (Some(a), Some(b)) = (window.get(usize::from(a)), window.get(usize::from(b))) else {
                            break;
                        };
                        if let (MacroValue::Real(a), MacroValue::Real(b)) = (a, b) {
                            #[allow(
                                clippy::double_comparisons,
                                reason = "false for what is not a number, as in the instruction"
                            )]
                            let differ = a < b || a > b;
                            unless!(differ, target);
                        } else {
                            let Some(equal) = light::equal(a, b) else { break };
                            unless!(!equal, target);
                        }
                    }
                    Fast::UnlessElement { relation, array, index, b, target } => {
                        let index = number!(index);
                        let Some(holds) = light::element_related(window, relation, array, index, b) else { break };
                        unless_second!(holds, target);
                    }
                    Fast::UnlessCell { relation, array, row, column, b, target } => {
                        let indices = (number!(row), number!(column));
                        let Some(holds) = light::cell_related(window, relation, array, indices, b) else { break };
                        unless_second!(holds, target);
                    }
                    Fast::UnlessShared { relation, home, shared, b, target } => {
                        if !state.is_at_home(shared) {
                            break;
                        }
                        let Some(holds) = light::compared(window, relation, home, b) else { break };
                        unless_second!(holds, target);
                    }
                    Fast::UnlessLess { a, b, target } => unless!(number!(a) < number!(b), target),
                    Fast::UnlessLessEqual { a, b, target } => unless!(number!(a) <= number!(b), target),
                    Fast::UnlessGreater { a, b, target } => unless!(number!(a) > number!(b), target),
                    Fast::UnlessGreaterEqual { a, b, target } => unless!(number!(a) >= number!(b), target),
                    Fast::IfWhen { a, b, target } => {
                        let (a, b) = (number!(a), number!(b));
                        #[allow(clippy::double_comparisons, reason = "as above")]
                        let differ = a < b || a > b;
                        unless!(differ, target);
                    }
                    Fast::IfThru { a, low, high, target } => {
                        let (value, low, high) = (number!(a), number!(low), number!(high));
                        unless!(value < low || value > high, target);
                    }
                    Fast::DoNext { variable, end, step, target } => {
                        let (last, step) = (number!(end), number!(step));
                        let value = exists!(number!(variable) + step);
                        let Some(left) = passed(at, target, ticks) else { break };
                        put(window, variable, value);
                        if super::slots::past(value, last, step) {
                            // Seldom: the next instruction must not wait for the comparison.
                            std::hint::cold_path();
                            at += 1;
                        } else {
                            (at, ticks) = (usize::from(target), left);
                        }
                    }
                    // All that is left is named, so that the choice needs no check of its own.
                    Fast::None
                    | Fast::MoveTyped { .. }
                    | Fast::WriteTyped { .. }
                    | Fast::Power { .. }
                    | Fast::Join { .. }
                    | Fast::Not { .. }
                    | Fast::Truth { .. }
                    | Fast::Compare { .. }
                    | Fast::Math { .. }
                    | Fast::Sequence { .. }
                    | Fast::DoStart { .. } => break,
                }
            }
            None
        };
        if call.is_none() {
            // One form on values that are not numbers.
            let (next, left) = light::step((code, forms), state, window, at, ticks);
            if next != at {
                (at, ticks) = (next, left);
                continue;
            }
            if let Some(given_up) = running.take() {
                // Nothing has changed but registers of the body: the call itself is executed.
                (code, at, ticks) = (given_up.code, given_up.at, given_up.ticks);
                call = Some((given_up.to, given_up.body.callee, given_up.body.list));
            }
        }
        // A call; or a shared variable comes home, and the form is tried once more.
        if let Some((to, callee, list)) = call {
            homes::take_back(code, state, host, window);
            state.ticks = ticks;
            let Some(callee) = calls::quick_call(program, state, code, frame, (at, to, callee, list)) else { break };
            (code, at, ticks) = (callee, 0, state.ticks);
            forms = code.short.forms.as_slice();
            let Some(registers) = frame.registers.first_chunk_mut::<WINDOW>() else { break };
            window = registers;
        } else if !homes::bring(code, at, state, host, window) {
            homes::take_back(code, state, host, window);
            break;
        }
    }
    (place.code, place.at, state.ticks) = (code, at, ticks + rest);
}

#[inline(always)]
fn put(window: &mut Window, to: Near, number: f64) {
    if let Some(register) = window.get_mut(usize::from(to)) {
        super::slots::put(register, number);
    }
}

/// Element of a sequence or a one-dimensional array that is a number.
#[inline(always)]
fn element(window: &Window, array: Near, index: f64) -> Option<f64> {
    let elements = match window.get(usize::from(array)) {
        Some(MacroValue::Array(array)) if array.sizes.len() == 1 => &array.elements,
        Some(MacroValue::Sequence(elements)) => elements.as_ref(),
        _ => return None,
    };
    match elements.get(position(index)) {
        Some(MacroValue::Real(number)) => Some(*number),
        _ => None,
    }
}

/// Where a one-dimensional array, or a sequence that no other value shares, holds a number.
#[inline(always)]
fn element_place(window: &mut Window, array: Near, index: f64) -> Option<&mut f64> {
    match window.get_mut(usize::from(array)) {
        Some(MacroValue::Array(array)) if array.sizes.len() == 1 => match array.elements.get_mut(position(index)) {
            Some(MacroValue::Real(number)) => Some(number),
            _ => None,
        },
        Some(MacroValue::Sequence(elements)) => own_place(elements, index),
        _ => None,
    }
}

#[inline]
fn own_place(elements: &mut Elements, index: f64) -> Option<&mut f64> {
    match Elements::get_mut(elements)?.get_mut(position(index)) {
        Some(MacroValue::Real(number)) => Some(number),
        _ => None,
    }
}

/// Element of an array with two indices that is a number.
#[inline(always)]
fn cell(window: &Window, array: Near, row: f64, column: f64) -> Option<f64> {
    match window.get(usize::from(array)) {
        Some(MacroValue::Array(array)) => match array.elements.get(light::cell(array, row, column)?) {
            Some(MacroValue::Real(number)) => Some(*number),
            _ => None,
        },
        _ => None,
    }
}

/// Where an array with two indices holds a number.
#[inline(always)]
fn cell_place(window: &mut Window, array: Near, row: f64, column: f64) -> Option<&mut f64> {
    match window.get_mut(usize::from(array)) {
        Some(MacroValue::Array(array)) => {
            let at = light::cell(array, row, column)?;
            match array.elements.get_mut(at) {
                Some(MacroValue::Real(number)) => Some(number),
                _ => None,
            }
        }
        _ => None,
    }
}
