//! Points of a path in its plane, in radius values, and the corresponding positions of axes.
//!
//! *Invariant:* nothing here moves.

use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::DiagnosticFacts;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::index::BySlot;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::contour::element::Spot;
use counterpoint_motion::contour::element::direction;
use counterpoint_motion::contour::element::plus;

use crate::channel_context::ChannelContext;
use crate::cutter::CutterCompensation;
use crate::cutter::WaitingMove;

/// Coordinate of a position as geometry.
pub fn radial(channel: &ChannelContext<'_>, of: &Position, axis: AxisSlot) -> f64 {
    let scale = channel.state.place.layout.axes[axis].scale;
    of.at(axis) * scale
}

/// A position in the plane of compensation: that of the part under polar interpolation.
pub fn plane_spot(channel: &ChannelContext<'_>, of: &Position, axes: [AxisSlot; 2]) -> Spot {
    match channel.state.place.polar() {
        Some(polar) => polar.part(&channel.state.place, of),
        None => axes.map(|axis| radial(channel, of, axis)),
    }
}

/// Position of the tool's centre in the plane.
pub fn spot_of(channel: &ChannelContext<'_>, cutter: &CutterCompensation) -> Spot {
    plus(plane_spot(channel, &channel.state.place.position, cutter.axes), cutter.tip, 1.0)
}

/// The position at which the tool's centre is on a point that it reaches in a straight line; the other axes are at
/// their positions in `to`.
pub fn position_at(channel: &ChannelContext<'_>, cutter: &CutterCompensation, to: &Position, spot: Spot) -> Position {
    let mut position = *to;
    if let Some(polar) = channel.state.place.polar() {
        polar.reach_straight(&channel.state.place, &mut position, spot);
        return position;
    }
    for (axis, value) in cutter.axes.into_iter().zip(plus(spot, cutter.tip, -1.0)) {
        let scale = channel.state.place.layout.axes[axis].scale;
        *position.at_mut(axis) = crate::frames::clean(value / scale, position.at(axis));
    }
    position
}

/// The position at which the tool's centre is on a point that it reaches along an arc.
pub fn position_round(
    channel: &ChannelContext<'_>,
    cutter: &CutterCompensation,
    to: &Position,
    spot: Spot,
    made: &PlaneArc,
) -> Position {
    let mut position = position_at(channel, cutter, to, spot);
    if let Some(polar) = channel.state.place.polar() {
        polar.reach(&channel.state.place, &mut position, spot, crate::round_centre::way_round(made));
    }
    position
}

/// Whether the line of this block gets its end from the next one.
pub fn opens_line(channel: &mut ChannelContext<'_>) -> bool {
    channel.state.place.cutter().is_some_and(|cutter| cutter.asked.open.is_some())
}

/// Whether the end of the block's move is given by its distance and angle from the pole, which is the centre of a
/// circle without another centre.
pub fn ends_by_pole(channel: &mut ChannelContext<'_>) -> bool {
    channel.state.place.cutter().is_some_and(|cutter| cutter.asked.polar.is_some())
}

/// The programmed end of a move with polar coordinates: coded axes and target.
pub fn polar_end(channel: &mut ChannelContext<'_>, coded: u8, mut target: Position) -> (u8, Position) {
    let Some(cutter) = channel.state.place.cutter() else { return (coded, target) };
    let (axes, Some([radius, angle])) = (cutter.axes, cutter.asked.polar.take()) else { return (coded, target) };
    let spot = plus(flat(channel, &channel.state.arcs.pole, axes), direction(angle), radius);
    for at in [0, 1] {
        put_flat(channel, &mut target, (axes, at), spot);
    }
    (coded | axes.iter().fold(0, |bits, axis| bits | axis.bit()), target)
}

/// A programmed point in the plane, as geometry.
pub fn flat(channel: &ChannelContext<'_>, of: &Position, axes: [AxisSlot; 2]) -> Spot {
    axes.map(|axis| radial(channel, of, axis))
}

/// Sets one coordinate of a programmed point to that of a point.
pub fn put_flat(channel: &ChannelContext<'_>, position: &mut Position, (axes, at): ([AxisSlot; 2], usize), spot: Spot) {
    let (Some(axis), Some(value)) = (axes.get(at).copied(), spot.get(at)) else { return };
    let scale = channel.state.place.layout.axes[axis].scale;
    let slot = position.at_mut(axis);
    *slot = crate::frames::clean(value / scale, *slot);
}

/// The part that is missing after a move without a next one: a move after its corner, or its own end.
pub fn missing_side(channel: &ChannelContext<'_>, waits: &WaitingMove) -> Option<(&'static DiagnosticFacts, String)> {
    let block = channel.block_text();
    if waits.open.is_some() {
        let text = format!("the line of '{block}' has no end: no line with an end and an angle follows");
        return Some((&diag::LINE_WITHOUT_END, text));
    }
    let due = waits.corner.is_some_and(|corner| !corner.modal);
    due.then(|| (&diag::CORNER_ALONE, format!("no move of the plane follows the corner of '{block}'")))
}

/// After an alarm the corners that wait are not made.
pub fn forget_corners(channel: &mut ChannelContext<'_>) {
    if let Some(cutter) = channel.state.place.cutter() {
        for waiting in &mut cutter.waiting {
            (waiting.corner, waiting.open) = (None, None);
        }
    }
}
