//! Canned cycles: a code that makes a hole at each position until it is cancelled.
//!
//! Facts: reference control-emulator.md 6.4 (data, order, modality); the moves of each kind are those of the emulated
//! system's cycles. Invariants: the values of a cycle live from its first block to its cancellation and can be read
//! until the next one begins; every move inside a cycle is an ordinary motion; nothing is allocated per block.
//! Decisions: docs/emulation.md, "Canned cycles".

pub(crate) mod path;
mod webs;
mod words;

use counterpoint_channel::cycle::CycleHole;
use counterpoint_channel::modal::group;
use counterpoint_event::event::Kind as EventKind;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::cycle::HoleCycle;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::index::BySlot;
use counterpoint_machine::model::DistanceMode;
use counterpoint_machine::model::MachineKind;
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::PendingCode;

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use crate::entry::CompensationEffect;
use crate::entry::entry_of_kind;
use crate::time::check_feed;
use counterpoint_channel::path_lengths::polar_words_again;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Cycle(kind) => |act, row, code| cycle(act, kind, row, code))
        .contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::CYCLE_ON], on).contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::CYCLE_OFF], |act, _, _| off(act)),
    ActionEntry::of(&[codes::RIGID_ON], |act, _, _| rigid(act, true)),
    ActionEntry::of(&[codes::RIGID_OFF], |act, _, _| rigid(act, false)),
];

/// A cycle code: takes its data, and makes its holes if the block has a position.
pub(crate) fn cycle(act: &mut ActionContext<'_, '_>, kind: HoleCycle, row: &CodeRow, code: &PendingCode) -> Acted {
    if act.channel().state.cycle.activator && code.modal {
        return Ok(());
    }
    let positioned = has_position(act);
    let Some((role, axis)) = axis_of(act, row) else {
        let text = format!(
            "channel {} has no axis for the depth of '{}'",
            act.channel().at.channel,
            act.channel().block_text()
        );
        act.diagnose(&diag::CYCLE_AXIS, text);
        return Ok(());
    };
    let other = act.channel().state.cycle.running && act.channel().state.cycle.code != Some(row.id);
    if other && act.channel().env.machine.cycles.cancel_required {
        not_cancelled(act);
    }
    if kind.bores_back() && act.channel().state.cycle.code != Some(row.id) {
        // Its clearance is the current level unless the block gives it.
        act.channel_mut().state.cycle.heights.clear = None;
    }
    let level = act.channel().cycle_level(axis);
    let machine = act.channel().env.machine;
    act.channel_mut().state.cycle.begin(machine, kind, row.id, ((role, axis), level));
    act.channel_mut().state.cycle.block = act.channel().at.blocks;
    let (kind, words) = words::take(act, kind);
    if kind.is_rigid() {
        super::spindle::tap_speed(act)?;
    }
    if act.channel().state.cycle.activator || !positioned {
        return Ok(());
    }
    holes(act, kind, &words)
}

/// Executes the cycle that was defined before.
pub(crate) fn on(act: &mut ActionContext<'_, '_>, row: &CodeRow, code: &PendingCode) -> Acted {
    if code.modal && !has_position(act) {
        return Ok(());
    }
    let (Some(kind), Some((_, axis))) =
        (HoleCycle::numbered(act.channel().state.cycle.number), act.channel().state.cycle.axis)
    else {
        let text = format!("no cycle has been defined for '{}'", act.channel().block_text());
        act.diagnose(&diag::NO_CYCLE, text);
        return Ok(());
    };
    if !act.channel().state.cycle.running {
        act.channel_mut().state.cycle.heights.initial = act.channel().cycle_level(axis);
    }
    act.channel_mut().state.cycle.block = act.channel().at.blocks;
    act.channel_mut().state.cycle.running = true;
    act.channel_mut().state.cycle.code = act.channel().state.cycle.code.or(Some(row.id));
    let words = words::take_position(act);
    if words.coded & axis.bit() != 0 {
        act.channel_mut().state.cycle.heights.reference = words.target.at(axis);
    }
    holes(act, kind, &words)
}

/// Cancels the cycle.
pub(crate) fn off(act: &mut ActionContext<'_, '_>) -> Acted {
    end(act);
    super::mode::mode(act, "cycle off")
}

/// Ends the cycle, and with it the taps that a code has made rigid.
fn end(act: &mut ActionContext<'_, '_>) {
    act.channel_mut().state.cycle.end();
    end_rigid(act);
}

/// Ends rigid tapping at the end of a cycle, and at a cycle that does not tap.
fn end_rigid(act: &mut ActionContext<'_, '_>) {
    act.channel_mut().state.cycle.rigid = 0.0;
    if act.channel().state.modal.code(group::RIGID) == Some(codes::RIGID_ON) {
        act.channel_mut().state.modal.activate(group::RIGID, codes::RIGID_OFF, None);
    }
}

/// Rigid tapping on or off.
pub(crate) fn rigid(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    act.channel_mut().state.cycle.rigid = if on { 2.0 } else { 0.0 };
    super::mode::mode(act, if on { "rigid tapping on" } else { "rigid tapping off" })
}

/// A motion code of the program while a cycle is in effect. One that is in the block of the cycle, or that a macro
/// gives, belongs to the cycle.
#[cold]
pub(crate) fn meets_motion(act: &mut ActionContext<'_, '_>) -> Acted {
    let inside = act.is_inside_macro();
    if inside || act.channel().state.cycle.block == act.channel().at.blocks {
        return Ok(());
    }
    if act.channel().env.machine.cycles.cancel_required {
        not_cancelled(act);
    }
    if act.channel().env.machine.cycles.motion_cancels {
        end(act);
        let off = act.channel().state.cycle.off;
        act.channel_mut().state.modal.activate(group::CYCLE, codes::CYCLE_OFF, off);
        act.channel_mut().emit(0, EventKind::mode("cycle off"));
    }
    Ok(())
}

fn not_cancelled(act: &mut ActionContext<'_, '_>) {
    let text = format!(
        "the cycle is still active in '{}'; this control requires its cancellation first",
        act.channel().block_text()
    );
    act.diagnose(&diag::CYCLE_NOT_CANCELLED, text);
}

/// Whether words of a position or a height are free in the block.
fn has_position(act: &ActionContext<'_, '_>) -> bool {
    act.has_motion_word() || !act.channel().block.added.is_empty()
}

/// Role and channel axis along which a cycle works: that of its row, otherwise the axis normal to the plane; Z on a
/// lathe.
fn axis_of(act: &ActionContext<'_, '_>, row: &CodeRow) -> Option<(usize, AxisSlot)> {
    let axis =
        |role: usize| act.channel().state.place.layout.cartesian.get(role).copied().flatten().map(|axis| (role, axis));
    if let Some(role) = row.axis {
        return axis(usize::from(role));
    }
    let turning = matches!(act.channel().env.machine.kind, MachineKind::Lathe | MachineKind::MergingLathe);
    let role = match act.channel().state.modal.code(group::PLANE) {
        _ if turning => 2,
        Some(codes::PLANE_ZX) => 1,
        Some(codes::PLANE_YZ) => 0,
        _ => 2,
    };
    axis(role).or_else(|| axis(2))
}

/// Makes the holes of a block: one, or as many as it says.
fn holes(act: &mut ActionContext<'_, '_>, kind: HoleCycle, words: &words::CycleTarget) -> Acted {
    if words.times == 0 {
        return Ok(());
    }
    let from = act.channel().state.place.programmed();
    check_feed(act, act.channel().state.cycle.rates.feed.0)?;
    let marked = kind.is_rigid() && act.channel().state.cycle.rigid == 2.0;
    if marked && act.channel().state.spindle.id.is_some() && act.spindle_speed()?.is_none() {
        let text = format!("the speed of a rigid tap is zero or not programmed in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::TAP_SPEED, text));
    }
    let Some(mut hole) = heights(act, kind, words) else { return Ok(()) };
    // The path to the hole includes a change of the length that has not been travelled yet.
    act.channel_mut().state.place.ways_travelled(hole.axis.bit());
    for pass in 0..words.times {
        if pass > 0 {
            act.count_as_block()?;
            for (index, (slot, (target, from))) in hole.target.iter_mut().zip(words.target.iter().zip(from)).enumerate()
            {
                if words.relative & 1 << index != 0 {
                    *slot += target - from;
                }
            }
            polar_words_again(act.channel(), &mut hole.target);
        }
        act.cycle_event(&hole)?;
    }
    Ok(())
}

/// The heights of a hole from the data of the cycle.
fn heights(act: &mut ActionContext<'_, '_>, kind: HoleCycle, words: &words::CycleTarget) -> Option<CycleHole> {
    let state = act.channel().state.cycle;
    let (_, axis) = state.axis?;
    let base = if state.activator { state.heights.reference } else { state.heights.initial };
    let bottom = state.heights.bottom.map(|height| height.from(base));
    let distance = act.channel().env.machine.cycles.clearance == DistanceMode::Incremental;
    if state.heights.clear.is_none()
        && !kind.bores_back()
        && !distance
        && act.channel().env.machine.cycles.clearance_required
    {
        let text = format!(
            "a cycle needs its clearance height, '{}' starts at the current position",
            act.channel().block_text()
        );
        act.diagnose(&diag::DATA_MISSING, text);
    }
    if kind.bores_back() && bottom.is_none() {
        let text =
            format!("back boring needs its lower clearance in '{}', nothing is bored", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
    }
    let clear = state.heights.clear.map_or(base, |height| height.from(base));
    let start = if kind.bores_back() { bottom.unwrap_or(clear) } else { clear };
    let depth = state.heights.depth.map(|height| height.from(start));
    if depth.is_none() {
        let text = format!("a cycle needs its depth in '{}', nothing is drilled", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
    }
    let stays = act.channel().state.modal.code(group::RETRACT) == Some(codes::CYCLE_RETRACT_R) && !kind.bores_back();
    let wanted =
        if stays { clear } else { state.heights.retract.map_or(state.heights.initial, |height| height.from(base)) };
    // Never nearer to the hole than the clearance height.
    let back = match depth {
        Some(depth) if depth < clear => wanted.max(clear),
        Some(depth) if depth > clear => wanted.min(clear),
        _ => wanted,
    };
    let webs = if kind.has_webs() { webs::of_hole(act, &state, start) } else { Default::default() };
    Some(CycleHole { target: words.target, coded: words.coded, axis, clear, back, depth, bottom, webs })
}
