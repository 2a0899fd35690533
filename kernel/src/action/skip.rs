//! Probing moves: straight feed that a touch would end.
//!
//! Facts: reference control-emulator.md 6.1, system-variables.md 12. Invariant: there is no model here, so nothing is ever
//! touched: every probing move ends at its end point and counts as missed; the alarm mode decides whether that is told.

use crate::channel::Kernel;
use crate::diag;
use crate::machine::ident::codes;
use crate::state::probing::Probing;
use counterpoint_fault::Acted;

/// Modal group of the alarm mode.
const ALARM: u16 = 86;

/// A probing move.
pub(super) fn probe(kernel: &mut Kernel<'_>) -> Acted {
    let (feed, unit) = kernel.feed();
    let (coded, target) = kernel.targets();
    if coded == 0 {
        return Ok(());
    }
    kernel.feed_to(coded, target, feed, unit)?;
    *kernel.channel.state.skip =
        Probing { result: 2.0, end: kernel.channel.state.place.position, block: kernel.channel.at.blocks };
    if kernel.channel.state.modal.code(ALARM) == Some(codes::SKIP_ALARM_SIGNAL) {
        let text = format!("the probe has touched nothing in '{}'", kernel.block_text());
        kernel.diagnose(&diag::PROBE_MISSED, text);
    }
    Ok(())
}
