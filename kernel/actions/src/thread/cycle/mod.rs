//! Threading cycles of lathes: one pass and back, or all passes of a thread.
//!
//! Facts: reference control-emulator.md 6.5 (data, moves of a pass, depths). Invariants: a cycle ends where it began;
//! every move inside is an ordinary motion; a pass is never deeper than the end point. Decisions: docs/emulation.md,
//! "Threading cycles".

mod path;
mod words;

use counterpoint_channel::thread_passes::{MOST_PASSES, ThreadPassPlan};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::data;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::thread::{ThreadCycle, ThreadCycleSetting};
use counterpoint_machine::index::AxisSlot;

use super::Screw;
use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect, entry_of_kind};
use crate::thread::check_lead;
use crate::thread::cycle::path::{all_passes, cut_pass};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::ThreadCycle(kind) => |act, _row, _code| cycle(act, kind))
        .moves()
        .contour(CompensationEffect::Leaves),
    entry_of_kind!(CodeKind::ThreadSetting(setting) => |act, _row, _code| set(act, setting))
        .contour(CompensationEffect::Waits),
];

/// A thread to cut, in geometry units: radius values along X.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Thread {
    /// Axes of the channel along the thread and across it, and their factors to geometry.
    axes: [AxisSlot; 2],
    scales: [f64; 2],
    /// Where it begins and ends along its axis.
    begin: f64,
    end: f64,
    /// Where its end is across, at full depth.
    root: f64,
    /// How much further out it begins than it ends.
    taper: f64,
    screw: Screw,
}

/// A setting acts.
pub(crate) fn set(act: &mut ActionContext<'_, '_>, setting: ThreadCycleSetting) -> Acted {
    let mode = act.channel().state.threads.cycle.mode;
    let zigzag = |mode: u8| matches!(mode, 2 | 4);
    match setting {
        ThreadCycleSetting::Chamfer(on) => {
            act.channel_mut().state.threads.cycle.pull_out.on = on;
            if on {
                words::chamfer(act);
            }
        }
        ThreadCycleSetting::Zigzag(on) => {
            act.channel_mut().state.threads.cycle.mode = if mode >= 3 { 3 } else { 1 } + u8::from(on)
        }
        ThreadCycleSetting::Depth(true) => act.channel_mut().state.threads.cycle.mode = 3 + u8::from(zigzag(mode)),
        ThreadCycleSetting::Depth(false) if mode >= 3 => {
            act.channel_mut().state.threads.cycle.mode = 1 + u8::from(zigzag(mode))
        }
        ThreadCycleSetting::Depth(false) => {}
    }
    Ok(())
}

/// A code of a cycle: takes its data, and cuts if the block has a position.
pub(crate) fn cycle(act: &mut ActionContext<'_, '_>, kind: ThreadCycle) -> Acted {
    let axis = |role: usize| act.channel().state.place.layout.cartesian.get(role).copied().flatten();
    let (Some(x), Some(z)) = (axis(0), axis(2)) else {
        let text = format!(
            "channel {} has no X and Z for the thread of '{}'",
            act.channel().at.channel,
            act.channel().block_text()
        );
        act.diagnose(&diag::CYCLE_AXIS, text);
        return Ok(());
    };
    let axes = if kind.face { [x, z] } else { [z, x] };
    (act.channel_mut().state.threads.cycle.kind, act.channel_mut().state.threads.cycle.block) =
        (Some(kind), act.channel().at.blocks);
    if kind.multi {
        multi(act, kind, axes)?
    } else {
        single(act, kind, axes)?
    }
    crate::cutter::after_thread(act);
    Ok(())
}

/// One pass and back.
fn single(act: &mut ActionContext<'_, '_>, kind: ThreadCycle, axes: [AxisSlot; 2]) -> Acted {
    if act.channel().acting.mode_changed {
        (act.channel_mut().state.threads.cycle.end, act.channel_mut().state.threads.cycle.taper) = ([None; 2], 0.0);
    }
    let start = words::points(act, [data::THREAD_SINGLE_START_X, data::THREAD_SINGLE_START_Z], false);
    let said = words::points(act, [data::THREAD_SINGLE_END_X, data::THREAD_SINGLE_END_Z], true);
    let offset = words::values(act, [data::THREAD_SINGLE_OFFSET_X, data::THREAD_SINGLE_OFFSET_Z]);
    let across = if kind.face { data::THREAD_SINGLE_TAPER_Z } else { data::THREAD_SINGLE_TAPER_X };
    let taper = act.take(across).map(|datum| datum.value);
    let screw = words::screw(act, data::THREAD_SINGLE_PITCH, data::THREAD_SINGLE_PITCH_VAR, axes[0], None);
    words::chamfer(act);
    let cycle = &mut act.channel_mut().state.threads.cycle;
    cycle.taper = taper.unwrap_or(cycle.taper);
    for (slot, said) in cycle.end.iter_mut().zip(said) {
        *slot = said.or(*slot);
    }
    if said == [None; 2] && taper.is_none() && start == [None; 2] {
        return Ok(());
    }
    let (end, taper) = (cycle.end, cycle.taper);
    match words::thread(act, kind, axes, (start, end, offset, taper), screw) {
        Some(thread) => {
            check_lead(act, &thread.screw)?;
            cut_pass(act, &thread, thread.root, 0.0)
        }
        None => Ok(()),
    }
}

/// All passes of a thread.
fn multi(act: &mut ActionContext<'_, '_>, kind: ThreadCycle, axes: [AxisSlot; 2]) -> Acted {
    if act.channel().env.machine.threads.two_lines && !words::positioned(act) {
        return words::settings(act, kind);
    }
    act.channel_mut().state.threads.cycle.begin();
    let start = words::points(act, [data::THREAD_MULTI_START_X, data::THREAD_MULTI_START_Z], false);
    let end = words::points(act, [data::THREAD_MULTI_END_X, data::THREAD_MULTI_END_Z], true);
    let offset = words::values(act, [data::THREAD_MULTI_OFFSET_X, data::THREAD_MULTI_OFFSET_Z]);
    let across = if kind.face { data::THREAD_MULTI_TAPER_Z } else { data::THREAD_MULTI_TAPER_X };
    let taper = act.take(across).map_or(0.0, |datum| datum.value);
    words::amounts(act, kind)?;
    let starts = Some(data::THREAD_MULTI_STARTS);
    let screw = words::screw(act, data::THREAD_MULTI_PITCH, data::THREAD_MULTI_PITCH_VAR, axes[0], starts);
    if !act.channel().env.machine.threads.two_lines {
        words::packed(act)?;
    }
    words::chamfer(act);
    if end == [None; 2] && start == [None; 2] {
        return Ok(());
    }
    let Some(thread) = words::thread(act, kind, axes, (start, end, offset, taper), screw) else { return Ok(()) };
    check_lead(act, &thread.screw)?;
    all_passes(act, &thread)
}

/// The passes that the settings make of a depth.
fn plan(act: &mut ActionContext<'_, '_>) -> Result<ThreadPassPlan, Halt> {
    if act.channel().state.threads.cycle.depth.is_none() {
        let text = format!("a thread needs its depth in '{}', it is cut in one pass", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
    }
    let cycle = &act.channel().state.threads.cycle;
    let whole = |value: f64| value.clamp(0.0, MOST_PASSES as f64) as u32;
    let plan = ThreadPassPlan {
        mode: cycle.mode,
        depth: cycle.depth.unwrap_or(0.0).abs(),
        step: cycle.step.map(f64::abs),
        least: cycle.least.max(0.0),
        cuts: cycle.cuts.map(whole).filter(|cuts| *cuts > 0),
        finish_cuts: whole(cycle.finish_cuts),
        finish: cycle.finish.abs(),
    };
    if cycle.depth.is_none() {
        return Ok(ThreadPassPlan { step: None, cuts: None, finish_cuts: 0, finish: 0.0, ..plan });
    }
    let amounts = [("finishing allowance", plan.finish), ("smallest cut", plan.least)];
    if let Some((name, amount)) = amounts.into_iter().find(|(_, amount)| *amount > plan.depth + 1e-9) {
        let height = plan.depth;
        let text = format!(
            "the {name} {amount:.4} is greater than the thread height {height:.4} in '{}'; check whether its word counts \
             least increments or needs a decimal point",
            act.channel().block_text()
        );
        return Err(act.alarm(&diag::THREAD_AMOUNTS, text));
    }
    Ok(plan)
}
