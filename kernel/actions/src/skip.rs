//! Probing moves: straight feed that a touch would end.
//!
//! Facts: reference control-emulator.md 6.1, system-variables.md 12. *Invariant:* there is no model here, so nothing is
//! ever touched: every probing move ends at its end point and counts as missed; the alarm mode decides whether that is
//! reported.

use counterpoint_channel::probing::Probing;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;

use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] =
    &[ActionEntry::of(&[codes::INTERP_SKIP], |act, _, _| probe(act)).moves().contour(CompensationEffect::Leaves)];

/// Modal group of the alarm mode.
const ALARM: u16 = 86;

/// A probing move.
pub(crate) fn probe(act: &mut ActionContext<'_, '_>) -> Acted {
    let (feed, unit) = act.active_feed();
    let (coded, target) = act.targets();
    if coded == 0 {
        return Ok(());
    }
    // A probe needs no turning spindle.
    let look_above = std::mem::replace(&mut act.channel_mut().reports.plausible.look_above, f64::INFINITY);
    let moved = act.feed_to(coded, target, feed, unit);
    act.channel_mut().reports.plausible.look_above = look_above;
    moved?;
    act.channel_mut().emitter.stop_path();
    *act.channel_mut().state.skip =
        Probing { result: 2.0, end: act.channel().state.place.position, block: act.channel().at.blocks };
    if act.channel().state.modal.code(ALARM) == Some(codes::SKIP_ALARM_SIGNAL) {
        let text = format!("the probe made no contact in '{}'", act.channel().block_text());
        act.diagnose(&diag::PROBE_MISSED, text);
    }
    Ok(())
}
