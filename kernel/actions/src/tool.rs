//! Tools: preselect, load, offsets.
//!
//! Facts: reference control-emulator.md 6.3; time of a turret by its steps, channel-synchronisation.md 3.

use counterpoint_event::event::ToolAction;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, DiagnosticFacts};
use counterpoint_machine::ident::{codes, data};

use super::tool_offsets::{has_no_values, missing_among_listed};
use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_channel::modal::group;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::TOOL_SELECT], |act, _, _| select(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::TOOL_LOAD], |act, _, _| load(act)),
];

/// Preselects a tool.
pub(crate) fn select(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(word) = tool_word(act) else { return Ok(()) };
    let (tool, offset) = split(act, word);
    act.channel_mut().state.place.tools.chosen = true;
    act.tool_event(ToolAction::Select, tool, offset, 0)
}

/// Loads a tool, or changes only its offset when the tool is already in use.
pub(crate) fn load(act: &mut ActionContext<'_, '_>) -> Acted {
    // Tool 0 empties the spindle. If the word has an offset number, T0000 cancels the offset and the turret does not
    // turn.
    let empties = act.channel().env.machine.tool.offset_digits == 0;
    let (tool, offset) = match tool_word(act) {
        Some(word) => split(act, word),
        None if act.channel().state.place.tools.chosen || act.channel().state.place.tools.selected > 0 => (
            act.channel().state.place.tools.selected,
            if empties { 0 } else { act.channel().state.place.in_force.tool_offset },
        ),
        None => {
            let text = format!("no tool is selected for '{}'", act.channel().block_text());
            act.diagnose(&diag::DATA_MISSING, text);
            return Ok(());
        }
    };
    let changes = tool != act.channel().state.place.tools.current && (tool != 0 || empties);
    let seconds = if changes { change_seconds(act, tool) } else { 0.0 };
    let action = if changes { ToolAction::Load } else { ToolAction::Offset };
    let ns = counterpoint_channel::at::nanoseconds(seconds);
    act.note_effect();
    if changes && act.channel().env.machine.tool.change_motion {
        super::change_point::before_load(act)?;
    }
    act.tool_event(action, tool, offset, ns)?;
    if act.channel().env.machine.tool.offset_digits > 0 {
        missing_offset(act, offset);
        let other = act.channel().state.place.in_force.tool_offset != offset;
        act.channel_mut().state.place.in_force.tool_offset = offset;
        act.reframe();
        // Compensation continues with the nose of the new offset.
        if other
            && let Some(code @ (codes::COMP_DIAM_LEFT | codes::COMP_DIAM_RIGHT)) =
                act.channel().state.modal.code(group::DIAMETER)
        {
            super::cutter::switched(act, code)?;
        }
    }
    if empties && act.channel().state.place.in_force.tool_offset != 0 {
        // The offset of a tool word of another component of the machine ends with its tool.
        act.channel_mut().state.place.in_force.tool_offset = 0;
        act.reframe();
    }
    act.report_tool();
    Ok(())
}

/// Reports a tool offset that has no values; on a machine without any tool offsets once, as a remark.
fn missing_offset(act: &mut ActionContext<'_, '_>, offset: u32) {
    let machine = act.channel().env.machine;
    if !machine.tool.offsets.is_empty() {
        missing_among_listed(act, offset);
    } else if has_no_values(act, offset)
        && !std::mem::replace(&mut act.channel_mut().state.place.tools.offsets_reported, true)
    {
        let text = format!(
            "machine {} has no tool offsets: offset {offset} of '{}' and all others are zero",
            machine.name,
            act.channel().block_text()
        );
        act.diagnose(&DiagnosticFacts { severity: 0, ..diag::NO_OFFSET }, text);
    }
}

fn tool_word(act: &mut ActionContext<'_, '_>) -> Option<f64> {
    act.take(data::TOOL).map(|d| d.value).filter(|v| (0.0..=99_999_999.0).contains(v))
}

/// Tool and offset number of a tool word.
fn split(act: &ActionContext<'_, '_>, word: f64) -> (u32, u32) {
    let word = word as u32;
    let digits = u32::from(act.channel().env.machine.tool.offset_digits);
    match 10_u32.checked_pow(digits) {
        Some(power) if digits > 0 => (word / power, word % power),
        _ => (word, 0),
    }
}

/// Constant part, plus the steps of the turret the shorter way round.
fn change_seconds(act: &ActionContext<'_, '_>, tool: u32) -> f64 {
    let time = &act.channel().env.machine.time;
    let stations = time.stations;
    let steps = if stations > 0 {
        let from = act.channel().state.place.tools.current.saturating_sub(1) % stations;
        let to = tool.saturating_sub(1) % stations;
        let ahead = (to + stations - from) % stations;
        ahead.min(stations - ahead)
    } else {
        0
    };
    time.tool_change + time.tool_step * f64::from(steps)
}
