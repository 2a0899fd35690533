//! Tools: preselect, load, offsets.
//!
//! Facts: reference control-emulator.md 6.3; time of a turret by its steps, channel-synchronisation.md 3.

use crate::channel::Kernel;
use crate::diag::{self, Facts};
use crate::log::event::ToolAction;
use crate::machine::ident::{codes, data};
use crate::state::modal::group;
use counterpoint_fault::Acted;

/// Preselects a tool.
pub(super) fn select(kernel: &mut Kernel<'_>) -> Acted {
    let Some(word) = tool_word(kernel) else { return Ok(()) };
    let (tool, offset) = split(kernel, word);
    kernel.channel.state.place.chosen = true;
    kernel.tool_event(ToolAction::Select, tool, offset, 0)
}

/// Loads a tool, or changes only its offset when it is the one in use.
pub(super) fn load(kernel: &mut Kernel<'_>) -> Acted {
    let (tool, offset) = match tool_word(kernel) {
        Some(word) => split(kernel, word),
        None if kernel.channel.state.place.chosen || kernel.channel.state.place.selected > 0 => {
            (kernel.channel.state.place.selected, kernel.channel.state.place.tool_offset)
        }
        None => {
            let text = format!("no tool is selected for '{}'", kernel.block_text());
            kernel.diagnose(&diag::DATA_MISSING, text);
            return Ok(());
        }
    };
    let changes = tool != 0 && tool != kernel.channel.state.place.tool;
    let seconds = if changes { change_seconds(kernel, tool) } else { 0.0 };
    let action = if changes { ToolAction::Load } else { ToolAction::Offset };
    let ns = crate::state::channel::nanoseconds(seconds);
    kernel.flow.pass.effects = true;
    if changes && kernel.channel.env.machine.tool.change_motion {
        super::change_point::before_load(kernel)?;
    }
    kernel.tool_event(action, tool, offset, ns)?;
    if kernel.channel.env.machine.tool.offset_digits > 0 {
        missing_offset(kernel, offset);
        let other = kernel.channel.state.place.tool_offset != offset;
        kernel.channel.state.place.tool_offset = offset;
        kernel.reframe();
        // Compensation goes on with the nose of the new offset.
        if other
            && let Some(code @ (codes::COMP_DIAM_LEFT | codes::COMP_DIAM_RIGHT)) =
                kernel.channel.state.modal.code(group::DIAMETER)
        {
            super::cutter::switched(kernel, code)?;
        }
    }
    kernel.report_tool();
    Ok(())
}

/// Tells of a tool offset that has no values; on a machine without any tool offsets once, as a remark.
fn missing_offset(kernel: &mut Kernel<'_>, offset: u32) {
    let machine = kernel.channel.env.machine;
    let offsets = &machine.tool.offsets;
    let set = kernel.channel.state.place.offsets.as_deref().is_some_and(|own| own.has_tool(offset));
    if offset == 0 || set || offsets.iter().any(|known| known.number == offset) {
        return;
    }
    if !offsets.is_empty() {
        let text = format!("tool offset {offset} has no values in machine {}, zero is used", machine.name);
        kernel.diagnose(&diag::NO_OFFSET, text);
    } else if !std::mem::replace(&mut kernel.channel.state.place.told_offsets, true) {
        let text = format!(
            "machine {} has no tool offsets: offset {offset} of '{}' and all others are zero",
            machine.name,
            kernel.block_text()
        );
        kernel.diagnose(&Facts { severity: 0, ..diag::NO_OFFSET }, text);
    }
}

fn tool_word(kernel: &mut Kernel<'_>) -> Option<f64> {
    kernel.take(data::TOOL).map(|d| d.value).filter(|v| (0.0..=99_999_999.0).contains(v))
}

/// Tool and offset number of a tool word.
fn split(kernel: &Kernel<'_>, word: f64) -> (u32, u32) {
    let word = word as u32;
    let digits = u32::from(kernel.channel.env.machine.tool.offset_digits);
    match 10_u32.checked_pow(digits) {
        Some(power) if digits > 0 => (word / power, word % power),
        _ => (word, 0),
    }
}

/// Constant part, plus the steps of the turret the shorter way round.
fn change_seconds(kernel: &Kernel<'_>, tool: u32) -> f64 {
    let time = &kernel.channel.env.machine.time;
    let stations = time.stations;
    let steps = if stations > 0 {
        let from = kernel.channel.state.place.tool.saturating_sub(1) % stations;
        let to = tool.saturating_sub(1) % stations;
        let ahead = (to + stations - from) % stations;
        ahead.min(stations - ahead)
    } else {
        0
    };
    time.tool_change + time.tool_step * f64::from(steps)
}
