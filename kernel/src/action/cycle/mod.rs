//! Canned cycles: a code that makes a hole at each position until it is cancelled.
//!
//! Facts: reference control-emulator.md 6.4 (data, order, modality); the moves of each kind are those of the emulated
//! system's cycles. Invariants: the values of a cycle live from its first block to its cancellation and can be read
//! until the next one begins; every move inside a cycle is an ordinary motion; nothing is allocated per block. Decisions:
//! docs/emulation.md, "Canned cycles".

mod event;
mod path;
mod webs;
mod words;

use super::Action;
use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Kind as EventKind, Position};
use crate::machine::ident::codes;
use crate::machine::ident::kind::cycle::Kind;
use crate::machine::model::{CodeRow, Heights, MachineKind};
use crate::macros::calls::Task;
use crate::state::block::Firing;
use crate::state::burden::BLOCK;
use crate::state::cycle::Hole;
use crate::state::modal::group;
use counterpoint_fault::{Acted, Halt};

/// Order of a cycle that position words fire: after the codes that take such words for themselves.
const IMPLIED_ORDER: u16 = 500;

/// A cycle code: takes its data, and makes its holes if the block has a position.
pub(super) fn cycle(kernel: &mut Kernel<'_>, kind: Kind, row: &CodeRow, firing: Firing) -> Acted {
    if kernel.channel.state.cycle.activator && firing.implied {
        return Ok(());
    }
    let positioned = has_position(kernel);
    let Some((role, axis)) = axis_of(kernel, row) else {
        let text =
            format!("channel {} has no axis for the depth of '{}'", kernel.channel.at.channel, kernel.block_text());
        kernel.diagnose(&diag::CYCLE_AXIS, text);
        return Ok(());
    };
    let other = kernel.channel.state.cycle.running && kernel.channel.state.cycle.code != Some(row.id);
    if other && kernel.channel.env.machine.cycles.cancel_required {
        not_cancelled(kernel);
    }
    if kind.bores_back() && kernel.channel.state.cycle.code != Some(row.id) {
        // Its clearance is the level where it stands unless it says so itself.
        kernel.channel.state.cycle.clear = None;
    }
    let level = kernel.channel.programmed().get(axis).copied().unwrap_or(0.0);
    kernel.channel.state.cycle.begin(kernel.channel.env.machine, kind, row.id, ((role, axis), level));
    kernel.channel.state.cycle.block = kernel.channel.at.blocks;
    let (kind, words) = words::take(kernel, kind);
    if kernel.channel.state.cycle.activator || !positioned {
        return Ok(());
    }
    holes(kernel, kind, &words)
}

/// The code that carries out the cycle that was defined before.
pub(super) fn on(kernel: &mut Kernel<'_>, row: &CodeRow, firing: Firing) -> Acted {
    if firing.implied && !has_position(kernel) {
        return Ok(());
    }
    let (Some(kind), Some((_, axis))) =
        (Kind::numbered(kernel.channel.state.cycle.number), kernel.channel.state.cycle.axis)
    else {
        let text = format!("no cycle has been defined for '{}'", kernel.block_text());
        kernel.diagnose(&diag::NO_CYCLE, text);
        return Ok(());
    };
    if !kernel.channel.state.cycle.running {
        kernel.channel.state.cycle.initial = kernel.channel.programmed().get(axis).copied().unwrap_or(0.0);
    }
    kernel.channel.state.cycle.block = kernel.channel.at.blocks;
    kernel.channel.state.cycle.running = true;
    kernel.channel.state.cycle.code = kernel.channel.state.cycle.code.or(Some(row.id));
    let words = words::take_position(kernel);
    if words.coded & 1 << axis != 0 {
        kernel.channel.state.cycle.reference = words.target.get(axis).copied().unwrap_or(0.0);
    }
    holes(kernel, kind, &words)
}

/// Cancels the cycle.
pub(super) fn off(kernel: &mut Kernel<'_>) -> Acted {
    kernel.channel.state.cycle.end();
    super::mode::mode(kernel, "cycle off")
}

/// Rigid tapping on or off.
pub(super) fn rigid(kernel: &mut Kernel<'_>, on: bool) -> Acted {
    kernel.channel.state.cycle.rigid = if on { 2.0 } else { 0.0 };
    super::mode::mode(kernel, if on { "rigid tapping on" } else { "rigid tapping off" })
}

/// A motion code of the program while a cycle is in effect. One that stands on the block of the cycle, or that a macro
/// gives, belongs to the cycle.
#[cold]
pub(super) fn meets_motion(kernel: &mut Kernel<'_>) -> Acted {
    let inside = !kernel.macros.calls.running.is_empty();
    if inside || kernel.channel.state.cycle.block == kernel.channel.at.blocks {
        return Ok(());
    }
    if kernel.channel.env.machine.cycles.cancel_required {
        not_cancelled(kernel);
    }
    if kernel.channel.env.machine.cycles.motion_cancels {
        kernel.channel.state.cycle.end();
        kernel.channel.state.modal.activate(group::CYCLE, codes::CYCLE_OFF, kernel.channel.state.cycle.off);
        kernel.emit(0, EventKind::mode("cycle off"));
    }
    Ok(())
}

fn not_cancelled(kernel: &mut Kernel<'_>) {
    let text =
        format!("the cycle is still active in '{}', this control wants it cancelled before", kernel.block_text());
    kernel.diagnose(&diag::CYCLE_NOT_CANCELLED, text);
}

/// Words of a position or a height are free on the block.
fn has_position(kernel: &Kernel<'_>) -> bool {
    kernel.channel.has_any(kernel.plan.registers.motion) || !kernel.channel.block.added.is_empty()
}

/// Role and channel axis that a cycle works along: that of its row, else the one that the plane leaves; Z on a lathe.
fn axis_of(kernel: &Kernel<'_>, row: &CodeRow) -> Option<(usize, usize)> {
    let axis = |role: usize| {
        kernel.channel.state.place.cartesian.get(role).copied().flatten().map(|axis| (role, usize::from(axis)))
    };
    if let Some(role) = row.axis {
        return axis(usize::from(role));
    }
    let turning = matches!(kernel.channel.env.machine.kind, MachineKind::Lathe | MachineKind::MergingLathe);
    let role = match kernel.channel.state.modal.code(group::PLANE) {
        _ if turning => 2,
        Some(codes::PLANE_ZX) => 1,
        Some(codes::PLANE_YZ) => 0,
        _ => 2,
    };
    axis(role).or_else(|| axis(2))
}

/// Makes the holes of a block: one, or as many as it says.
fn holes(kernel: &mut Kernel<'_>, kind: Kind, words: &words::Words) -> Acted {
    if words.times == 0 {
        return Ok(());
    }
    let from = kernel.channel.programmed();
    kernel.check_feed(kernel.channel.state.cycle.feed.0)?;
    let Some(mut hole) = heights(kernel, kind, words) else { return Ok(()) };
    for pass in 0..words.times {
        if pass > 0 {
            further(kernel)?;
            for (index, slot) in hole.target.iter_mut().enumerate() {
                if words.relative & 1 << index != 0 {
                    let change = |of: &Position| of.get(index).copied().unwrap_or(0.0);
                    *slot += change(&words.target) - change(&from);
                }
            }
        }
        kernel.cycle_event(&hole)?;
    }
    Ok(())
}

/// Between two holes of a block: others see how far this kernel is, and the limits of the job count: a hole is
/// as much work as a block.
pub(super) fn further(kernel: &mut Kernel<'_>) -> Acted {
    if !kernel.ports.coordinator.publish(kernel.channel.at.channel, kernel.channel.at.clock)
        || kernel.ports.control.cancelled()
    {
        return Err(Halt::Stopped);
    }
    kernel.work(BLOCK)?;
    kernel.check_limits()
}

/// The heights of a hole from what the cycle knows.
fn heights(kernel: &mut Kernel<'_>, kind: Kind, words: &words::Words) -> Option<Hole> {
    let state = kernel.channel.state.cycle;
    let (_, axis) = state.axis?;
    let base = if state.activator { state.reference } else { state.initial };
    let bottom = state.bottom.map(|height| height.from(base));
    let distance = kernel.channel.env.machine.cycles.clearance == Heights::Incremental;
    if state.clear.is_none() && !kind.bores_back() && !distance && kernel.channel.env.machine.cycles.clearance_required
    {
        let text = format!("a cycle needs its clearance height, '{}' starts where it stands", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
    }
    if kind.bores_back() && bottom.is_none() {
        let text = format!("back boring needs its lower clearance in '{}', nothing is bored", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
    }
    let clear = state.clear.map_or(base, |height| height.from(base));
    let start = if kind.bores_back() { bottom.unwrap_or(clear) } else { clear };
    let depth = state.depth.map(|height| height.from(start));
    if depth.is_none() {
        let text = format!("a cycle needs its depth in '{}', nothing is drilled", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
    }
    let stays = kernel.channel.state.modal.code(group::RETRACT) == Some(codes::CYCLE_RETRACT_R) && !kind.bores_back();
    let wanted = if stays { clear } else { state.retract.map_or(state.initial, |height| height.from(base)) };
    // Never nearer to the hole than the clearance height.
    let back = match depth {
        Some(depth) if depth < clear => wanted.max(clear),
        Some(depth) if depth > clear => wanted.min(clear),
        _ => wanted,
    };
    let webs = if kind.has_webs() { webs::of_hole(kernel, &state, start) } else { Default::default() };
    Some(Hole { target: words.target, coded: words.coded, axis, clear, back, depth, bottom, webs })
}

impl Kernel<'_> {
    /// Position words fire the active cycle, else the active motion code.
    #[inline]
    pub(crate) fn imply_motion(&mut self) {
        let action = |row: u16| self.plan.actions.get(usize::from(row)).copied().flatten();
        let mut in_machine = false;
        for firing in &self.channel.block.firings {
            match action(firing.row) {
                Some(Action::Cycle(_) | Action::CycleOn | Action::ThreadCycle(_)) => return,
                Some(Action::CycleOff) => return self.queue_by_data(group::MOTION),
                Some(Action::MachineFrame) => in_machine = true,
                _ => {}
            }
        }
        if in_machine || !self.cycle_repeats() || self.inside_cycle_macro() {
            return self.queue_by_data(group::MOTION);
        }
        self.queue_by_data(group::CYCLE);
        if let Some(firing) = self.channel.block.firings.last_mut() {
            firing.order = firing.order.max(IMPLIED_ORDER);
        }
    }

    /// A macro of a cycle is running: what it gives the control are the moves of that cycle.
    fn inside_cycle_macro(&self) -> bool {
        let calls = self.macros.calls.running.as_slice();
        calls.iter().any(|call| match &call.task {
            Task::Code(_, id) => Kind::of(*id).is_some() || *id == codes::CYCLE_ON,
            Task::Cycle(_) => true,
            _ => false,
        })
    }

    /// The active code of the cycle group acts on every position.
    fn cycle_repeats(&self) -> bool {
        let row = self.channel.state.modal.row(group::CYCLE);
        match row.and_then(|row| self.plan.actions.get(usize::from(row)).copied().flatten()) {
            Some(Action::Cycle(_)) => !self.channel.state.cycle.activator,
            Some(Action::CycleOn | Action::ThreadCycle(_)) => true,
            _ => false,
        }
    }

    /// Follows active codes that were set without acting: no cycle code, no cycle.
    pub(crate) fn follow_cycle(&mut self) {
        if self.channel.state.cycle.running && !self.cycle_repeats() {
            self.channel.state.cycle.end();
        }
    }
}
