//! The radius of the tool, and the centre of its nose.

use counterpoint_machine::ident::{CodeId, codes};

use crate::channel_context::ChannelContext;

/// Imaginary tips: from the tip to the centre of the nose, along Z and X.
const TIPS: [[f64; 2]; 10] = [
    [0.0, 0.0],
    [-1.0, -1.0],
    [1.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [-1.0, 0.0],
    [0.0, -1.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [0.0, 0.0],
];

/// Radius that paths keep from the contour.
pub fn cutter_radius(channel: &ChannelContext<'_>, number: u32) -> f64 {
    use crate::offset_tables::{BASE, Radii};
    let own = if number == BASE { 0.0 } else { channel.worn_radius(number) };
    let base = if channel.state.place.offsets.is_some() { channel.offset_radius(Radii::Cutter, BASE) } else { 0.0 };
    own + base
}

/// From the imaginary tip to the centre of the nose, in the plane.
pub fn nose_tip(channel: &ChannelContext<'_>, number: u32, plane: CodeId) -> [f64; 2] {
    let layout = &channel.state.place.layout;
    let across = layout.cartesian.first().copied().flatten();
    let turns = across.is_some_and(|axis| channel.env.machine.axes[layout.axes[axis].machine].diameter);
    if !(turns || channel.is_turning()) || plane != codes::PLANE_ZX {
        return [0.0; 2];
    }
    TIPS.get(usize::from(channel.offset_tip(number))).copied().unwrap_or_default()
}
