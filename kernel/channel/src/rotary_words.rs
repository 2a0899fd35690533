//! Positions to which rotary axes turn for their words.
//!
//! *Invariant:* nothing here moves.

use counterpoint_machine::ident::codes;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::RotaryPositioning;

use crate::channel_context::ChannelContext;

/// Modal group of the shorter path.
const SHORTEST: u16 = 151;

/// Position to which an absolute word turns an axis; `away` is the distance of its frame from that of the current
/// position.
#[cold]
#[inline(never)]
pub fn turned_to(channel: &ChannelContext<'_>, axis: AxisSlot, from: f64, word: f64, away: f64) -> f64 {
    let turn = channel.env.machine.axes[channel.state.place.layout.axes[axis].machine].turn;
    let as_written =
        turn == RotaryPositioning::Position && channel.state.modal.code(SHORTEST) != Some(codes::ANGLES_SHORTEST);
    // Polar interpolation takes the word as a length.
    if as_written || channel.state.place.polar().is_some() {
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
pub fn next_to(channel: &ChannelContext<'_>, axis: AxisSlot, stands: f64, point: f64) -> f64 {
    match channel.env.machine.axes[channel.state.place.layout.axes[axis].machine].turn {
        RotaryPositioning::Position => point,
        RotaryPositioning::Shortest | RotaryPositioning::Sign => {
            stands + (point - stands + 180.0).rem_euclid(360.0) - 180.0
        }
    }
}
