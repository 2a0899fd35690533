//! Description of a circular move, shared by all actions that make circles.

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::arc as geometry;

use crate::context::ActionContext;
use counterpoint_channel::alarm_effect::STRAIGHT;
use counterpoint_channel::thread::Screw;

/// A circle to be made, in the frame of its points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CircularMove {
    /// Geometry, with full turns.
    pub(crate) made: geometry::PlaneArc,
    pub(crate) coded: u8,
    pub(crate) from: Position,
    pub(crate) to: Position,
    /// Channel axes of its plane.
    pub(crate) axes: [AxisSlot; 2],
    pub(crate) turns: u16,
    pub(crate) feed: Option<f64>,
    pub(crate) unit: FeedUnit,
    /// The thread that is cut along it.
    pub(crate) screw: Option<Screw>,
}

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
