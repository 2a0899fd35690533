//! Absolute words of rotary axes that are angles: the shorter path, or the direction of the sign.
//!
//! Facts: reference control-emulator.md 1.5 (rotary axes #n11.10, #n11.20), heidenhain-cycles.md 6 (M126, M127).
//! Decisions: half a turn goes to the positive side; zero has the positive sign; a word of the angle at which the axis
//! stands does not turn it. Positions continue beyond 360 degrees, codes that unwind bring them back.

use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::RotaryPositioning;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_channel::clamps::Modulo;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::ANGLES_SHORTEST], |act, _, _| shortest(act, true)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::ANGLES_AS_WRITTEN], |act, _, _| shortest(act, false)),
];

/// Modal group of the shorter path.
const SHORTEST: u16 = 151;

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

impl ActionContext<'_, '_> {
    /// Position to which an absolute word turns an axis; `away` is the distance of its frame from that of the current
    /// position.
    #[cold]
    #[inline(never)]
    pub(crate) fn turned_to(&self, axis: AxisSlot, from: f64, word: f64, away: f64) -> f64 {
        let turn = self.channel().env.machine.axes[self.channel().state.place.layout.axes[axis].machine].turn;
        let as_written = turn == RotaryPositioning::Position
            && self.channel().state.modal.code(SHORTEST) != Some(codes::ANGLES_SHORTEST);
        // Polar interpolation takes the word as a length.
        if as_written || self.channel().state.place.polar().is_some() {
            return word - away;
        }
        let angle = if turn == RotaryPositioning::Sign { word.abs() } else { word };
        // Ahead of where the axis is: 0 up to 360.
        let ahead = (angle - away - from).rem_euclid(360.0);
        // Rounding may leave a whole turn in place of none.
        let ahead = if (360.0 - ahead) < 1e-9 || ahead < 1e-9 { 0.0 } else { ahead };
        let back = match turn {
            RotaryPositioning::Sign => word < 0.0,
            _ => ahead > 180.0,
        };
        if ahead == 0.0 {
            from
        } else if back {
            from + ahead - 360.0
        } else {
            from + ahead
        }
    }

    /// The point of a roll-over axis that is nearest to its position; for another axis the point itself.
    pub(crate) fn next_to(&self, axis: AxisSlot, stands: f64, point: f64) -> f64 {
        match self.channel().env.machine.axes[self.channel().state.place.layout.axes[axis].machine].turn {
            RotaryPositioning::Position => point,
            RotaryPositioning::Shortest | RotaryPositioning::Sign => {
                stands + (point - stands + 180.0).rem_euclid(360.0) - 180.0
            }
        }
    }
}
