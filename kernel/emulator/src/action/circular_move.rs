//! Description of a circular move, shared by all actions that make circles.

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::arc as geometry;

use crate::act::ActionContext;
use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::thread::Screw;

/// A circle to be made, in the frame of its points.
#[derive(Debug, Clone, Copy)]
pub(super) struct CircularMove {
    /// Geometry, with full turns.
    pub(super) made: geometry::PlaneArc,
    pub(super) coded: u8,
    pub(super) from: Position,
    pub(super) to: Position,
    /// Channel axes of its plane.
    pub(super) axes: [AxisSlot; 2],
    pub(super) turns: u16,
    pub(super) feed: Option<f64>,
    pub(super) unit: FeedUnit,
    /// The thread that is cut along it.
    pub(super) screw: Option<Screw>,
}

/// Reports a circle that cannot be made and whose end is reached straight. On some controls one to its own start by a
/// radius has no length and moves nothing in its plane.
pub(super) fn not_made(act: &mut ActionContext<'_, '_>, error: geometry::ArcError) {
    if error == geometry::ArcError::SamePoint && act.channel().env.machine.arcs.stands {
        return;
    }
    let done = act.channel().becomes(&diag::ARC_RADIUS, STRAIGHT);
    let text = format!("the circle cannot be made: {error} in '{}', {done}", act.channel().block_text());
    act.diagnose(&diag::ARC_RADIUS, text);
}
