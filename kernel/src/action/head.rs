//! Heads: which one is in work, and the events of codes that only macros handle.
//!
//! Facts: reference control-emulator.md 4.3, 6.3. Decision: codes of heads without built-in processing raise the tool
//! event; on a machine without its macro they are passed over with a message.

use crate::channel::Kernel;
use crate::diag;
use crate::machine::ident::{CodeId, code_facts, data};
use crate::machine::model::CodeRow;
use counterpoint_fault::Acted;

/// The event of a code: `$P1` of the tool macro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Event {
    /// A head is made ready.
    Select,
    /// It is loaded, changed or put back.
    Load,
}

/// Event of a code of heads without built-in processing.
pub(super) fn of(id: CodeId) -> Option<Event> {
    let name = code_facts(id)?.name.strip_prefix("CODE_HEAD_")?;
    let ready = ["SELECT", "PICKUP", "CHAIN", "GRIPPER"].iter().any(|word| name.starts_with(word));
    Some(if ready { Event::Select } else { Event::Load })
}

/// Loads a head: main 1, side 2, or the one that the word names.
pub(super) fn load(kernel: &mut Kernel<'_>, number: Option<u32>) -> Acted {
    let word = number.map(f64::from).or_else(|| kernel.take(data::HEAD_ID).map(|d| d.value));
    let Some(id) = word.and_then(valid) else {
        let text = format!("no head is named in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    kernel.channel.state.others.head = id;
    kernel.head_event(2.0, id)
}

/// Raises the event of another code of heads.
pub(super) fn other(kernel: &mut Kernel<'_>, event: Event, row: &CodeRow) -> Acted {
    if !kernel.has_tool_macro() {
        kernel.without_action(row.id);
        return Ok(());
    }
    let word = kernel.take(data::HEAD_ID).or_else(|| kernel.take(data::HEAD)).map(|d| d.value);
    let kind = if event == Event::Select { 1.0 } else { 2.0 };
    kernel.head_event(kind, word.and_then(valid).unwrap_or(0))
}

fn valid(id: f64) -> Option<u32> {
    (0.0..=99_999_999.0).contains(&id).then_some(id as u32)
}
