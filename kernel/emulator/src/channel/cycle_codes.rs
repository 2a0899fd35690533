//! Position words fire the active cycle, or the active motion code.

use super::Kernel;
use counterpoint_channel::modal::group;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::index::CodeRowId;

/// Order of a cycle that position words fire: after the codes that take such words for themselves.
const IMPLIED_ORDER: u16 = 500;

impl Kernel<'_> {
    /// Lets position words fire the active cycle, otherwise the active motion code.
    #[inline]
    pub fn imply_motion(&mut self) {
        let machine = self.channel.env.machine;
        let code = |row: CodeRowId| (machine.codes[row].id, machine.codes[row].id.kind());
        let mut in_machine = false;
        for pending in &self.channel.block.pending {
            if machine.codes[pending.row].owns_axes {
                return;
            }
            match code(pending.row) {
                (codes::CYCLE_ON, _) | (_, CodeKind::Cycle(_) | CodeKind::ThreadCycle(_)) => return,
                (codes::CYCLE_OFF, _) => return self.queue_by_data(group::MOTION),
                (codes::POSITION_MACHINE, _) => in_machine = true,
                _ => {}
            }
        }
        if in_machine || !self.channel.cycle_repeats() || self.macros.calls.inside_cycle_macro() {
            return self.queue_by_data(group::MOTION);
        }
        self.queue_by_data(group::CYCLE);
        if let Some(pending) = self.channel.block.pending.last_mut() {
            pending.order = pending.order.max(IMPLIED_ORDER);
        }
    }
}
