//! One instruction, for any operands.
//!
//! *Invariant:* this is the meaning of every instruction; [`super::run`] only takes short ways to the same results.

use super::slots::power;
use super::slots::{MacroStop, NextInstruction, copy, get, number, relate, set, set_number, slots};
use super::{commands, data, shown};
use crate::bytecode::{BuiltInVariable, CompiledMacro, Instruction, Relation, Slot};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::func::{EvaluationMethod, FunctionContext};
use crate::host::MacroHost;
use crate::state::{self, MacroState};
use crate::value::MacroValue;

#[inline(never)]
fn real(frame: &[MacroValue], slot: Slot) -> Outcome<f64> {
    let value = get(frame, slot);
    value.as_real().ok_or_else(|| MacroFault::kind("a number", value))
}

fn truth(frame: &[MacroValue], slot: Slot) -> Outcome<bool> {
    let value = get(frame, slot);
    value.as_logical().ok_or_else(|| MacroFault::kind("a truth value", value))
}

#[cold]
fn too_large() -> MacroFault {
    MacroFault::new(DiagnosticNumber::BAD_ARITHMETIC, "the result is too large or does not exist")
}

#[cold]
fn divided_by_zero() -> MacroFault {
    MacroFault::new(DiagnosticNumber::BAD_ARITHMETIC, "division by zero")
}

/// Executes the instruction at `at`.
#[allow(clippy::too_many_lines, reason = "one arm per instruction; the work is elsewhere")]
#[inline(never)]
pub(super) fn step(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &mut [MacroValue],
    at: usize,
) -> Result<NextInstruction, MacroStop> {
    let Some(op) = code.ops.get(at) else { return Ok(NextInstruction::Step) };
    macro_rules! good {
        ($outcome:expr) => {
            match $outcome {
                Ok(value) => value,
                Err(fault) => return Err(MacroStop::Fault(at, fault)),
            }
        };
    }
    macro_rules! arithmetic {
        ($to:expr, $a:expr, $b:expr, $work:expr, $divides:expr) => {{
            let result: f64 = match (number(frame, $a), number(frame, $b)) {
                (Some(a), Some(b)) => $work(a, b),
                _ => f64::NAN,
            };
            if result.is_finite() {
                set_number(frame, $to, result);
            } else {
                let result = good!(arithmetic_slow(frame, $a, $b, $work, $divides));
                set_number(frame, $to, result);
            }
        }};
    }
    match *op {
        Instruction::Move { to, a } => match number(frame, a) {
            Some(number) => set_number(frame, to, number),
            None => copy(frame, to, a),
        },
        Instruction::Typed { to, a, kind } => {
            let value = good!(state::typed(get(frame, a), kind));
            set(frame, to, value);
        }
        Instruction::Add { to, a, b } => match (number(frame, a), number(frame, b)) {
            (Some(x), Some(y)) if (x + y).is_finite() => set_number(frame, to, x + y),
            _ => {
                let value = good!(data::add(state, get(frame, a), get(frame, b)));
                good!(state.made(&value));
                set(frame, to, value);
            }
        },
        Instruction::Subtract { to, a, b } => arithmetic!(to, a, b, |a: f64, b: f64| a - b, false),
        Instruction::Multiply { to, a, b } => arithmetic!(to, a, b, |a: f64, b: f64| a * b, false),
        Instruction::Divide { to, a, b } => arithmetic!(to, a, b, |a: f64, b: f64| a / b, true),
        Instruction::Power { to, a, b } => arithmetic!(to, a, b, power, true),
        Instruction::Join { to, a, b } => {
            let value = good!(data::join(state, get(frame, a), get(frame, b)));
            good!(state.made(&value));
            set(frame, to, value);
        }
        Instruction::Negate { to, a } => {
            let value = good!(real(frame, a));
            set_number(frame, to, -value);
        }
        Instruction::Number { to, a } => {
            let value = good!(real(frame, a));
            set_number(frame, to, value);
        }
        Instruction::Not { to, a } => {
            let value = good!(truth(frame, a));
            set(frame, to, MacroValue::Logical(!value));
        }
        Instruction::Truth { to, a } => {
            let value = good!(truth(frame, a));
            set(frame, to, MacroValue::Logical(value));
        }
        Instruction::Xor { to, a, b } => {
            let value = good!(truth(frame, a)) != good!(truth(frame, b));
            set(frame, to, MacroValue::Logical(value));
        }
        Instruction::Compare { relation, to, a, b } => {
            let holds = match (number(frame, a), number(frame, b)) {
                (Some(a), Some(b)) => relate(relation, a, b),
                _ => {
                    good!(pay_to_compare(state, frame, a, b));
                    good!(compare_slow(get(frame, a), get(frame, b), relation))
                }
            };
            set(frame, to, MacroValue::Logical(holds));
        }
        Instruction::AddTo { to, a } => match (number(frame, to), number(frame, a)) {
            (Some(x), Some(y)) if (x + y).is_finite() => set_number(frame, to, x + y),
            _ => {
                good!(state::pay_to_append(state, get(frame, to), get(frame, a)));
                good!(state::pay_if_shared(state, get(frame, to)));
                good!(data::add_to(state, frame, to, a));
            }
        },
        Instruction::Jump { target } => return Ok(NextInstruction::Jump(target)),
        Instruction::JumpIf { a, target } => {
            if good!(truth(frame, a)) {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::JumpUnless { a, target } => {
            if !good!(truth(frame, a)) {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::JumpUnlessCompare { relation, a, b, target } => {
            let holds = match (number(frame, a), number(frame, b)) {
                (Some(a), Some(b)) => relate(relation, a, b),
                _ => {
                    good!(pay_to_compare(state, frame, a, b));
                    good!(compare_slow(get(frame, a), get(frame, b), relation))
                }
            };
            if !holds {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::JumpIfWhen { a, b, target } => {
            good!(pay_to_compare(state, frame, a, b));
            if get(frame, a).equals(get(frame, b)) == Some(true) {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::JumpIfThru { a, low, target } => {
            good!(pay_to_compare(state, frame, a, low));
            good!(pay_to_compare(state, frame, a, low + 1));
            let value = get(frame, a);
            let inside = value.order(get(frame, low)).is_some_and(std::cmp::Ordering::is_ge)
                && value.order(get(frame, low + 1)).is_some_and(std::cmp::Ordering::is_le);
            if inside {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::DoStart { variable, end, target } => {
            let (value, last, step) = good!(loop_numbers(frame, variable, end));
            if step == 0.0 {
                return Err(MacroStop::Fault(
                    at,
                    MacroFault::new(DiagnosticNumber::STEP_ZERO, "the step of this loop is zero"),
                ));
            }
            if super::slots::past(value, last, step) {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::DoNext { variable, end, target } => {
            let known = (number(frame, variable), number(frame, end), number(frame, end + 1));
            let (value, last, step) = match known {
                (Some(value), Some(last), Some(step)) => (value, last, step),
                _ => good!(loop_numbers(frame, variable, end)),
            };
            let value = value + step;
            if !value.is_finite() {
                return Err(MacroStop::Fault(at, too_large()));
            }
            set_number(frame, variable, value);
            if !super::slots::past(value, last, step) {
                return Ok(NextInstruction::Jump(target));
            }
        }
        Instruction::Element { to, a, index } => {
            let found = match number(frame, index) {
                Some(position) => data::element_number(get(frame, a), position),
                None => None,
            };
            match found {
                Some(found) => set_number(frame, to, found),
                None => {
                    if let MacroValue::Text(_) = get(frame, a) {
                        good!(state::pay_to_look(state, get(frame, a)));
                    }
                    good!(element_slow(state, frame, to, a, index));
                }
            }
        }
        Instruction::Elements { to, a, list } => {
            let value = good!(data::elements(state, code, frame, get(frame, a), list));
            good!(state.made(&value));
            set(frame, to, value);
        }
        Instruction::SetElement { to, index, a } => {
            let stored = match (number(frame, index), number(frame, a)) {
                (Some(position), Some(value)) => data::set_element_number(frame, to, position, value),
                _ => false,
            };
            if !stored {
                let position = good!(real(frame, index));
                good!(state::pay_if_shared(state, get(frame, to)));
                good!(data::set_element(state, frame, to, &[state::whole(position)], a));
            }
        }
        Instruction::SetElements { to, list, a } => {
            let indices = good!(data::indices(code, frame, list));
            good!(state::pay_if_shared(state, get(frame, to)));
            good!(data::set_element(state, frame, to, &indices, a));
        }
        Instruction::Range { to, a, list } => {
            good!(state::pay_to_look(state, get(frame, a)));
            let value = good!(data::range_of(code, frame, get(frame, a), list));
            good!(state.made(&value));
            set(frame, to, value);
        }
        Instruction::Sequence { to, list } => {
            let value = good!(data::sequence(state, code, frame, list));
            good!(state.made(&value));
            set(frame, to, value);
        }
        Instruction::ReadShared { to, shared } => {
            let value = good!(data::read_shared(state, host, code, shared));
            set(frame, to, value);
        }
        Instruction::WriteShared { shared, a } => good!(data::write_shared(state, host, code, shared, get(frame, a))),
        Instruction::SharedElements { to, shared, list } => {
            let value = good!(data::shared_elements(state, host, code, frame, shared, list));
            good!(state.made(&value));
            set(frame, to, value);
        }
        Instruction::SetSharedElements { shared, list, a } => {
            good!(data::set_shared_elements(state, host, code, frame, (shared, list), a));
        }
        Instruction::ReadSystem { to, system, list } => {
            let indices = good!(data::indices(code, frame, list));
            let value = good!(host.read_system(u32::from(system), &indices));
            good!(state.made(&value));
            set(frame, to, value);
        }
        Instruction::WriteSystem { system, list, a } => {
            let indices = good!(data::indices(code, frame, list));
            good!(host.write_system(u32::from(system), &indices, get(frame, a).clone()));
        }
        Instruction::ReadOwn { to, own } => {
            let value = match own {
                BuiltInVariable::Status => f64::from(state.status),
                BuiltInVariable::Nesting => f64::from(state.depth),
                BuiltInVariable::Channel => f64::from(state.channel),
                BuiltInVariable::Channels => f64::from(state.channels),
            };
            set_number(frame, to, value);
        }
        Instruction::Declare { to, declaration } => {
            let value = good!(data::declared(state, code, frame, declaration));
            set(frame, to, value);
        }
        Instruction::DeclareShared { shared, declaration } => {
            good!(data::declare_shared(state, host, code, frame, shared, declaration));
        }
        Instruction::Math { to, a, function } => {
            let value = good!(real(frame, a));
            let result = match code.functions.get(usize::from(function)).map(|function| &function.way) {
                Some(EvaluationMethod::Math(math)) => math(value).filter(|result| result.is_finite()),
                _ => None,
            };
            let name = || code.functions.get(usize::from(function)).map_or("the function", |function| function.name);
            let fault =
                || MacroFault::new(DiagnosticNumber::BAD_ARITHMETIC, format!("{} has no result for {value}", name()));
            set_number(frame, to, good!(result.ok_or_else(fault)));
        }
        Instruction::Call { to, function, list } => {
            let value = good!(call(state, host, code, frame, function, list));
            good!(state.made(&value));
            set(frame, to, value);
            if !state.notes.is_empty() {
                super::report_notes(code, code.places.get(at).copied().unwrap_or_default(), state, host);
            }
        }
        // The loop takes these itself.
        Instruction::CallMacro { .. } | Instruction::Return => {}
        Instruction::Command { command, list } => {
            good!(state.spend(5));
            let raised = good!(commands::command(state, host, code, frame, (command, list), at));
            if !state.notes.is_empty() {
                super::report_notes(code, code.places.get(at).copied().unwrap_or_default(), state, host);
            }
            if raised {
                return Err(MacroStop::Raised(at));
            }
        }
        Instruction::Read { list, targets, again } => {
            good!(state.spend(5));
            good!(super::units::read(state, host, slots(code, list), slots(code, targets), again, frame));
        }
        Instruction::Trace { statement } => {
            if let Some(text) = code.statements.get(usize::from(statement)) {
                host.trace(crate::host::TraceStep::Statement(shown(code), text));
            }
        }
    }
    Ok(NextInstruction::Step)
}

#[inline(never)]
fn element_slow(state: &mut MacroState, frame: &mut [MacroValue], to: Slot, a: Slot, index: Slot) -> Outcome<()> {
    let position = real(frame, index)?;
    let value = data::element(state, get(frame, a), &[state::whole(position)])?;
    state.made(&value)?;
    set(frame, to, value);
    Ok(())
}

/// The numbers of a DO: variable, end, step.
#[cold]
#[inline(never)]
fn loop_numbers(frame: &[MacroValue], variable: Slot, end: Slot) -> Outcome<(f64, f64, f64)> {
    Ok((real(frame, variable)?, real(frame, end)?, real(frame, end + 1)?))
}

/// Arithmetic that is not plain: unset values, wrong types, results that do not exist.
#[cold]
#[inline(never)]
fn arithmetic_slow(frame: &[MacroValue], a: Slot, b: Slot, work: fn(f64, f64) -> f64, divides: bool) -> Outcome<f64> {
    let (a, b) = (real(frame, a)?, real(frame, b)?);
    let result = work(a, b);
    if result.is_finite() {
        return Ok(result);
    }
    Err(if divides && b == 0.0 { divided_by_zero() } else { too_large() })
}

/// Two long values are compared element by element; a shorter text counts as filled up with blanks.
#[cold]
#[inline(never)]
fn pay_to_compare(state: &mut MacroState, frame: &[MacroValue], a: Slot, b: Slot) -> Outcome<()> {
    match (get(frame, a), get(frame, b)) {
        (MacroValue::Text(x), MacroValue::Text(y)) => state.spend(x.len().max(y.len()) / 64),
        (MacroValue::Sequence(x), MacroValue::Sequence(y)) if x.len() == y.len() => {
            state::pay_to_look_inside(state, x)?;
            state::pay_to_look_inside(state, y)
        }
        _ => Ok(()),
    }
}

#[cold]
#[inline(never)]
fn compare_slow(a: &MacroValue, b: &MacroValue, relation: Relation) -> Outcome<bool> {
    let message = || format!("{} and {} cannot be compared this way", a.kind_name(), b.kind_name());
    let fault = || MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, message());
    if let Relation::Equal | Relation::NotEqual = relation {
        let equal = a.equals(b).ok_or_else(fault)?;
        return Ok(equal == (relation == Relation::Equal));
    }
    let order = a.order(b).ok_or_else(fault)?;
    Ok(match relation {
        Relation::Less => order.is_lt(),
        Relation::LessEqual => order.is_le(),
        Relation::Greater => order.is_gt(),
        _ => order.is_ge(),
    })
}

fn call(
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    frame: &[MacroValue],
    function: u16,
    list: u16,
) -> Outcome<MacroValue> {
    state.spend(3)?;
    let Some(function) = code.functions.get(usize::from(function)).copied() else { return Ok(MacroValue::Null) };
    let mut arguments = std::mem::take(&mut state.buffer);
    arguments.clear();
    arguments.extend(slots(code, list).iter().map(|slot| get(frame, *slot).clone()));
    for argument in &arguments {
        state::pay_to_look(state, argument)?;
    }
    let result = match function.way {
        EvaluationMethod::Compute(compute) | EvaluationMethod::Pair(_, compute) => {
            compute(&mut FunctionContext { state, host }, &arguments)
        }
        EvaluationMethod::Host(by) => check(function, &arguments).and_then(|()| host.function(state, by, &arguments)),
        EvaluationMethod::Math(_) | EvaluationMethod::Missing(_) => Ok(MacroValue::Null),
    };
    arguments.clear();
    state.buffer = arguments;
    match result {
        Ok(value) if !finite(&value) => {
            let message = format!("the result of {} is not a number", function.name);
            Err(MacroFault::new(DiagnosticNumber::BAD_ARITHMETIC, message))
        }
        result => result,
    }
}

/// Numbers that overflow never get into a variable.
fn finite(value: &MacroValue) -> bool {
    match value {
        MacroValue::Real(number) => number.is_finite(),
        MacroValue::Sequence(elements) => {
            elements.iter().all(|e| !matches!(e, MacroValue::Real(number) if !number.is_finite()))
        }
        _ => true,
    }
}

/// Checks the types of arguments for the host.
fn check(function: &'static crate::func::BuiltInFunction, arguments: &[MacroValue]) -> Outcome<()> {
    for (position, value) in arguments.iter().enumerate() {
        if let Some(kind) = value.kind()
            && !crate::func::fits(function.letter(position), kind)
        {
            let message = format!("argument {} of {} cannot be {}", position + 1, function.name, value.kind_name());
            return Err(MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, message));
        }
    }
    Ok(())
}
