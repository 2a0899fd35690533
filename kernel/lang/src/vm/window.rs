//! The slots that fast instructions reach, and the place of the next instruction.

use crate::bytecode::fast::WINDOW;
use crate::bytecode::{CompiledMacro, Target};
use crate::state::MacroFrame;
use crate::value::MacroValue;

/// The registers that short forms name.
pub(super) type Window = [MacroValue; WINDOW];

/// Where the loop is: the running macro, its frame and the next instruction.
pub(super) struct InstructionCursor<'a, 'p> {
    pub(super) code: &'p CompiledMacro,
    pub(super) frame: &'a mut Box<MacroFrame>,
    pub(super) at: usize,
}

/// Ticks left after a jump from `at`: a jump back costs the instructions it goes back over.
#[inline(always)]
pub(super) fn passed(at: usize, target: Target, ticks: u64) -> Option<u64> {
    let target = usize::from(target);
    if target > at { Some(ticks) } else { ticks.checked_sub((at - target) as u64 + 1) }
}

/// Position of a 1-based index; an index below 1 or too large lies after every end.
#[inline(always)]
pub(super) fn position(index: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let whole = index as u32;
    whole.wrapping_sub(1) as usize
}
