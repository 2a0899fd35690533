//! Absolute words of rotary axes that are angles: the shorter way, or the direction of the sign.
//!
//! Facts: reference control-emulator.md 1.5 (rotary axes #n11.10, #n11.20). Decisions: half a turn goes to the positive
//! side; zero has the positive sign; a word of the angle at which the axis stands does not turn it. Positions continue
//! beyond 360 degrees, codes that unwind bring them back.

use crate::act::Act;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::Turn;

impl Act<'_, '_> {
    /// Where an absolute word turns an axis from a position; `away` is what its frame lies away from that of the
    /// position.
    #[cold]
    #[inline(never)]
    pub(super) fn turned_to(&self, axis: AxisSlot, from: f64, word: f64, away: f64) -> f64 {
        let turn = self.env.machine.axes[self.state.place.layout.axes[axis].machine].turn;
        // Polar interpolation takes the word as a length.
        if turn == Turn::Position || self.polar().is_some() {
            return word - away;
        }
        let angle = if turn == Turn::Sign { word.abs() } else { word };
        // Ahead of where the axis stands: 0 up to 360.
        let ahead = (angle - away - from).rem_euclid(360.0);
        // Rounding may leave a whole turn in place of none.
        let ahead = if (360.0 - ahead) < 1e-9 || ahead < 1e-9 { 0.0 } else { ahead };
        let back = match turn {
            Turn::Sign => word < 0.0,
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
}
