//! The loop over the instructions of a macro and of the functions it calls.
//!
//! *Invariant:* a call costs no stack of the computer, its caller waits in a list; short forms have exactly the results
//! of [`super::step`], or are not taken.

use super::calls;
use super::fast;
use super::slots::{MacroStop, NextInstruction, set, slots};
use super::window::{InstructionCursor, passed};
use super::{MacroEnd, report, step, weigh};
use crate::bytecode::{CompiledMacro, Instruction, Slot, Target};
use crate::fault::MacroFault;
use crate::host::MacroHost;
use crate::program::MacroProgram;
use crate::state::{MacroFrame, MacroState};
use crate::value::MacroValue;
use std::sync::Arc;

/// Why the loop pauses without a fault.
enum RunPause {
    /// The macro is at its end.
    End,
    /// A call: register of the result, function, registers of the arguments.
    Call(Slot, u16, u16),
}

/// Runs a macro that has been entered, with everything it calls.
pub(super) fn run(
    program: &MacroProgram,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    frame: &mut Box<MacroFrame>,
) -> MacroEnd {
    let Some(code) = program.macros.get(usize::from(frame.index)).map(Arc::as_ref) else { return MacroEnd::Error };
    let mut place = InstructionCursor { code, frame, at: 0 };
    loop {
        let end = match execute(program, state, host, &mut place) {
            Ok(RunPause::Call(to, callee, list)) => match calls::call(program, state, callee) {
                Ok((function, called)) => {
                    let waiting = std::mem::replace(place.frame, called);
                    let given = slots(place.code, list);
                    let filled = calls::fill(function, &mut place.frame.registers, &waiting.registers, given);
                    place.frame.wait(waiting, place.at, to);
                    (place.code, place.at) = (function, 0);
                    calls::begin(state, host, function);
                    match filled {
                        Ok(()) => continue,
                        Err(fault) => calls::stopped(state, host, function, MacroStop::Fault(0, fault)),
                    }
                }
                Err(fault) => calls::stopped(state, host, place.code, MacroStop::Fault(place.at, *fault)),
            },
            Ok(RunPause::End) => calls::finished(state, host, place.code, &place.frame.registers),
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
                None => return MacroEnd::Error,
            }
            if end != MacroEnd::Budget {
                break;
            }
        }
    }
}

/// Ticks after which a stop of the run is looked at.
const LOOK_EVERY: u64 = 10_000;

/// Runs until the macro calls a function that needs more than the short form of a call, or ends.
fn execute<'p>(
    program: &'p MacroProgram,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    place: &mut InstructionCursor<'_, 'p>,
) -> Result<RunPause, Box<MacroStop>> {
    loop {
        fast::run(program, state, host, place);
        if state.looked.abs_diff(state.ticks) >= LOOK_EVERY {
            state.looked = state.ticks;
            if host.stopped() {
                return Err(Box::new(MacroStop::Fault(place.at, stopped(state))));
            }
        }
        let (code, at) = (place.code, place.at);
        match code.ops.get(at) {
            None | Some(Instruction::Return) => return Ok(RunPause::End),
            Some(Instruction::CallMacro { to, callee, list }) => return Ok(RunPause::Call(*to, *callee, *list)),
            Some(_) => {}
        }
        if state.is_vague() && matches!(code.ops.get(at), Some(Instruction::Command { .. } | Instruction::Call { .. }))
        {
            weigh::weigh(program, state, host, place.frame).map_err(|fault| Box::new(MacroStop::Fault(at, fault)))?;
        }
        match step::step(state, host, code, &mut place.frame.registers, at) {
            Ok(NextInstruction::Step) => place.at += 1,
            Ok(NextInstruction::Jump(target)) => match passed(at, target, state.ticks + traces(code, target, at)) {
                Some(left) => (place.at, state.ticks) = (usize::from(target), left),
                None => return Err(Box::new(MacroStop::Fault(at, used_up(state)))),
            },
            Err(stop) => return Err(Box::new(stop)),
        }
        if state.is_full() {
            weigh::weigh(program, state, host, place.frame).map_err(|fault| Box::new(MacroStop::Fault(at, fault)))?;
        }
    }
}

/// Trace instructions that a backward jump crosses: they cost no steps, so a trace does not change the run.
fn traces(code: &CompiledMacro, target: Target, at: usize) -> u64 {
    if code.statements.is_empty() {
        return 0;
    }
    let over = code.ops.get(usize::from(target)..=at).unwrap_or(&[]);
    over.iter().filter(|op| matches!(op, Instruction::Trace { .. })).count() as u64
}

/// The run is to end: no macro continues.
#[cold]
#[inline(never)]
fn stopped(state: &mut MacroState) -> MacroFault {
    state.ticks = 0;
    MacroFault::new(crate::diag::DiagnosticNumber::TICKS, "the run is stopped")
}

#[cold]
#[inline(never)]
fn used_up(state: &mut MacroState) -> MacroFault {
    match state.spend(usize::MAX) {
        Err(fault) => fault,
        Ok(()) => MacroFault::new(crate::diag::DiagnosticNumber::TICKS, "the budget of steps is exhausted"),
    }
}

/// Runs a macro to its end; faults are reported here. `arguments` are `$P1` and on, written back.
pub(super) fn enter(
    program: &MacroProgram,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    code: &CompiledMacro,
    index: u16,
    arguments: &mut [MacroValue],
) -> MacroEnd {
    let mut frame = match calls::take(program, state, code, index) {
        Ok(frame) => frame,
        Err(fault) => {
            report(code, code.places.first().copied().unwrap_or_default(), *fault, 8, state, host);
            return MacroEnd::Error;
        }
    };
    let registers = frame.registers.as_mut_slice();
    for (slot, _) in &code.signature.parameters {
        set(registers, *slot, MacroValue::Unset);
    }
    for (number, slot) in &code.signature.arguments {
        if let Some(value) = arguments.get(usize::from(*number) - 1) {
            set(registers, *slot, value.clone());
        }
    }
    let outer = (state.depth > 0).then(|| state.inner_begins());
    calls::begin(state, host, code);
    let end = run(program, state, host, &mut frame);
    calls::leave(state, host, code);
    if let Some(outer) = outer {
        state.inner_ended(outer);
    }
    for (number, slot) in &code.signature.arguments {
        if let (Some(value), Some(register)) =
            (arguments.get_mut(usize::from(*number) - 1), frame.registers.get(usize::from(*slot)))
        {
            *value = register.clone();
        }
    }
    calls::put_back(state, frame);
    end
}
