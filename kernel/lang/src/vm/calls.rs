//! Entering and leaving macros.

use super::{End, State, report, run};
use crate::bytecode::{Code, Slot};
use crate::compile::Program;
use crate::diag::Number;
use crate::fault::Fault;
use crate::host::Host;
use crate::source::Span;
use crate::value::{Kind, Value};

/// What a macro gets.
pub(super) enum Arguments<'a> {
    /// `$P1` and on, written back.
    Numbered(&'a mut [Value]),
    /// Parameters of a function.
    Parameters(&'a [Value], &'a [Slot]),
}

/// Runs a macro to its end; faults are reported here.
pub(super) fn enter(
    program: &Program,
    state: &mut State,
    host: &mut dyn Host,
    code: &Code,
    index: u16,
    mut arguments: Arguments<'_>,
) -> End {
    let slot = usize::from(index);
    if state.frames.len() <= slot {
        state.frames.resize_with(slot + 1, || Some(Vec::new()));
    }
    let entry = code.places.first().copied().unwrap_or_default();
    if let Err(fault) = may_enter(program, state, index) {
        report(code, entry, fault, 8, state, host);
        return End::Error;
    }
    let mut frame = state.frames.get_mut(slot).and_then(Option::take).unwrap_or_default();
    prepare(code, &mut frame);
    if let Some((result, _)) = code.result {
        run::set(&mut frame, result, Value::Null);
    }
    let tracing = !code.statements.is_empty();
    if tracing {
        host.trace(&format!(" Macro:* Entering {}", code.name));
        state.names.push(code.name.clone());
    }
    state.depth += 1;
    let end = match fill(code, &mut frame, &arguments) {
        Ok(()) => body(program, state, host, code, &mut frame),
        Err(fault) => fail(state, host, code, entry, fault),
    };
    state.depth -= 1;
    if tracing {
        state.names.pop();
        let back = state.names.last().map_or("regular processing", String::as_str);
        host.trace(&format!(" Macro:* Leaving {}, Returning to {back}", code.name));
    }
    if let Arguments::Numbered(values) = &mut arguments {
        for (number, slot) in &code.arguments {
            if let (Some(value), Some(register)) =
                (values.get_mut(usize::from(*number) - 1), frame.get(usize::from(*slot)))
            {
                *value = register.clone();
            }
        }
    }
    if let Some(place) = state.frames.get_mut(slot) {
        *place = Some(frame);
    }
    end
}

/// Result of the last run of a function.
pub(super) fn result<'a>(state: &'a State, code: &Code, index: u16) -> &'a Value {
    static NULL: Value = Value::Null;
    match (code.result, state.frames.get(usize::from(index))) {
        (Some((slot, _)), Some(Some(frame))) => run::get(frame, slot),
        _ => &NULL,
    }
}

/// Refuses a macro that is running already, and too many macros at once.
pub(super) fn may_enter(program: &Program, state: &State, index: u16) -> Result<(), Fault> {
    if state.depth >= state.limits.depth {
        return Err(Fault::new(Number::DEPTH, format!("more than {} macros are active", state.limits.depth)));
    }
    if matches!(state.frames.get(usize::from(index)), Some(None)) {
        let name = program.macros.get(usize::from(index)).map_or("the macro", |code| code.name.as_str());
        return Err(Fault::new(Number::RE_ENTERED, format!("{name} is running already")));
    }
    Ok(())
}

fn prepare(code: &Code, frame: &mut Vec<Value>) {
    if frame.len() != code.registers {
        frame.clear();
        frame.resize(code.registers, Value::Unset);
        for (slot, value) in &code.constants {
            if let Some(register) = frame.get_mut(usize::from(*slot)) {
                *register = value.clone();
            }
        }
    } else {
        for slot in &code.locals {
            match frame.get_mut(usize::from(*slot)) {
                Some(Value::Unset) | None => {}
                Some(register) => *register = Value::Unset,
            }
        }
    }
}

fn fill(code: &Code, frame: &mut [Value], arguments: &Arguments<'_>) -> Result<(), Fault> {
    match arguments {
        Arguments::Numbered(values) => {
            for (number, slot) in &code.arguments {
                if let (Some(value), Some(register)) =
                    (values.get(usize::from(*number) - 1), frame.get_mut(usize::from(*slot)))
                {
                    *register = value.clone();
                }
            }
        }
        Arguments::Parameters(caller, given) => {
            for ((slot, kind), from) in code.parameters.iter().zip(*given) {
                if let Some(number) = run::number(caller, *from)
                    && kind.is_none_or(|kind| kind == Kind::Real)
                {
                    run::set_number(frame, *slot, number);
                    continue;
                }
                let value = run::get(caller, *from);
                let value = match kind {
                    Some(kind) => super::data::typed(value, *kind)?,
                    None => value.clone(),
                };
                run::set(frame, *slot, value);
            }
        }
    }
    Ok(())
}

fn body(program: &Program, state: &mut State, host: &mut dyn Host, code: &Code, frame: &mut [Value]) -> End {
    match run::run(program, state, host, code, frame) {
        Ok(()) => {
            let typed = code.result.and_then(|(slot, kind)| Some((frame.get(usize::from(slot))?, kind?)));
            match typed {
                Some((value, kind)) if !matches!(value, Value::Null) && value.kind() != Some(kind) => {
                    let message = format!("the result is of type {}, not {}", value.kind_name(), kind.name());
                    let place = code.places.last().copied().unwrap_or_default();
                    fail(state, host, code, place, Fault::new(Number::TYPED_STORE, message))
                }
                _ => End::Normal,
            }
        }
        Err(run::Stop::Fault(at, fault)) => {
            let place = code.places.get(at).copied().unwrap_or_default();
            fail(state, host, code, place, fault)
        }
        Err(run::Stop::Raised(at)) => {
            let place = code.places.get(at).copied().unwrap_or_default();
            ended(state, host, code, place);
            End::Error
        }
        Err(run::Stop::Budget) => End::Budget,
    }
}

/// Reports a fault and ends the macro.
fn fail(state: &mut State, host: &mut dyn Host, code: &Code, place: Span, fault: Fault) -> End {
    let budget = fault.number == Number::TICKS;
    report(code, place, fault, 8, state, host);
    ended(state, host, code, place);
    if budget { End::Budget } else { End::Error }
}

fn ended(state: &mut State, host: &mut dyn Host, code: &Code, place: Span) {
    let fault = Fault::new(Number::TERMAC_GENERATED, "TERMAC generated due to error(s).");
    report(code, place, fault, 0, state, host);
}
