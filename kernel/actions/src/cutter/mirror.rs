//! The side of compensation in a frame that mirrors the plane.
//!
//! Invariant: the tool stays on the side of the contour given by the program, in any frame.

use crate::context::ActionContext;
use counterpoint_channel::modal::{group, plane};

/// Whether the local frame shows the active plane from behind: left in the program is then right of the path of the
/// tool.
pub(crate) fn is_mirrored(act: &ActionContext<'_, '_>) -> bool {
    let Some(plane) = act.channel().state.modal.code(group::PLANE).and_then(plane) else { return false };
    let values = act.channel().state.place.frame_values();
    let turned = |role: usize| {
        let mirrored = values.mirror.get(role).is_some_and(|mirror| *mirror != 0.0);
        mirrored != values.scale.get(role).is_some_and(|scale| *scale < 0.0)
    };
    turned(plane.first) != turned(plane.second)
}

/// The local frame has changed: compensation that is active changes its side with it.
pub(crate) fn frame_changed(act: &mut ActionContext<'_, '_>, was_mirrored: bool) {
    if is_mirrored(act) != was_mirrored
        && let Some(cutter) = act.channel_mut().state.place.cutter()
    {
        cutter.side = -cutter.side;
    }
}
