//! The loop over the instructions of a macro and of the functions it calls.
//!
//! *Invariant:* a call costs no stack of the computer, its caller waits in a list; short forms have exactly the results
//! of [`super::step`], or are not taken.

use super::calls;
use super::fast::{self, InstructionCursor};
use super::{MacroEnd, step, weigh};
use crate::bytecode::{CompiledMacro, Instruction, Relation, Slot, Target};
use crate::fault::MacroFault;
use crate::host::MacroHost;
use crate::program::MacroProgram;
use crate::state::{MacroFrame, MacroState};
use crate::value::MacroValue;
use std::sync::Arc;

/// Why a macro ends early.
pub(super) enum MacroStop {
    /// A fault at an instruction.
    Fault(usize, MacroFault),
    /// A diagnostic of severity 8 was issued by the macro itself.
    Raised(usize),
}

#[inline]
pub(super) fn number(frame: &[MacroValue], slot: Slot) -> Option<f64> {
    match frame.get(usize::from(slot)) {
        Some(MacroValue::Real(number)) => Some(*number),
        _ => None,
    }
}

#[inline]
pub(super) fn get(frame: &[MacroValue], slot: Slot) -> &MacroValue {
    static UNSET: MacroValue = MacroValue::Unset;
    frame.get(usize::from(slot)).unwrap_or(&UNSET)
}

#[inline]
pub(super) fn set(frame: &mut [MacroValue], slot: Slot, value: MacroValue) {
    if let Some(register) = frame.get_mut(usize::from(slot)) {
        *register = value;
    }
}

#[inline]
pub(super) fn set_number(frame: &mut [MacroValue], slot: Slot, number: f64) {
    if let Some(register) = frame.get_mut(usize::from(slot)) {
        put(register, number);
    }
}

/// Stores a number. The previous value is mostly a number too, so all other cases are kept out of the fast path.
#[inline(always)]
pub(super) fn put(register: &mut MacroValue, number: f64) {
    if !matches!(register, MacroValue::Real(_)) {
        become_number(register);
    }
    if let MacroValue::Real(old) = register {
        *old = number;
    }
}

#[cold]
#[inline(never)]
fn become_number(register: &mut MacroValue) {
    become_plain(register, MacroValue::Real(0.0));
}

/// Replaces a value by one that holds no memory. Most of those that were there before do not hold any either.
#[inline(always)]
pub(super) fn become_plain(register: &mut MacroValue, value: MacroValue) {
    match register {
        MacroValue::Text(_) | MacroValue::Sequence(_) | MacroValue::Array(_) => replace(register, value),
        _ => std::mem::forget(std::mem::replace(register, value)),
    }
}

/// Replaces a value that may have to give memory back.
#[inline(never)]
pub(super) fn replace(register: &mut MacroValue, value: MacroValue) {
    *register = value;
}

/// The successor of an instruction.
pub(super) enum NextInstruction {
    /// The next instruction.
    Step,
    /// Another one.
    Jump(Target),
}

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
            Ok(NextInstruction::Jump(target)) => match fast::passed(at, target, state.ticks + traces(code, target, at))
            {
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

pub(super) fn slots(code: &CompiledMacro, list: u16) -> &[Slot] {
    code.lists.get(usize::from(list)).map_or(&[], Vec::as_slice)
}

#[inline(never)]
pub(super) fn copy(frame: &mut [MacroValue], to: Slot, a: Slot) {
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
