//! Finds the calls of small functions that can be executed in registers of the caller.
//!
//! *Invariant:* a function is inlined only if it touches nothing but its own registers and never jumps back. So
//! abandoning it and calling it gives the same result as the call alone, and costs the same steps.

use super::MacroProgram;
use crate::bytecode::body::{Body, FormEffect, near};
use crate::bytecode::fast::{Fast, Near, WINDOW};
use crate::bytecode::{CompiledMacro, Slot};
use crate::value::MacroValue;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Instructions of a function that is executed in its caller.
const MOST: usize = 32;
/// Calls of a macro that are executed in it.
const MOST_CALLS: usize = 64;

/// Looks at the calls of all macros from `first` on.
pub(super) fn link(program: &mut MacroProgram, first: usize) {
    for index in first..program.macros.len() {
        let Some(caller) = program.macros.get(index).cloned() else { continue };
        let mut room =
            InlineRegisters { registers: caller.registers.count, known: FxHashMap::default(), constants: Vec::new() };
        let mut bodies = Vec::new();
        let mut forms = Vec::new();
        for (at, form) in caller.short.forms.iter().enumerate() {
            if let Fast::Call { to, callee, list } = *form
                && caller.statements.is_empty()
                && bodies.len() < MOST_CALLS
                && let Some(function) = program.macros.get(usize::from(callee))
                && let Some(body) = body(&caller, function, (callee, list), &mut room)
            {
                forms.push((at, Fast::Inline { to, body: bodies.len() as u16 }));
                bodies.push(body);
            }
        }
        drop(caller);
        let Some(place) = program.macros.get_mut(index).filter(|_| !bodies.is_empty()) else { continue };
        let code = Arc::make_mut(place);
        code.registers.count = room.registers;
        code.registers.constants.extend(room.constants);
        code.short.bodies = bodies;
        for (at, form) in forms {
            if let Some(place) = code.short.forms.get_mut(at) {
                *place = form;
            }
        }
    }
}

/// The code with nothing but calls.
pub(super) fn undone(code: &CompiledMacro) -> CompiledMacro {
    let mut code = code.clone();
    for form in &mut code.short.forms {
        if let Fast::Inline { to, body } = *form {
            let body = code.short.bodies.get(usize::from(body));
            *form = body.map_or(Fast::None, |body| Fast::Call { to, callee: body.callee, list: body.list });
        }
    }
    code.short.bodies.clear();
    code
}

/// Registers of a caller that its bodies use, by function and its own register.
struct InlineRegisters {
    registers: usize,
    known: FxHashMap<(u16, Near), Near>,
    constants: Vec<(Slot, MacroValue)>,
}

impl InlineRegisters {
    /// The register that replaces one of a function; constants have their value.
    fn of(&mut self, callee: u16, own: Near, function: &CompiledMacro) -> Option<Near> {
        if let Some(known) = self.known.get(&(callee, own)) {
            return Some(*known);
        }
        let slot = near(Slot::try_from(self.registers).ok()?).filter(|slot| usize::from(*slot) < WINDOW)?;
        self.registers += 1;
        self.known.insert((callee, own), slot);
        let constant = function.registers.constants.iter().find(|(slot, _)| *slot == Slot::from(own));
        self.constants.extend(constant.map(|(_, value)| (Slot::from(slot), value.clone())));
        Some(slot)
    }
}

fn body(
    caller: &CompiledMacro,
    function: &CompiledMacro,
    (callee, list): (u16, u16),
    room: &mut InlineRegisters,
) -> Option<Body> {
    let plain = function.signature.is_function && function.statements.is_empty() && function.shared.is_empty();
    if !plain || function.ops.len() > MOST || function.short.forms.is_empty() {
        return None;
    }
    let given =
        caller.lists.get(usize::from(list)).filter(|given| given.len() == function.signature.parameters.len())?;
    let effects = effects(function)?;
    let written = |slot: Slot| effects.iter().any(|effect| effect.writes.map(Slot::from) == Some(slot));
    let (result, kind) = function.signature.result?;
    let mut arguments = FxHashMap::default();
    let (mut typed, mut copied) = (Vec::new(), Vec::new());
    for ((slot, kind), from) in function.signature.parameters.iter().zip(given) {
        let from = near(*from)?;
        typed.extend(kind.map(|kind| (from, kind)));
        if written(*slot) {
            copied.push((room.of(callee, near(*slot)?, function)?, from));
        } else {
            arguments.insert(near(*slot)?, from);
        }
    }
    let mut place = |own: Near| match arguments.get(&own) {
        Some(argument) => Some(*argument),
        None => room.of(callee, own, function),
    };
    let forms: Option<Vec<Fast>> = function.short.forms.iter().map(|form| Some(form.moved(&mut place)?.0)).collect();
    let (forms, result) = (forms?, near(result)?);
    let mut cleared = Vec::new();
    for local in &function.registers.locals {
        let local = near(*local)?;
        if is_read_first(&effects, local, false) {
            cleared.push(place(local)?);
        }
    }
    let is_null_first = is_read_first(&effects, result, true);
    Some(Body { callee, list, forms, typed, copied, cleared, result: place(result)?, kind, is_null_first })
}

/// Effects of the forms of a function; none unless they only use its registers and never jump back.
fn effects(function: &CompiledMacro) -> Option<Vec<FormEffect>> {
    let all = function.short.forms.iter().enumerate().map(|(at, form)| {
        let (_, effect) = form.moved(&mut Some)?;
        effect.target.is_none_or(|target| usize::from(target) >= at + effect.length).then_some(effect)
    });
    all.collect()
}

/// Whether a register may be read before anything is written to it; at the end of the function, too, if that counts.
fn is_read_first(effects: &[FormEffect], register: Near, end_counts: bool) -> bool {
    // Whether it is written before each form, on every way there; none where no way leads.
    let mut before = vec![None; effects.len()];
    if let Some(first) = before.first_mut() {
        *first = Some(false);
    }
    for (at, effect) in effects.iter().enumerate() {
        let Some(is_written) = before.get(at).copied().flatten() else { continue };
        let ends = end_counts && !effect.falls && effect.target.is_none();
        if !is_written && (ends || effect.reads.contains(&Some(register))) {
            return true;
        }
        let after = is_written || effect.writes == Some(register);
        let next = effect.falls.then_some(at + effect.length);
        for next in [next, effect.target.map(usize::from)].into_iter().flatten() {
            if let Some(place) = before.get_mut(next) {
                *place = Some(place.unwrap_or(true) && after);
            }
        }
    }
    false
}
