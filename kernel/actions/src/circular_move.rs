//! Circles that cannot be made.

use counterpoint_fault as diag;
use counterpoint_motion::arc as geometry;

use crate::context::ActionContext;
use counterpoint_channel::alarm_effect::STRAIGHT;

/// Reports a circle that cannot be made and whose end is reached straight. On some controls one to its own start by a
/// radius has no length and moves nothing in its plane.
pub(crate) fn not_made(act: &mut ActionContext<'_, '_>, error: geometry::ArcError) {
    if error == geometry::ArcError::SamePoint && act.channel().env.machine.arcs.stands {
        return;
    }
    let done = act.channel().becomes(&diag::ARC_RADIUS, STRAIGHT);
    let text = format!("the circle cannot be made: {error} in '{}', {done}", act.channel().block_text());
    act.diagnose(&diag::ARC_RADIUS, text);
}
