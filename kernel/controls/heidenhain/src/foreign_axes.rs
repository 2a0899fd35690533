//! Axis words in statements that take none: cycles of single values, tool calls and definitions, STOP and resets.
//!
//! Decision: such a block is an error, as every block whose words do not belong to its statement; no manual shows one,
//! and the dialogs of the control offer no such word. *Invariant:* no word of such a statement moves an axis or becomes
//! a value of it.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::path_state::{AXES, axis};
use super::words::EvaluatedWord;

/// Cycles of single values that name no axes.
const VALUES_ONLY: [u32; 4] = [9, 11, 13, 32];
/// The tilted plane by angles of rotary axes.
const PLANE: u32 = 19;

/// Refuses axis words with values in a statement that takes none.
pub(super) fn refuse_axes(host: &mut dyn InterpreterHost, statement: &str, seen: &[EvaluatedWord]) -> Result<(), Halt> {
    refuse(host, statement, seen, |_| true)
}

/// Refuses axis words that a cycle of several lines does not take.
pub(super) fn refuse_axes_of_cycle(
    host: &mut dyn InterpreterHost,
    cycle: u32,
    seen: &[EvaluatedWord],
) -> Result<(), Halt> {
    let name = format!("cycle {cycle}");
    match cycle {
        PLANE => refuse(host, &name, seen, |at| !matches!(AXES.get(at), Some(&("A" | "B" | "C")))),
        cycle if VALUES_ONLY.contains(&cycle) => refuse_axes(host, &name, seen),
        _ => Ok(()),
    }
}

fn refuse(
    host: &mut dyn InterpreterHost,
    statement: &str,
    seen: &[EvaluatedWord],
    foreign: fn(usize) -> bool,
) -> Result<(), Halt> {
    let is_foreign =
        |word: &&EvaluatedWord| word.value.is_some() && axis(&word.name).is_some_and(|(at, _)| foreign(at));
    let Some(word) = seen.iter().find(is_foreign) else { return Ok(()) };
    let text = format!("{statement} takes no word {} in '{}'", word.own_text(), host.block_text());
    Err(host.alarm(&diag::STATEMENT_UNKNOWN, text))
}
