//! Absolute words of rotary axes that are angles: the shorter path, or the direction of the sign.
//!
//! Facts: reference control-emulator.md 1.5 (rotary axes #n11.10, #n11.20), heidenhain-cycles.md 6 (M126, M127).
//! Decisions: half a turn goes to the positive side; zero has the positive sign; a word of the angle at which the axis
//! stands does not turn it. Positions continue beyond 360 degrees, codes that unwind bring them back.

use counterpoint_channel::clamps::Modulo;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::RotaryPositioning;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::ANGLES_SHORTEST], |act, _, _| shortest(act, true)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::ANGLES_AS_WRITTEN], |act, _, _| shortest(act, false)),
];

/// Switches the shorter path on or off for rotary axes that have no limits and take positions.
fn shortest(act: &mut ActionContext<'_, '_>, on: bool) -> Acted {
    let axes: Vec<AxisSlot> = {
        let takes = |(_, axis): &(AxisSlot, &counterpoint_channel::channel_axis::ChannelAxis)| {
            axis.rotary
                && axis.limits.is_none()
                && act.channel().env.machine.axes[axis.machine].turn == RotaryPositioning::Position
        };
        act.channel().state.place.layout.axes.entries().filter(takes).map(|(slot, _)| slot).collect()
    };
    let was = axes.iter().any(|axis| act.channel().state.place.layout.angles & axis.bit() != 0);
    let bits = axes.iter().fold(0, |bits, axis| bits | axis.bit());
    let angles = &mut act.channel_mut().state.place.layout.angles;
    *angles = if on { *angles | bits } else { *angles & !bits };
    if was && !on {
        for axis in axes {
            act.unwind_axis(axis, Modulo::Plus);
        }
    }
    super::mode::mode(act, if on { "angles shortest" } else { "angles as written" })
}
