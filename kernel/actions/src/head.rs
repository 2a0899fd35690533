//! Heads: which one is active, and the events of codes that only macros handle.
//!
//! Facts: reference control-emulator.md 4.3, 6.3. Decision: codes of heads without built-in processing raise the tool
//! event; on a machine without its macro they are ignored with a message.

use crate::context::ActionContext;
use crate::entry::{ActionEntry, entry_of_kind};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::data;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::head::HeadEvent;
use counterpoint_machine::rows::CodeRow;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::HEAD_MAIN], |act, _, _| load(act, Some(1))),
    ActionEntry::of(&[codes::HEAD_SIDE], |act, _, _| load(act, Some(2))),
    ActionEntry::of(&[codes::HEAD_ID], |act, _, _| load(act, None)),
    entry_of_kind!(CodeKind::Head(event) => |act, row, _code| other(act, event, row)),
];

/// Loads a head: main 1, side 2, or the head that the word names.
pub(crate) fn load(act: &mut ActionContext<'_, '_>, number: Option<u32>) -> Acted {
    let word = number.map(f64::from).or_else(|| act.take(data::HEAD_ID).map(|d| d.value));
    let Some(id) = word.and_then(valid) else {
        let text = format!("no head is named in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    act.channel_mut().state.others.head = id;
    act.head_event(2.0, id)
}

/// Raises the event of another code of heads.
pub(crate) fn other(act: &mut ActionContext<'_, '_>, event: HeadEvent, row: &CodeRow) -> Acted {
    if !act.has_tool_macro() {
        act.without_action(row.id);
        return Ok(());
    }
    let word = act.take(data::HEAD_ID).or_else(|| act.take(data::HEAD)).map(|d| d.value);
    let kind = if event == HeadEvent::Select { 1.0 } else { 2.0 };
    act.head_event(kind, word.and_then(valid).unwrap_or(0))
}

fn valid(id: f64) -> Option<u32> {
    (0.0..=99_999_999.0).contains(&id).then_some(id as u32)
}
