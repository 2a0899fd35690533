//! Codes that the data of a block fire, and the motion that its words imply.
//!
//! Facts: reference control-emulator.md 4.2. *Invariant:* such a code acts only if some of its data are left.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::modal::group;
use counterpoint_channel::queued_codes::queue_modal;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::index::CodeRowId;

use crate::channel::plan::ExecutionPlan;

/// Order of a cycle that position words fire: after the codes that take such words for themselves.
const IMPLIED_ORDER: u16 = 500;

/// Queues the modal code of a group that data fire; the code acts only if some of the data are left by then.
pub fn queue_by_data(plan: &ExecutionPlan, channel: &mut ChannelContext<'_>, group: u16) {
    let before = channel.block.pending.len();
    queue_modal(channel, group);
    // Alone in its block it finds the data that fire it.
    if (before > 0 || !channel.state.modal.refires.is_empty() || plan.hooks.is_some())
        && let Some(pending) = channel.block.pending.get_mut(before)
    {
        pending.only_if_data_left = true;
    }
}

/// Lets position words fire the active cycle, otherwise the active motion code.
#[inline]
pub fn imply_motion(plan: &ExecutionPlan, channel: &mut ChannelContext<'_>, macros: &Runtime) {
    let machine = channel.env.machine;
    let code = |row: CodeRowId| (machine.codes[row].id, machine.codes[row].id.kind());
    let mut in_machine = false;
    for pending in &channel.block.pending {
        if machine.codes[pending.row].owns_axes {
            return;
        }
        match code(pending.row) {
            (codes::CYCLE_ON, _) | (_, CodeKind::Cycle(_) | CodeKind::ThreadCycle(_)) => return,
            (codes::CYCLE_OFF, _) => return queue_by_data(plan, channel, group::MOTION),
            (codes::POSITION_MACHINE, _) => in_machine = true,
            _ => {}
        }
    }
    if in_machine || !channel.state.cycle_repeats() || macros.calls.inside_cycle_macro() {
        return queue_by_data(plan, channel, group::MOTION);
    }
    queue_by_data(plan, channel, group::CYCLE);
    if let Some(pending) = channel.block.pending.last_mut() {
        pending.order = pending.order.max(IMPLIED_ORDER);
    }
}
