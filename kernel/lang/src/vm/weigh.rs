//! Weighing the values that macros can reach.

use crate::bytecode::CompiledMacro;
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::host::MacroHost;
use crate::program::MacroProgram;
use crate::state::memory::{MemoryTally, PER_TICK};
use crate::state::{MacroFrame, MacroState};
use std::sync::Arc;

/// Weighs everything that macros can reach.
///
/// # Errors
/// It is more than the budget, or there are no ticks for it.
#[cold]
#[inline(never)]
pub(super) fn weigh(
    program: &MacroProgram,
    state: &mut MacroState,
    host: &dyn MacroHost,
    frame: &MacroFrame,
) -> Outcome<()> {
    let mut scale = MemoryTally::default();
    let name =
        |index: u16| program.macros.get(usize::from(index)).map_or("", |code: &Arc<CompiledMacro>| code.name.as_str());
    let macro_name = |index: u16| move || format!("variables of the macro {}", name(index));
    for (index, value) in (0..).zip(&state.objects.values) {
        let from = scale.bytes;
        scale.add(value);
        scale.held_by(from, || format!("the OBJECT variable {}", program.object_name(index)));
    }
    for frame in state.calls.frames.iter().flatten() {
        let from = scale.bytes;
        frame.registers.iter().for_each(|value| scale.add(value));
        scale.held_by(from, macro_name(frame.index));
    }
    let from = scale.bytes;
    state.units.values().for_each(|unit| scale.weigh(unit.bytes()));
    scale.held_by(from, || "open files of macros".to_owned());
    host.held(&mut scale);
    let kept = scale.bytes;
    let mut waiting = Some(frame);
    while let Some(frame) = waiting {
        let from = scale.bytes;
        frame.registers.iter().for_each(|value| scale.add(value));
        scale.held_by(from, macro_name(frame.index));
        waiting = frame.caller.as_deref();
    }
    let memory = &mut state.memory;
    (memory.kept, memory.running, memory.fresh) = (kept, scale.bytes - kept, 0);
    let all = memory.outer + scale.bytes;
    memory.room = memory.limit.saturating_sub(all);
    if memory.room < memory.limit / 8 {
        let text = format!("macros keep more than {} bytes, most of them in {}", memory.limit, scale.largest.1);
        memory.over = Some(scale.largest.1);
        return Err(MacroFault::new(DiagnosticNumber::MEMORY, text));
    }
    state.spend(scale.visited / PER_TICK)
}
