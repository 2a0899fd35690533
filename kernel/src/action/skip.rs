//! Probing moves: straight feed that a touch would end.
//!
//! Facts: reference control-emulator.md 6.1, system-variables.md 12. Invariant: there is no model here, so nothing is ever
//! touched: every probing move ends at its end point and counts as missed; the alarm mode decides whether that is told.

use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{MAX_AXES, Position};
use crate::machine::ident::codes;
use counterpoint_fault::Acted;

/// Modal group of the alarm mode.
const ALARM: u16 = 86;

/// What is known about probing moves.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct State {
    /// `$SKIPERR`: 0 none, 1 touched, 2 missed.
    pub(crate) result: f64,
    /// Where the last one ended, in the work frame.
    pub(crate) end: Position,
    /// Block of the last one.
    block: u64,
}

const _: () = assert!(MAX_AXES == 8, "the variables of the end count eight axes");

impl State {
    /// A probing move belongs to this block.
    pub(crate) fn acts(&self, block: u64) -> bool {
        self.block == block && self.result != 0.0
    }
}

/// A probing move.
pub(super) fn probe(kernel: &mut Kernel<'_>) -> Acted {
    let (feed, unit) = kernel.feed();
    let (coded, target) = kernel.targets();
    if coded == 0 {
        return Ok(());
    }
    kernel.feed_to(coded, target, feed, unit)?;
    *kernel.channel.state.skip =
        State { result: 2.0, end: kernel.channel.state.place.position, block: kernel.channel.at.blocks };
    if kernel.channel.state.modal.code(ALARM) == Some(codes::SKIP_ALARM_SIGNAL) {
        let text = format!("the probe has touched nothing in '{}'", kernel.block_text());
        kernel.diagnose(&diag::PROBE_MISSED, text);
    }
    Ok(())
}
