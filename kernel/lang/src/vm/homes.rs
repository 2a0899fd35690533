//! Homes of shared variables: registers that hold them while short forms run.
//!
//! *Invariant:* a variable changes places with its home when a short form first needs it, and is back in its own place
//! before anything but short forms of the same macro can look at it.

use super::window::Window;
use crate::bytecode::fast::Fast;
use crate::bytecode::{CompiledMacro, Instruction, SharedVariable};
use crate::host::MacroHost;
use crate::state::MacroState;
use crate::value::MacroValue;

/// Place of a shared variable while no other kernel runs.
fn shared_place<'a>(
    state: &'a mut MacroState,
    host: &'a mut dyn MacroHost,
    shared: SharedVariable,
) -> Option<&'a mut MacroValue> {
    match shared {
        SharedVariable::Object(index) => state.object(index),
        SharedVariable::Global(index) => host.own_global(index),
    }
}

impl MacroState {
    /// Whether a shared variable lies in its home.
    #[inline(always)]
    pub(super) fn is_at_home(&self, shared: u8) -> bool {
        self.objects.at_home >> (shared & 63) & 1 != 0
    }
}

/// Brings the shared variable of an instruction home; false if it is there or cannot be.
#[inline(never)]
pub(super) fn bring(
    code: &CompiledMacro,
    at: usize,
    state: &mut MacroState,
    host: &mut dyn MacroHost,
    window: &mut Window,
) -> bool {
    if code.homes.is_empty() || code.short.forms.get(at).is_none_or(|form| *form == Fast::None) {
        return false;
    }
    let shared = match code.ops.get(at) {
        Some(
            Instruction::ReadShared { shared, .. }
            | Instruction::WriteShared { shared, .. }
            | Instruction::SharedElements { shared, .. }
            | Instruction::SetSharedElements { shared, .. },
        ) => usize::from(*shared),
        _ => return false,
    };
    if shared >= 64 || state.objects.at_home >> shared & 1 != 0 {
        return false;
    }
    let home = code.homes.get(shared).and_then(|home| window.get_mut(usize::from(*home)));
    let place = code.shared.get(shared).and_then(|(place, _)| shared_place(state, host, *place));
    let (Some(home), Some(place)) = (home, place) else { return false };
    std::mem::swap(home, place);
    state.objects.at_home |= 1 << shared;
    true
}

/// Takes all shared variables back from their homes.
#[inline(always)]
pub(super) fn take_back(code: &CompiledMacro, state: &mut MacroState, host: &mut dyn MacroHost, window: &mut Window) {
    if state.objects.at_home != 0 {
        take_all_back(code, state, host, window);
    }
}

#[inline(never)]
fn take_all_back(code: &CompiledMacro, state: &mut MacroState, host: &mut dyn MacroHost, window: &mut Window) {
    let mut at_home = std::mem::take(&mut state.objects.at_home);
    while at_home != 0 {
        let shared = at_home.trailing_zeros() as usize;
        at_home &= at_home - 1;
        let home = code.homes.get(shared).and_then(|home| window.get_mut(usize::from(*home)));
        let place = code.shared.get(shared).and_then(|(place, _)| shared_place(state, host, *place));
        if let (Some(home), Some(place)) = (home, place) {
            std::mem::swap(home, place);
        }
    }
}
