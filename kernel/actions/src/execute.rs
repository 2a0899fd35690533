//! Execution of a code during a cycle and along a compensated path.

use counterpoint_fault::Acted;
use counterpoint_machine::rows::CodeRow;
use counterpoint_program::block::PendingCode;

use super::entry::{ActionEntry, CompensationEffect};
use super::{cutter, cycle};
use crate::context::{ActionContext, run_in_context};

run_in_context!(ActionEntry);

impl ActionEntry {
    /// Executes the code.
    #[inline]
    pub(crate) fn execute(&self, act: &mut ActionContext<'_, '_>, row: &CodeRow, code: &PendingCode) -> Acted {
        if act.channel().state.cycle.running && self.moves && !code.modal {
            cycle::meets_motion(act)?;
        }
        if act.channel().state.place.frames.is_some() {
            cutter::before(act, self.contour, row.id)?;
        }
        if self.moves && self.contour == CompensationEffect::Follows && cutter::has_words(act, row.id) {
            return cutter::with_words(act, row.id, |act| (self.act)(act, row, code));
        }
        (self.act)(act, row, code)
    }
}
